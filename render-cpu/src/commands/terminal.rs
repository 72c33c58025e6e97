//! What the commands of both front ends share on a terminal: verbosity, and the report of an error.

use crate::say::{Notes, note};
use clap::{Args, Command, CommandFactory, FromArgMatches};
use std::error::Error;
use std::ffi::OsString;
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

/// Reads a command line. What follows an option may be a negative number: of one that cannot be, the option says so itself.
pub fn parse<C: CommandFactory + FromArgMatches>(arguments: Vec<OsString>) -> C {
    let matches = with_negative_numbers(C::command()).get_matches_from(arguments);
    C::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
}

fn with_negative_numbers(command: Command) -> Command {
    command
        .mut_args(|argument| {
            let is_option = !argument.is_positional() && argument.get_action().takes_values();
            match is_option && !argument.is_allow_hyphen_values_set() {
                true => argument.allow_negative_numbers(true),
                false => argument,
            }
        })
        .mut_subcommands(with_negative_numbers)
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
