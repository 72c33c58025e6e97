//! `halflight completions` and `halflight manual`: what shells and `man` want to know of the command line, made of its
//! definition.

use crate::say::print;
use clap::{Args, Command};
use clap_complete::Shell;
use clap_mangen::Man;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

/// Print completions for a shell.
#[derive(Args, Clone, Debug)]
pub struct CompletionArgs {
    /// The shell.
    pub shell: Shell,
}

/// Print the manual page, or write those of all commands.
#[derive(Args, Clone, Debug)]
pub struct ManualArgs {
    /// Folder for the pages of all commands.
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

/// Prints the completions of a command.
///
/// # Errors
/// If they cannot be printed.
pub fn complete(args: &CompletionArgs, mut command: Command) -> std::io::Result<ExitCode> {
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, name, &mut script);
    print(String::from_utf8_lossy(&script))?;
    Ok(ExitCode::SUCCESS)
}

/// Prints or writes the manual of a command.
///
/// # Errors
/// If it cannot be printed or written.
pub fn manual(
    args: &ManualArgs,
    command: Command,
) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    match &args.output {
        Some(folder) => clap_mangen::generate_to(command, folder)
            .map_err(|e| format!("cannot write to {}: {e}", folder.display()))?,
        None => {
            let mut page = Vec::new();
            Man::new(command).render(&mut page)?;
            print(String::from_utf8_lossy(&page))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
