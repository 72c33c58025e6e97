//! The render loop: passes of samples over the film, on all threads, until a goal is reached.
//!
//! A sample is a function of (seed, pixel, sample index) and pixels do not share anything, so the film after a given
//! number of samples is the same to the last bit for any number of threads and any interruptions. Work is cut into
//! passes; between two passes the loop saves checkpoints, looks at the clock and at the request to stop, and, in
//! adaptive runs, decides how many samples each pixel gets next, a function of the film alone.

use crate::accel::Accel;
use crate::adaptive;
use crate::aov::AovSet;
use crate::film::{Film, FilmError};
use crate::processor;
use crate::scene::build::Scene;
use crate::tile_job::{TileJob, Workspace};
use halflight_kernel::sampler::{IndependentSampler, LaneSampler, SobolSampler, sampler_kind};
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::IntegratorSettings;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Side of the square of pixels that a thread takes at a time.
const TILE: u32 = 16;

/// Longest time that a pass should take, so that checkpoints, clocks and Ctrl-C are heeded.
const PASS_SECONDS: f64 = 2.0;

/// What ends a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// Samples per pixel, counted from the first sample of the run.
    Samples(u32),
    /// Time spent in this run.
    Time(Duration),
}

/// How a scene is rendered.
#[derive(Clone, Debug)]
pub struct RenderOptions {
    /// What ends the run.
    pub goal: Goal,
    /// Seed of the random sequence.
    pub seed: u32,
    /// Index of the first sample of every pixel.
    pub first_sample: u32,
    /// Whether samples go where the error is.
    pub adaptive: bool,
}

/// Where a run stands; kept in checkpoints.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunState {
    /// Complete passes.
    pub passes: u32,
    /// Samples per pixel on average.
    pub samples: u32,
    /// Seconds spent, earlier runs included.
    pub seconds: f64,
}

/// Why the loop returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// The goal is reached.
    Finished,
    /// Somebody asked it to stop.
    Interrupted,
}

/// What the loop tells about between two passes.
pub trait Observer {
    /// Called after every pass; an error ends the run and is handed to the caller.
    ///
    /// # Errors
    /// Whatever makes going on useless, such as a checkpoint that cannot be written.
    fn after_pass(
        &mut self,
        state: &RunState,
        film: &Film,
    ) -> Result<(), Box<dyn std::error::Error + Send + Sync>>;
}

/// An observer that looks away.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoObserver;

impl Observer for NoObserver {
    fn after_pass(
        &mut self,
        _: &RunState,
        _: &Film,
    ) -> Result<(), Box<dyn std::error::Error + Send + Sync>> {
        Ok(())
    }
}

/// Renders a scene from nothing to its goal: the short way for library users.
///
/// # Errors
/// If the film cannot be made.
pub fn render_film(
    scene: &Scene,
    options: &RenderOptions,
    aovs: AovSet,
) -> Result<Film, FilmError> {
    let camera = &scene.tables.camera;
    let [width, height] = camera.crop_size;
    let mut film = Film::new(width, height, camera.crop_offset, aovs)?;
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let mut state = RunState::default();
    let never = AtomicBool::new(false);
    // Nothing else can fail: the observer does not.
    let _ = render(
        scene,
        &accel,
        options,
        &mut film,
        &mut state,
        &never,
        &mut NoObserver,
    );
    Ok(film)
}

/// What a pass failed of.
pub type PassError = Box<dyn std::error::Error + Send + Sync>;

/// What takes samples: the processor's threads, or a device of another front end.
pub trait Sampling {
    /// Adds `per_pixel` samples to every pixel, or `counts` (by rows) where given. The next sample of a pixel has the
    /// index [`RenderOptions::first_sample`] plus the pixel's count.
    ///
    /// # Errors
    /// Whatever makes going on impossible. The film then holds complete layers of samples.
    fn pass(
        &mut self,
        film: &mut Film,
        per_pixel: u32,
        counts: Option<&[u32]>,
    ) -> Result<(), PassError>;
}

/// Renders passes into `film` on all threads until the goal or until `stop` is set.
///
/// # Errors
/// What the observer returned; the film is complete up to the last pass.
pub fn render(
    scene: &Scene,
    accel: &Accel,
    options: &RenderOptions,
    film: &mut Film,
    state: &mut RunState,
    stop: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Outcome, PassError> {
    let mut threads = ThreadSampling {
        scene,
        accel,
        options,
    };
    render_with(&mut threads, options, film, state, stop, observer)
}

/// Samples taken by all threads of the processor.
pub struct ThreadSampling<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its ray tracer.
    pub accel: &'a Accel,
    /// Seed and first sample.
    pub options: &'a RenderOptions,
}

impl Sampling for ThreadSampling<'_> {
    fn pass(
        &mut self,
        film: &mut Film,
        per_pixel: u32,
        counts: Option<&[u32]>,
    ) -> Result<(), PassError> {
        let tables = self.scene.tables.view();
        let traverse = self.accel.traverse(tables);
        let view = SceneView {
            tables,
            traverse: &traverse,
        };
        render_pass(
            &view,
            &self.scene.settings,
            self.scene.sampler,
            self.options,
            film,
            per_pixel,
            counts,
        );
        Ok(())
    }
}

/// Renders passes of `sampling` into `film` until the goal or until `stop` is set.
///
/// # Errors
/// What a pass or the observer returned; the film is complete up to the last layer of samples.
pub fn render_with(
    sampling: &mut dyn Sampling,
    options: &RenderOptions,
    film: &mut Film,
    state: &mut RunState,
    stop: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Outcome, PassError> {
    let start = Instant::now();
    let seconds_before = state.seconds;
    let mut seconds_per_sample = None;
    loop {
        let elapsed = start.elapsed();
        let left = match options.goal {
            Goal::Samples(n) => n.saturating_sub(state.samples),
            Goal::Time(limit) => {
                if elapsed >= limit {
                    0
                } else {
                    u32::MAX - options.first_sample - state.samples
                }
            }
        };
        if left == 0 {
            return Ok(Outcome::Finished);
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(Outcome::Interrupted);
        }
        let per_pixel = if options.adaptive {
            // Where adaptive passes begin decides the image, so their size may not depend on the clock.
            adaptive_pass_size(state.samples).min(left)
        } else {
            let budget = match options.goal {
                Goal::Time(limit) => (limit - elapsed).as_secs_f64().min(PASS_SECONDS),
                Goal::Samples(_) => PASS_SECONDS,
            };
            pass_size(seconds_per_sample, budget).min(left)
        };
        let counts = options
            .adaptive
            .then(|| adaptive::next_sample_counts(film, per_pixel));
        let pass_start = Instant::now();
        let pass = sampling.pass(film, per_pixel, counts.as_deref());
        if pass.is_err() && !options.adaptive {
            // A pass that broke off may have added some layers.
            let least = film.statistics().iter().map(|p| p.count).min();
            state.samples = least.unwrap_or(state.samples);
            state.seconds = seconds_before + start.elapsed().as_secs_f64();
        }
        pass?;
        seconds_per_sample = Some(pass_start.elapsed().as_secs_f64() / f64::from(per_pixel));
        state.passes += 1;
        state.samples += per_pixel;
        state.seconds = seconds_before + start.elapsed().as_secs_f64();
        observer.after_pass(state, film)?;
    }
}

/// Samples per pixel of a pass that takes about `budget` seconds.
fn pass_size(seconds_per_sample: Option<f64>, budget: f64) -> u32 {
    match seconds_per_sample {
        None => 1,
        Some(cost) => (budget / cost.max(1e-9)).clamp(1.0, 64.0) as u32,
    }
}

/// Uniform passes until the statistics say something, then passes of an eighth of what is there.
fn adaptive_pass_size(samples: u32) -> u32 {
    if samples < adaptive::UNIFORM_SAMPLES {
        adaptive::UNIFORM_SAMPLES - samples
    } else {
        (samples / 8).clamp(4, 64)
    }
}

/// Adds `per_pixel` samples to every pixel, or `counts` where given.
fn render_pass<T: Traverse + Sync>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    kind: u32,
    options: &RenderOptions,
    film: &mut Film,
    per_pixel: u32,
    counts: Option<&[u32]>,
) {
    let job = TileJob {
        view,
        settings,
        options,
        needs_surface: film.aovs().needs_surface(),
        vectors: processor::vectors(),
    };
    // Compiled once per sampler, so that numbers are drawn without a choice and a call each.
    if kind == sampler_kind::SOBOL {
        sample_tiles(&job, film, per_pixel, counts, SobolSampler::new);
    } else {
        sample_tiles(&job, film, per_pixel, counts, IndependentSampler::new);
    }
}

/// [`render_pass`] with a sampler of (seed, pixel, sample).
fn sample_tiles<T: Traverse + Sync, S: LaneSampler + Send>(
    job: &TileJob<'_, T>,
    film: &mut Film,
    per_pixel: u32,
    counts: Option<&[u32]>,
    new: impl Fn(u32, u32, u32) -> S + Sync,
) {
    let width = film.width();
    let count = |x: u32, y: u32| match counts {
        Some(counts) => counts[y as usize * width as usize + x as usize],
        None => per_pixel,
    };
    // As many as there are threads, however finely the work is divided.
    let idle = Mutex::new(Vec::new());
    film.tiles_mut(TILE).into_par_iter().for_each(|mut tile| {
        let lock = || idle.lock().unwrap_or_else(PoisonError::into_inner);
        let workspace = lock().pop();
        let mut workspace = workspace.unwrap_or_else(Workspace::new);
        job.sample_tile(&mut workspace, &mut tile, count, &new);
        lock().push(workspace);
    });
}
