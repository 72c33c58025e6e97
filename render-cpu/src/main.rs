//! The command `halflight`.

use clap::{ArgMatches, CommandFactory, Parser, Subcommand};
use halflight::commands::terminal::{self, Verbosity};
use halflight::commands::{
    compare, experiment, farm, image, info, inspect, inspect_args, list, manual, material, merge,
    processor, render, strategy_sheet,
};
use std::error::Error;
use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;

/// Renders Mitsuba scenes: light that other renderers lose. `halflight SCENE` is short for `halflight render SCENE`.
#[derive(Parser)]
#[command(name = "halflight", version, about)]
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
    /// Look at the light of a scene: false colours, spherical plots, paths, a volume, or all of them in a page
    Inspect(inspect_args::InspectArgs),
    /// Draw a material: a lit ball, its lobes, its albedo and its local roughness
    Material(material::MaterialArgs),
    /// Compare two images
    Compare(compare::CompareArgs),
    /// Merge images of the same scene with different samples, or crops of one image
    Merge(merge::MergeArgs),
    /// Render one image as many tasks that share a folder, on a cluster for instance
    Farm(farm::FarmArgs),
    /// Convert, compare and measure image files
    Image(image::ImageArgs),
    /// List the plugins and metals that scenes may name
    List(list::ListArgs),
    /// Reproduce a statement of the papers on integrals with known answers, or compare algorithms on a scene
    Experiment(experiment::ExperimentArgs),
    /// Print completions for a shell, as in `halflight completions bash > FILE`
    Completions(manual::CompletionArgs),
    /// Print the manual page, or write those of all commands to a folder
    Manual(manual::ManualArgs),
}

fn main() -> ExitCode {
    processor::exit_unless_sufficient();
    let arguments = with_command(std::env::args_os().collect());
    let (cli, matches): (Cli, ArgMatches) = terminal::parse_with_matches(arguments);
    terminal::run(cli.verbosity, || run(cli, &matches))
}

fn run(cli: Cli, matches: &ArgMatches) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    match cli.command {
        Command::Render(args) => match &args.sheet.strategy_sheet {
            Some(sheet) => strategy_sheet::run(&args, sheet, cli.verbosity.quiet),
            None => render::run(&args, cli.verbosity.quiet),
        },
        Command::Info(args) => info::run(&args),
        Command::Inspect(args) => {
            if let Some((_, own)) = matches.subcommand() {
                args.check(own)?;
            }
            inspect::run(&args, cli.verbosity.quiet)
        }
        Command::Material(args) => material::run(&args, cli.verbosity.quiet),
        Command::Compare(args) => Ok(compare::run(&args)?),
        Command::Merge(args) => Ok(merge::run(&args)?),
        Command::Farm(args) => farm::run(&args, cli.verbosity.quiet),
        Command::Image(args) => image::run(&args),
        Command::List(args) => Ok(list::run(&args)?),
        Command::Completions(args) => Ok(manual::complete(&args, Cli::command())?),
        Command::Manual(args) => manual::manual(&args, Cli::command()),
        Command::Experiment(args) => experiment::run(&args, cli.verbosity.quiet),
    }
}

/// The arguments with `render` where a scene, or an option of `render`, stands instead of a command.
fn with_command(mut arguments: Vec<OsString>) -> Vec<OsString> {
    // These say how much is printed, whatever the command.
    let is_general = |argument: &OsString| {
        let text = argument.to_string_lossy();
        let is_short = text
            .strip_prefix("-v")
            .is_some_and(|v| v.chars().all(|c| c == 'v'));
        is_short || matches!(&*text, "-q" | "--quiet" | "--verbose")
    };
    let Some(first) = arguments.iter().skip(1).find(|a| !is_general(a)) else {
        return arguments;
    };
    let is_scene = |argument: &OsString| {
        let path = Path::new(argument);
        let extension = path.extension().unwrap_or_default();
        argument == "-" || extension.eq_ignore_ascii_case("xml") || path.is_file()
    };
    let is_command = |text: &str| {
        let cli = Cli::command();
        text == "help" || cli.find_subcommand(text).is_some()
    };
    let text = first.to_string_lossy();
    let is_render = match text.strip_prefix('-') {
        Some(_) if text != "-" => !matches!(&*text, "-h" | "--help" | "-V" | "--version"),
        _ => !is_command(&text) && is_scene(first),
    };
    if is_render {
        arguments.insert(1, "render".into());
    }
    arguments
}
