//! `halflight experiment regularization`: kinds of regularisation on one scene for the same processor time.

use super::race_setup::{load_for_each, read_reference, show_share};
use super::render_values::parse_duration;
use super::scene_args::{SceneArgs, build_accel};
use crate::experiment::convergence::race::Budget;
use crate::experiment::convergence::{Setup, run as compare};
use crate::experiment::regularization::{VARIANTS, table};
use crate::processor::set_threads;
use crate::say::print;
use clap::Args;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

/// Compare kinds of regularisation on a scene: noise, and relative residuals against a reference.
#[derive(Args, Clone, Debug)]
pub struct RegularizationArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Algorithms to regularise.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "path,bdpt,vcm",
        conflicts_with = "integrator"
    )]
    pub integrators: Vec<String>,
    /// Only kinds whose name begins so, as in "tau 30"; may be repeated. Without regularisation is always there.
    #[arg(long, value_name = "NAME")]
    pub kind: Vec<String>,
    /// Processor time for each, of all threads together, as in 90s or 10m.
    #[arg(long, value_name = "TIME", value_parser = parse_duration, default_value = "30s", conflicts_with = "spp")]
    pub time: Duration,
    /// Samples per pixel for each, instead of a time: the same numbers every time.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Image to measure by, an OpenEXR file; without it, each is measured by a second run of its own, which shows no bias.
    #[arg(long, value_name = "R.exr")]
    pub reference: Option<PathBuf>,
    /// Seed of the random numbers.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Number of threads. Default: one per processor.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
}

/// Runs the command.
///
/// # Errors
/// What keeps the comparison from being made, in one sentence.
pub fn run(
    args: &RegularizationArgs,
    quiet: bool,
) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    set_threads(args.threads)?;
    let (mut scene, integrators) = load_for_each(&args.scene, &args.integrators)?;
    let mut competitors = Vec::new();
    for (name, plain) in &integrators {
        for variant in &VARIANTS {
            let is_asked = variant.options.is_empty()
                || args.kind.is_empty()
                || args.kind.iter().any(|k| variant.name.starts_with(k));
            if let Some(settings) = variant.of(plain)?.filter(|_| is_asked) {
                competitors.push((format!("{name}, {}", variant.name), settings));
            }
        }
    }
    let size = scene.tables.camera.crop_size;
    let reference = read_reference(args.reference.as_deref(), size)?;
    let accel = build_accel(&scene);
    let setup = Setup {
        integrators: &competitors,
        budget: args.spp.map_or(Budget::Time(args.time), Budget::Samples),
        seed: args.seed,
        reference: reference.as_ref(),
    };
    let outcomes = compare(&mut scene, &accel, &setup, |share| show_share(quiet, share))?;
    print(table(&outcomes))?;
    Ok(ExitCode::SUCCESS)
}
