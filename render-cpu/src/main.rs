//! The command `halflight`.

use clap::{Parser, Subcommand};
use halflight::commands::{compare, experiment, info, material, merge, render};
use std::error::Error;
use std::process::ExitCode;
use tracing_subscriber::filter::LevelFilter;

/// Renders Mitsuba scenes: light that other renderers lose.
#[derive(Parser)]
#[command(version, about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Print nothing but errors.
    #[arg(long, short, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Print what is done; twice for details.
    #[arg(long, short, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
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
    /// Merge images of the same scene with different samples
    Merge(merge::MergeArgs),
    /// Reproduce a statement of the papers on integrals with known answers
    Experiment(experiment::ExperimentArgs),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let level = match (cli.quiet, cli.verbose) {
        (true, _) => LevelFilter::ERROR,
        (false, 0) => LevelFilter::WARN,
        (false, 1) => LevelFilter::INFO,
        (false, _) => LevelFilter::DEBUG,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_target(false)
        .without_time()
        .with_writer(std::io::stderr)
        .init();
    match run(cli) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(cli: Cli) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    match cli.command {
        Command::Render(args) => render::run(&args, cli.quiet),
        Command::Info(args) => info::run(&args),
        Command::Material(args) => material::run(&args, cli.quiet),
        Command::Compare(args) => Ok(compare::run(&args)?),
        Command::Merge(args) => Ok(merge::run(&args)?),
        Command::Experiment(args) => Ok(experiment::run(&args)?),
    }
}
