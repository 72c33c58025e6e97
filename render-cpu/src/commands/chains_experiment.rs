//! `halflight experiment chains`: what walks in half-vector space come to on one scene.

use super::scene_args::SceneArgs;
use crate::experiment::chains;
use crate::processor::set_threads;
use crate::say::print;
use clap::Args;
use std::error::Error;
use std::process::ExitCode;

/// Count what walks of half-vector mutations and of manifold exploration come to on a scene.
#[derive(Args, Clone, Debug)]
pub struct ChainsArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Mutations per pixel of each kind, rounded up to whole groups of chains.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: u32,
    /// Number of threads. Default: one per processor.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
}

/// Runs the command.
///
/// # Errors
/// What keeps the scene from being loaded.
pub fn run(args: &ChainsArgs) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    set_threads(args.threads)?;
    let mut with = args.scene.clone();
    with.integrator.get_or_insert("hslt".to_owned());
    let mut scene = with.load()?;
    for warning in &scene.warnings {
        tracing::warn!("{warning}");
    }
    print(chains::table(&chains::run(&mut scene, args.spp)))?;
    Ok(ExitCode::SUCCESS)
}
