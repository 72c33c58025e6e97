//! `halflight render`: a scene file to an EXR and a PNG.

use super::estimator_args::EstimatorArgs;
use super::render_observer::RunObserver;
use super::render_values::{parse_aov, parse_duration, parse_exposure, parse_range};
use super::scene_args::{SceneArgs, build_accel};
use crate::accel::Accel;
use crate::film::Film;
use crate::film::aov::{Aov, AovSet};
use crate::film::checkpoint::{Settings, load_checkpoint};
use crate::image::png_output::Exposure;
use crate::render::progress::ProgressReport;
use crate::render::record::run_settings;
use crate::render::{
    CheckpointFile, Goal, Observer, Outcome, RenderOptions, RunState, Shape, render, shape,
};
use crate::scene::build::Scene;
use clap::Args;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Exit code of a run that was interrupted, as shells report SIGINT.
const EXIT_INTERRUPTED: u8 = 130;

/// Render a scene.
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    /// The scene.
    #[command(flatten)]
    pub scene: SceneArgs,
    /// The algorithm's own.
    #[command(flatten)]
    pub estimator: EstimatorArgs,
    /// Image to write; a PNG of the same name goes beside it. Default: the scene's name with .exr, in the working
    /// directory.
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: Option<PathBuf>,
    /// Samples per pixel. Default: what the scene asks for.
    #[arg(long, value_name = "N", conflicts_with_all = ["time", "samples"], value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Time to render for, as in 90s, 10m or 1h30m.
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    pub time: Option<Duration>,
    /// Samples FROM (included) to TO (excluded) of every pixel, so that several machines share one image; see merge.
    #[arg(long, value_name = "FROM..TO", value_parser = parse_range, conflicts_with_all = ["time", "adaptive"])]
    pub samples: Option<(u32, u32)>,
    /// Seed of the random numbers. Default: the scene's, or 0.
    #[arg(long, value_name = "N")]
    pub seed: Option<u32>,
    /// Number of threads. Default: one per processor. The image does not depend on it.
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
    /// Spend samples where the error is.
    #[arg(long)]
    pub adaptive: bool,
    /// Layers to write beside the image: albedo, normal, depth, position, uv, variance, samples.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = parse_aov)]
    pub aov: Vec<Aov>,
    /// Save the state of the run here now and then, and when it is interrupted.
    #[arg(long, value_name = "FILE")]
    pub checkpoint: Option<PathBuf>,
    /// Time between two checkpoints.
    #[arg(long, value_name = "TIME", default_value = "30s", value_parser = parse_duration)]
    pub checkpoint_interval: Duration,
    /// Go on from a checkpoint; it is also saved there, unless --checkpoint names another file.
    #[arg(long, value_name = "FILE")]
    pub resume: Option<PathBuf>,
    /// Write a tone-mapped PNG beside the EXR (the default).
    #[arg(long, overrides_with = "no_png")]
    pub png: bool,
    /// Write no PNG.
    #[arg(long)]
    pub no_png: bool,
    /// Exposure of the PNG in stops, or "auto".
    #[arg(long, value_name = "EV", default_value = "0", value_parser = parse_exposure, allow_hyphen_values = true)]
    pub exposure: Exposure,
    /// Write colours as 16-bit floats.
    #[arg(long)]
    pub half: bool,
}

/// Runs the command on the processor's threads.
///
/// # Errors
/// What keeps the image from being made or written, in one sentence.
pub fn run(args: &RenderArgs, quiet: bool) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    run_with(args, quiet, |job, film, state, stop, observer| {
        render(
            job.scene,
            job.accel,
            job.options,
            film,
            state,
            stop,
            observer,
        )
    })
}

/// What is to be rendered.
#[derive(Clone, Copy)]
pub struct Job<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its ray tracer.
    pub accel: &'a Accel,
    /// Goal, seed and first sample.
    pub options: &'a RenderOptions,
}

/// Runs the command with another way of rendering, called once: it may build what it needs first and then calls
/// [`crate::render::render_with`].
///
/// # Errors
/// What keeps the image from being made or written, in one sentence. What was rendered before an error is written.
pub fn run_with(
    args: &RenderArgs,
    quiet: bool,
    render: impl FnOnce(
        Job<'_>,
        &mut Film,
        &mut RunState,
        &AtomicBool,
        &mut dyn Observer,
    ) -> Result<Outcome, Box<dyn Error + Send + Sync>>,
) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    let output = args.output_path()?;
    args.set_threads()?;
    if args.estimator.strategy_sheet.is_some() {
        return Err("--strategy-sheet is drawn by the processor: use halflight render".into());
    }
    let start = Instant::now();
    let mut scene = args.scene.load()?;
    args.estimator.apply(&mut scene)?;
    if args.adaptive && shape(scene.settings.kind) != Shape::Pixels {
        return Err(
            "--adaptive needs pixels that share no light: it is for path, direct and ao".into(),
        );
    }
    for warning in &scene.warnings {
        tracing::warn!("{warning}");
    }
    let accel = build_accel(&scene);
    tracing::info!(
        "{}: {} triangles, {} emitters, ready in {:.2} s",
        args.scene.scene.display(),
        scene.tables.triangles.len(),
        scene.tables.emitters.len(),
        start.elapsed().as_secs_f64()
    );

    let mut aovs = AovSet::NONE.with(Aov::Samples);
    for aov in scene.layers.iter().chain(args.aov.iter().copied()) {
        aovs = aovs.with(aov);
    }
    let options = args.options(&scene);
    let checkpoint = args.checkpoint.clone().or_else(|| args.resume.clone());
    // Only checkpoints hold them, and the tables of a large scene take a while to read.
    let settings = match checkpoint {
        Some(_) => run_settings(&args.scene.scene, &scene, &options, aovs),
        None => Settings::new(),
    };
    let (mut film, mut state) = match &args.resume {
        Some(path) => {
            let (progress, film) = load_checkpoint(path, &settings)?;
            let state = RunState {
                passes: progress.passes,
                samples: progress.next_sample,
                seconds: progress.render_seconds,
            };
            tracing::info!("resumed after {} samples per pixel", state.samples);
            (film, state)
        }
        None => {
            let camera = &scene.tables.camera;
            let [width, height] = camera.crop_size;
            (
                Film::new(width, height, camera.crop_offset, aovs)?,
                RunState::default(),
            )
        }
    };

    let stop = Arc::new(AtomicBool::new(false));
    install_handler(&stop);
    let mut observer = RunObserver {
        report: ProgressReport::new(options.goal, state, quiet),
        checkpoint: checkpoint
            .map(|path| CheckpointFile::new(path, settings, args.checkpoint_interval, &state)),
    };
    let outcome = render(
        Job {
            scene: &scene,
            accel: &accel,
            options: &options,
        },
        &mut film,
        &mut state,
        &stop,
        &mut observer,
    );
    observer.report.finish();
    // Whatever ended the run, what was rendered is kept.
    if let Some(checkpoint) = &mut observer.checkpoint
        && !matches!(outcome, Ok(Outcome::Finished))
    {
        checkpoint.save(&state, &film)?;
    }
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) => {
            if film.total_samples() > 0 {
                args.write(&output, &scene, &film, &options, &state)?;
                tracing::warn!("{} holds what was rendered before", output.display());
            }
            return Err(error);
        }
    };
    if film.total_rejected() > 0 {
        tracing::warn!(
            "{} of {} samples were not finite and count as black",
            film.total_rejected(),
            film.total_samples()
        );
    }
    args.write(&output, &scene, &film, &options, &state)?;
    if !quiet {
        args.report(&output, &state);
    }
    match outcome {
        Outcome::Finished => {
            if let Some(checkpoint) = &mut observer.checkpoint {
                checkpoint.save(&state, &film)?;
            }
            Ok(ExitCode::SUCCESS)
        }
        Outcome::Interrupted => {
            tracing::warn!(
                "interrupted after {} samples per pixel; {} holds what there is",
                state.samples,
                output.display()
            );
            Ok(ExitCode::from(EXIT_INTERRUPTED))
        }
    }
}

impl RenderArgs {
    pub(super) fn set_threads(&self) -> Result<(), rayon::ThreadPoolBuildError> {
        match self.threads {
            Some(threads) => rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build_global(),
            None => Ok(()),
        }
    }

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

/// The first Ctrl-C requests a regular end of the run, a second one ends the program at once.
fn install_handler(stop: &Arc<AtomicBool>) {
    let stop = stop.clone();
    let installed = ctrlc::set_handler(move || {
        if stop.swap(true, Ordering::Relaxed) {
            std::process::exit(EXIT_INTERRUPTED.into());
        }
    });
    if let Err(error) = installed {
        tracing::debug!("Ctrl-C ends the program at once: {error}");
    }
}
