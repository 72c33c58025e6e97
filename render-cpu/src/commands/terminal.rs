//! What the commands of both front ends share on a terminal: verbosity, and the report of an error.

use crate::say::{Notes, note};
use clap::Args;
use std::error::Error;
use std::io::IsTerminal;
use std::process::ExitCode;
use tracing_subscriber::filter::LevelFilter;

/// How much is said on standard error.
#[derive(Args, Clone, Copy, Debug)]
pub struct Verbosity {
    /// Print nothing but errors.
    #[arg(long, short, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print what is done; twice for every file that is read and every pass.
    #[arg(long, short, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
}

/// Runs a command; an error becomes one line on standard error and exit code 1.
pub fn run(
    verbosity: Verbosity,
    command: impl FnOnce() -> Result<ExitCode, Box<dyn Error + Send + Sync>>,
) -> ExitCode {
    let level = match (verbosity.quiet, verbosity.verbose) {
        (true, _) => LevelFilter::ERROR,
        (false, 0) => LevelFilter::WARN,
        (false, 1) => LevelFilter::INFO,
        (false, _) => LevelFilter::DEBUG,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_target(false)
        .without_time()
        .with_ansi(wants_colours())
        .with_writer(|| Notes)
        .init();
    survive_size_limits();
    match command() {
        Ok(code) => code,
        Err(error) => {
            note(format_args!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

/// A file that becomes too long shall be an error like a full disk, not the end of the program.
fn survive_size_limits() {
    #[cfg(unix)]
    // SAFETY: ignoring a signal runs no code.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Whether standard error is a terminal whose user has not refused colours (<https://no-color.org>).
fn wants_colours() -> bool {
    let is_refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    let is_dumb = std::env::var_os("TERM").is_some_and(|value| value == "dumb");
    std::io::stderr().is_terminal() && !is_refused && !is_dumb
}
