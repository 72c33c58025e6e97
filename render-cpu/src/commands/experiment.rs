//! `halflight experiment`: what the papers prove, reproduced, and algorithms compared on a scene.

use super::chains_experiment::{self, ChainsArgs};
use super::convergence::{self, ConvergenceArgs};
use super::output_file;
use super::regularization_experiment::{self, RegularizationArgs};
use crate::experiment::{ALL, Experiment};
use crate::plot::{PlotError, write_png};
use crate::say::{print, print_line};
use clap::{Args, Subcommand};
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Reproduce a statement of the papers on integrals with known answers, or compare algorithms on a scene.
#[derive(Args, Clone, Debug)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct ExperimentArgs {
    /// An experiment that needs a scene.
    #[command(subcommand)]
    pub on_scene: Option<SceneExperiment>,
    /// The experiment; `list` names them all.
    #[arg(value_name = "NAME", required = true)]
    pub name: Option<String>,
    /// Write the diagrams to a PNG.
    #[arg(short, long, value_name = "PLOT.png")]
    pub output: Option<PathBuf>,
    /// Fewer samples: a first impression in about a second.
    #[arg(long)]
    pub quick: bool,
}

/// Experiments that need a scene.
#[derive(Subcommand, Clone, Debug)]
pub enum SceneExperiment {
    /// Compare algorithms on a scene: images of equal processor time against a reference, error over time
    Convergence(Box<ConvergenceArgs>),
    /// Compare kinds of regularisation on a scene: noise, and relative residuals against a reference
    Regularization(Box<RegularizationArgs>),
    /// Count what walks of half-vector mutations and of manifold exploration come to on a scene
    Chains(Box<ChainsArgs>),
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
pub fn run(args: &ExperimentArgs, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    match &args.on_scene {
        Some(SceneExperiment::Convergence(args)) => return convergence::run(args, quiet),
        Some(SceneExperiment::Regularization(args)) => {
            return regularization_experiment::run(args, quiet);
        }
        Some(SceneExperiment::Chains(args)) => return chains_experiment::run(args),
        None => {}
    }
    let name = args.name.as_deref().unwrap_or("list");
    if name == "list" {
        for experiment in &ALL {
            print_line(format_args!("{:<24}{}", experiment.name, experiment.about))?;
        }
        let about = "algorithms on a scene of yours for the same time; see its --help";
        print_line(format_args!("{:<24}{about}", "convergence"))?;
        let about = "kinds of regularisation on a scene of yours; see its --help";
        print_line(format_args!("{:<24}{about}", "regularization"))?;
        let about = "walks in half-vector space on a scene of yours; see its --help";
        print_line(format_args!("{:<24}{about}", "chains"))?;
        return Ok(ExitCode::SUCCESS);
    }
    let Some(experiment) = find(name) else {
        return Err(ExperimentError::Unknown(name.to_owned()).into());
    };
    if let Some(path) = &args.output {
        output_file::check(path, &["png"], [])?;
    }
    let started = Instant::now();
    let report = (experiment.run)(args.quick);
    tracing::info!(
        "{} took {:.1} s",
        experiment.name,
        started.elapsed().as_secs_f64()
    );
    print(&report.text)?;
    if let Some(path) = &args.output {
        write_png(path, &report.plots)?;
    }
    Ok(ExitCode::SUCCESS)
}
