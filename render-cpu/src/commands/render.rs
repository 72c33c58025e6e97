//! `halflight render`: a scene file to an EXR and a PNG.

use super::interrupt::{self, EXIT_INTERRUPTED};
use super::render_observer::RunObserver;
use super::scene_args::build_accel;
use crate::accel::Accel;
use crate::film::Film;
use crate::film::aov::Aov;
use crate::processor::set_threads;
use crate::render::progress::ProgressReport;
use crate::render::{
    MutationsPerPixel, Observer, Outcome, RenderOptions, RunState, Shape, own_layers, render, shape,
};
use crate::say::print_line;
use crate::scene::build::Scene;
use halflight_kernel::transport::integrator_kind;
use std::error::Error;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

pub use super::render_args::RenderArgs;

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

/// Runs the command with another renderer, called once: it may build what it needs first and then calls
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
    set_threads(args.threads)?;
    if args.sheet.strategy_sheet.is_some() {
        return Err("--strategy-sheet is drawn by the processor: use halflight render".into());
    }
    let start = Instant::now();
    let mut scene = args.scene.load()?;
    args.estimator.apply(&mut scene)?;
    if args.asked_layers(&scene).contains(Aov::Bandwidth)
        && !own_layers(scene.settings.kind).contains(Aov::Bandwidth)
    {
        return Err("the layer bandwidth is of adaptive photon mapping (--integrator appm)".into());
    }
    let of_chains = Aov::OF_CHAINS
        .iter()
        .find(|aov| args.asked_layers(&scene).contains(**aov));
    if let Some(aov) = of_chains
        && scene.settings.kind != integrator_kind::VEACH_MLT
    {
        return Err(
            format!("the layer {aov} is of chains of whole paths (--integrator hslt)").into(),
        );
    }
    if args.asked_layers(&scene).contains(Aov::Regularization)
        && (!scene.settings.regularization.is_some() || shape(scene.settings.kind) == Shape::Chains)
    {
        return Err(
            "the layer regularization is of --regularize and --mollify in path, bdpt and vcm"
                .into(),
        );
    }
    if args.adaptive && shape(scene.settings.kind) != Shape::Pixels {
        return Err(
            "--adaptive needs pixels that share no light: it is for path, direct and ao".into(),
        );
    }
    for warning in &scene.warnings {
        tracing::warn!("{warning}");
    }
    args.warn_of_lost_layers(&output, &scene);
    let recorded = args.record.parts(&scene)?;
    let accel = build_accel(&scene);
    tracing::info!(
        "{}: {} triangles, {} emitters, ready in {:.2} s",
        args.scene.scene.display(),
        scene.tables.triangles.len(),
        scene.tables.emitters.len(),
        start.elapsed().as_secs_f64()
    );

    let mutations = MutationsPerPixel::of(&scene);
    let options = mutations.groups(&args.options(&scene))?;
    let (mut film, mut state, checkpoint) = args.begin(&scene, &options)?;
    let stop = interrupt::request(quiet);
    let mut observer = RunObserver {
        report: ProgressReport::new(
            options.goal,
            state,
            quiet,
            mutations,
            film.statistics().len(),
        ),
        checkpoint,
        previews: args.previews(&output, &film)?,
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
    observer.previews.show(&film, true);
    // Whatever ended the run, what was rendered is kept: first where it can go on from, then as an image.
    let saved = match &mut observer.checkpoint {
        Some(checkpoint) => checkpoint.save(&state, &film),
        None => Ok(()),
    };
    if film.total_samples() == 0 {
        return match outcome? {
            Outcome::Finished => Err(format!(
                "no sample of every pixel was taken in the time given; {} is left as it was",
                output.display()
            )
            .into()),
            Outcome::Interrupted => {
                tracing::warn!(
                    "interrupted before the first sample; {} is left as it was",
                    output.display()
                );
                Ok(ExitCode::from(EXIT_INTERRUPTED))
            }
        };
    }
    if film.total_rejected() > 0 {
        tracing::warn!(
            "{} of {} samples were not finite and count as black",
            film.total_rejected(),
            film.total_samples()
        );
    }
    if let Err(error) = args.write(&output, &scene, &film, &options, &state, quiet) {
        return Err(args.write_elsewhere(error, &output, &scene, &film, &options, &state));
    }
    saved?;
    if outcome.is_ok() {
        let samples = state.samples;
        let record = &args.record;
        record.write(&recorded, &scene, &accel, &options, samples, quiet)?;
    }
    if args.json {
        let is_finished = matches!(outcome, Ok(Outcome::Finished));
        let statistics = args.statistics(&output, &scene, &film, &state, is_finished);
        print_line(format_args!("{statistics:#}"))?;
    }
    match outcome {
        Err(error) => {
            tracing::warn!("{} holds what was rendered before", output.display());
            Err(error)
        }
        Ok(Outcome::Finished) => {
            if !quiet {
                args.report(&output, &film, &state, mutations);
            }
            Ok(ExitCode::SUCCESS)
        }
        Ok(Outcome::Interrupted) => {
            if !quiet {
                args.report(&output, &film, &state, mutations);
                args.report_interruption(observer.checkpoint.is_some());
            }
            Ok(ExitCode::from(EXIT_INTERRUPTED))
        }
    }
}
