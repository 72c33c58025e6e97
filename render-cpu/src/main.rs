//! The command `halflight`.

use clap::{Parser, Subcommand};
use halflight::commands::terminal::{self, Verbosity};
use halflight::commands::{
    compare, experiment, farm, info, material, merge, processor, render, strategy_sheet,
};
use std::error::Error;
use std::process::ExitCode;

/// Renders Mitsuba scenes: light that other renderers lose.
#[derive(Parser)]
#[command(version, about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    verbosity: Verbosity,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to an EXR and a PNG
    Render(render::RenderArgs),
    /// Show what a scene holds, and what of it is not supported
    Info(info::InfoArgs),
    /// Draw a material: a lit ball, its lobes, its albedo and its local roughness
    Material(material::MaterialArgs),
    /// Compare two images
    Compare(compare::CompareArgs),
    /// Merge images of the same scene with different samples, or crops of one image
    Merge(merge::MergeArgs),
    /// Render one image as many tasks that share a folder, on a cluster for instance
    Farm(farm::FarmArgs),
    /// Reproduce a statement of the papers on integrals with known answers, or compare algorithms on a scene
    Experiment(experiment::ExperimentArgs),
}

fn main() -> ExitCode {
    processor::exit_unless_sufficient();
    let cli = Cli::parse();
    terminal::run(cli.verbosity, || run(cli))
}

fn run(cli: Cli) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    match cli.command {
        Command::Render(args) => match &args.estimator.strategy_sheet {
            Some(sheet) => strategy_sheet::run(&args, sheet, cli.verbosity.quiet),
            None => render::run(&args, cli.verbosity.quiet),
        },
        Command::Info(args) => info::run(&args),
        Command::Material(args) => material::run(&args, cli.verbosity.quiet),
        Command::Compare(args) => Ok(compare::run(&args)?),
        Command::Merge(args) => Ok(merge::run(&args)?),
        Command::Farm(args) => farm::run(&args, cli.verbosity.quiet),
        Command::Experiment(args) => experiment::run(&args, cli.verbosity.quiet),
    }
}
