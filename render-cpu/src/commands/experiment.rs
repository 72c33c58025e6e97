//! `halflight experiment`: what the papers prove, reproduced.

use crate::experiment::{ALL, Experiment};
use crate::plot::{PlotError, write_png};
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Reproduce a statement of the papers on integrals with known answers.
#[derive(Args, Clone, Debug)]
pub struct ExperimentArgs {
    /// The experiment; `list` names them all.
    #[arg(value_name = "NAME")]
    pub name: String,
    /// Write the diagrams to a PNG.
    #[arg(short, long, value_name = "PLOT.png")]
    pub output: Option<PathBuf>,
    /// Fewer samples: a first impression in about a second.
    #[arg(long)]
    pub quick: bool,
}

/// Why an experiment did not run.
#[derive(Debug, thiserror::Error)]
pub enum ExperimentError {
    /// There is none of that name.
    #[error("there is no experiment '{0}'; `halflight experiment list` names them")]
    Unknown(String),
    /// The diagrams could not be written.
    #[error(transparent)]
    Plot(#[from] PlotError),
}

fn find(name: &str) -> Option<&'static Experiment> {
    ALL.iter().find(|e| e.name == name)
}

/// Runs the command.
///
/// # Errors
/// If the experiment does not exist or its diagrams cannot be written.
pub fn run(args: &ExperimentArgs) -> Result<ExitCode, ExperimentError> {
    if args.name == "list" {
        for experiment in &ALL {
            println!("{:<24}{}", experiment.name, experiment.about);
        }
        return Ok(ExitCode::SUCCESS);
    }
    let Some(experiment) = find(&args.name) else {
        return Err(ExperimentError::Unknown(args.name.clone()));
    };
    let started = Instant::now();
    let report = (experiment.run)(args.quick);
    tracing::info!(
        "{} took {:.1} s",
        experiment.name,
        started.elapsed().as_secs_f64()
    );
    print!("{}", report.text);
    if let Some(path) = &args.output {
        write_png(path, &report.plots)?;
    }
    Ok(ExitCode::SUCCESS)
}
