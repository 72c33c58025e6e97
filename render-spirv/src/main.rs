//! The command `halflight-gpu`.

use clap::{Parser, Subcommand};
use halflight::commands::processor;
use halflight::commands::terminal::{self, Verbosity};
use halflight_spirv::commands::{bench, devices, render};
use std::error::Error;
use std::process::ExitCode;

/// Renders Mitsuba scenes on Vulkan devices.
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
    Render(Box<render::GpuRenderArgs>),
    /// Show the devices that there are
    Devices,
    /// Measure a scene on a device and on the processor
    Bench(Box<bench::BenchArgs>),
}

fn main() -> ExitCode {
    processor::exit_unless_sufficient();
    let cli: Cli = terminal::parse(std::env::args_os().collect());
    terminal::run(cli.verbosity, || run(cli))
}

fn run(cli: Cli) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    match cli.command {
        Command::Render(args) => render::run(&args, cli.verbosity.quiet),
        Command::Devices => devices::run(),
        Command::Bench(args) => bench::run(&args),
    }
}
