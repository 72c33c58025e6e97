//! `halflight render --strategy-sheet`: the images of all strategies of bdpt as one picture.

use super::interrupt::{self, EXIT_INTERRUPTED};
use super::output_file;
use super::render_args::RenderArgs;
use super::scene_args::build_accel;
use crate::image::png_output::write_png_bytes;
use crate::plot::strategy_sheet::draw;
use crate::processor::set_threads;
use crate::render::progress::ProgressReport;
use crate::render::{
    MutationsPerPixel, Observer, Outcome, PassError, RunState, StrategyBackend, StrategyPyramid,
    render_with,
};
use crate::say::note;
use halflight_kernel::transport::integrator_kind;
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// Reports the progress of a sheet.
struct SheetObserver(ProgressReport);

impl Observer for SheetObserver {
    fn after_pass(&mut self, state: &RunState, film: &crate::film::Film) -> Result<(), PassError> {
        self.0.update(state, film);
        Ok(())
    }

    fn counter(&self) -> Option<Arc<AtomicU64>> {
        self.0.counter()
    }
}

/// Renders and writes the sheet.
///
/// # Errors
/// What keeps the sheet from being made or written, in one sentence.
pub fn run(
    args: &RenderArgs,
    output: &Path,
    quiet: bool,
) -> Result<ExitCode, Box<dyn Error + Send + Sync>> {
    set_threads(args.threads)?;
    let name = output.display();
    output_file::check(output, &["png"], [args.scene.scene.as_path()])?;
    if args.sheet.sheet_length == 0 {
        return Err("--sheet-length: a path has at least one edge".into());
    }
    let mut scene = args.scene.load()?;
    args.estimator.apply(&mut scene)?;
    if scene.settings.regularization.is_some() {
        return Err("--strategy-sheet shows strategies without regularisation".into());
    }
    if !scene.edits.is_empty() {
        return Err("--strategy-sheet shows strategies without edits".into());
    }
    if scene.settings.kind != integrator_kind::BIDIRECTIONAL {
        return Err(format!(
            "--strategy-sheet shows the strategies of bdpt (--integrator bdpt), not of {}",
            scene.integrator
        )
        .into());
    }
    for warning in &scene.warnings {
        tracing::warn!("{warning}");
    }
    let pyramid = StrategyPyramid::new(&scene, args.sheet.sheet_length);
    if pyramid.length == 0 {
        return Err("the scene's max_depth leaves no path to show".into());
    }
    let accel = build_accel(&scene);
    let options = args.options(&scene);
    let mut film = pyramid.film(&scene)?;
    let mut state = RunState::default();
    let mut backend = StrategyBackend {
        scene: &scene,
        accel: &accel,
        options: &options,
        pyramid,
    };
    let mut observer = SheetObserver(ProgressReport::new(
        options.goal,
        state,
        quiet,
        MutationsPerPixel(1),
        film.statistics().len(),
    ));
    let stop = interrupt::request(quiet);
    let outcome: Result<Outcome, PassError> = render_with(
        &mut backend,
        &options,
        &mut film,
        &mut state,
        &stop,
        &mut observer,
    );
    observer.0.finish();
    let outcome = outcome?;
    if film.total_samples() == 0 {
        tracing::warn!("interrupted before the first sample; {name} is left as it was");
        return Ok(ExitCode::from(EXIT_INTERRUPTED));
    }
    let bidirectional = &scene.settings.bidirectional;
    let weights = match (
        bidirectional.unweighted != 0,
        bidirectional.power_heuristic != 0,
    ) {
        (true, _) => "unweighted",
        (false, true) => "weighted by the power heuristic",
        (false, false) => "weighted by the balance heuristic",
    };
    let title = format!(
        "{}: strategies (s, t), s vertices from the light and t from the sensor, {weights}",
        args.scene
            .scene
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
    );
    let canvas = draw(pyramid, &film, &title)?;
    let [width, height] = canvas.size();
    write_png_bytes(output, width, height, canvas.rgb())?;
    if !quiet {
        note(format_args!(
            "{name}: {} strategies, {} samples per pixel in {:.1} s",
            pyramid.count(),
            state.samples,
            state.seconds
        ));
    }
    Ok(match outcome {
        Outcome::Finished => ExitCode::SUCCESS,
        Outcome::Interrupted => ExitCode::from(EXIT_INTERRUPTED),
    })
}
