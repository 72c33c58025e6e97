//! The command `halflight-gpu`.

use clap::{Parser, Subcommand};
use halflight_spirv::commands::{bench, devices, render};
use std::error::Error;
use std::process::ExitCode;
use tracing_subscriber::filter::LevelFilter;

/// Renders Mitsuba scenes on Vulkan devices.
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
    Render(Box<render::GpuRenderArgs>),
    /// Show the devices that there are
    Devices,
    /// Measure a scene on a device and on the processor
    Bench(Box<bench::BenchArgs>),
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
        Command::Devices => devices::run(),
        Command::Bench(args) => bench::run(&args),
    }
}
