//! The arguments of `halflight render`.

use super::estimator_args::EstimatorArgs;
use super::look_args::LookArgs;
use super::record_args::RecordArgs;
use super::render_values::{parse_aov, parse_duration, parse_range};
use super::scene_args::SceneArgs;
use super::sheet_args::SheetArgs;
use crate::film::aov::{Aov, AovSet};
use crate::render::{Goal, RenderOptions, own_layers};
use crate::scene::build::Scene;
use clap::Args;
use std::path::PathBuf;
use std::time::Duration;

/// Render a scene.
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The algorithm's own.
    #[command(flatten)]
    pub estimator: EstimatorArgs,
    /// A sheet of all strategies.
    #[command(flatten)]
    pub sheet: SheetArgs,
    /// The record of its paths.
    #[command(flatten)]
    pub record: RecordArgs,
    /// Image to write, by its name an OpenEXR, PFM, Radiance, PNG or JPEG file; a PNG goes beside the first three. Default: the scene's name with .exr, in the working
    /// directory.
    #[arg(help_heading = "Image", short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Samples per pixel. Default: what the scene asks for.
    #[arg(help_heading = "Samples", long, value_name = "N", conflicts_with_all = ["time", "samples"], value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Time to render for, as in 90s, 10m or 1h30m.
    #[arg(help_heading = "Samples", long, value_name = "TIME", value_parser = parse_duration)]
    pub time: Option<Duration>,
    /// Samples FROM (included) to TO (excluded) of every pixel, so that several machines share one image; see merge.
    #[arg(help_heading = "Samples", long, value_name = "FROM..TO", value_parser = parse_range, conflicts_with_all = ["time", "adaptive"])]
    pub samples: Option<(u32, u32)>,
    /// Seed of the random numbers. Default: the scene's, or 0.
    #[arg(help_heading = "Samples", long, value_name = "N")]
    pub seed: Option<u32>,
    /// Number of threads. Default: one per processor. The image does not depend on it.
    #[arg(help_heading = "Machine", long, value_name = "N")]
    pub threads: Option<usize>,
    /// Spend samples where the error is.
    #[arg(help_heading = "Samples", long)]
    pub adaptive: bool,
    /// Layers to write beside the image: albedo, normal, depth, position, uv, alpha, variance, samples, or all for these;
    /// regularization, bandwidth, acceptance, iterations, jumps and mutations where an algorithm has them.
    #[arg(help_heading = "Image", long, value_name = "LIST", value_delimiter = ',', value_parser = parse_aov)]
    pub aov: Vec<AovSet>,
    /// Save the state of the run here now and then, and when it ends; if it is there already, go on from it.
    #[arg(help_heading = "Going on later", long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Time between two checkpoints.
    #[arg(help_heading = "Going on later", long, value_name = "TIME", default_value = "30s", value_parser = parse_duration)]
    pub checkpoint_interval: Duration,
    /// Go on from a checkpoint, which must be there; it is also saved there, unless --checkpoint names another file.
    #[arg(help_heading = "Going on later", long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
    /// Write a tone-mapped PNG beside the EXR (the default).
    #[arg(help_heading = "Image", long, overrides_with = "no_png")]
    pub png: bool,
    /// How the image is written.
    #[command(flatten)]
    pub look: LookArgs,
    /// Rewrite the PNG while the image is rendered.
    #[arg(help_heading = "Image", long, conflicts_with = "no_png")]
    pub live: bool,
    /// Show the image in the viewer tev while it is rendered, as in --tev localhost:14158.
    #[arg(help_heading = "Image", long, value_name = "HOST:PORT")]
    pub tev: Option<String>,
    /// Print JSON with what the run took, at its end.
    #[arg(help_heading = "Image", long)]
    pub json: bool,
}

impl RenderArgs {
    /// The layers of the image: those that are asked for, here or in the scene, and the number of samples.
    pub(super) fn layers(&self, scene: &Scene) -> AovSet {
        let of_algorithm = own_layers(scene.settings.kind);
        self.asked_layers(scene)
            .union(of_algorithm)
            .with(Aov::Samples)
    }

    /// The layers that are asked for, here or in the scene.
    pub(super) fn asked_layers(&self, scene: &Scene) -> AovSet {
        self.aov.iter().copied().fold(scene.layers, AovSet::union)
    }

    /// What the run shall do.
    pub(super) fn options(&self, scene: &Scene) -> RenderOptions {
        let (first_sample, count) = match self.samples {
            Some((from, to)) => (from, to - from),
            None => (0, self.spp.unwrap_or(scene.spp)),
        };
        RenderOptions {
            goal: match self.time {
                Some(time) => Goal::Time(time),
                None => Goal::Samples(count),
            },
            seed: self.seed.unwrap_or(scene.seed),
            first_sample,
            adaptive: self.adaptive,
        }
    }
}
