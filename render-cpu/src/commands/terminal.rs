//! What the commands of both front ends share on a terminal: verbosity, and the report of an error.

use crate::say::{Notes, note};
use clap::{ArgMatches, Args, Parser};
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

/// Reads a command line. What follows an option may be negative, as `-1` or `-5s`: of one that cannot be, the option says so itself.
pub fn parse<C: Parser>(arguments: Vec<OsString>) -> C {
    parse_with_matches(arguments).0
}

/// The same, with what it was read from, which says what was given and what is a default.
pub fn parse_with_matches<C: Parser>(arguments: Vec<OsString>) -> (C, ArgMatches) {
    let matches = C::command().get_matches_from(with_negative_values(arguments));
    match C::from_arg_matches(&matches) {
        Ok(cli) => (cli, matches),
        Err(error) => error.format(&mut C::command()).exit(),
    }
}

/// The arguments with `--option=-1` for `--option -1`.
fn with_negative_values(arguments: Vec<OsString>) -> Vec<OsString> {
    let is_option = |word: &str| word.len() > 2 && word.starts_with("--") && !word.contains('=');
    let is_negative = |word: &str| {
        let number = word.strip_prefix('-').unwrap_or_default();
        number.starts_with(|c: char| c.is_ascii_digit() || c == '.')
    };
    let end = arguments.iter().position(|word| word == "--");
    let mut joined: Vec<OsString> = Vec::new();
    for (i, word) in arguments.into_iter().enumerate() {
        let is_value = end.is_none_or(|end| i < end) && is_negative(&word.to_string_lossy());
        match joined.last_mut() {
            Some(last) if is_value && is_option(&last.to_string_lossy()) => {
                last.push("=");
                last.push(word);
            }
            _ => joined.push(word),
        }
    }
    joined
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_values_belong_to_their_options() {
        let joined = |words: &[&str]| {
            let words = words.iter().map(OsString::from).collect();
            with_negative_values(words).join(&OsString::from(" "))
        };
        for (words, expected) in [
            (&["h", "--min", "-1", "s.xml"][..], "h --min=-1 s.xml"),
            (&["h", "--crop", "-1,0,2,2"], "h --crop=-1,0,2,2"),
            (&["h", "--time", "-.5s", "-o", "x"], "h --time=-.5s -o x"),
            (&["h", "--spp=3", "-1"], "h --spp=3 -1"),
            (&["h", "-v", "-1"], "h -v -1"),
            (&["h", "--strict", "-o", "x"], "h --strict -o x"),
            (&["h", "--strict", "--", "-1.xml"], "h --strict -- -1.xml"),
            (&["h", "--strict", "-"], "h --strict -"),
        ] {
            assert_eq!(joined(words), expected);
        }
    }
}
