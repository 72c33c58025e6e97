//! The render loop: passes of samples over the film until a goal is reached.
//!
//! A sample is a function of (seed, pixel, sample index) and pixels do not share anything, so the film after a given
//! number of samples is the same to the last bit for any number of threads and any interruptions. Work is cut into
//! passes; between two passes the loop saves checkpoints, looks at the clock and at the request to stop, and, in
//! adaptive runs, decides how many samples each pixel gets next, a function of the film alone. A pass that is cut by either
//! leaves a film that says what it still owes, and the next one gives that first.

use super::backend::{Backend, PassEnd, PassError};
use super::options::{Goal, Outcome, RenderOptions, RunState};
use super::stop::Stop;
use crate::film::pending_samples::PendingSamples;
use crate::film::{Film, adaptive};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

/// Longest time that a pass should take, so that checkpoints, clocks and Ctrl-C are heeded.
const PASS_SECONDS: f64 = 2.0;

/// Receives the state of a run between two passes.
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

    /// Where passes count the samples of single pixels that they take.
    fn counter(&self) -> Option<Arc<AtomicU64>> {
        None
    }
}

/// An observer that does nothing.
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

/// Renders passes of `backend` into `film` until the goal or until `stop` is set.
///
/// # Errors
/// What a pass or the observer returned; the film is complete up to the last layer of samples.
pub fn render_with(
    backend: &mut dyn Backend,
    options: &RenderOptions,
    film: &mut Film,
    state: &mut RunState,
    stop: &AtomicBool,
    observer: &mut dyn Observer,
) -> Result<Outcome, PassError> {
    let start = Instant::now();
    let seconds_before = state.seconds;
    let mut seconds_per_sample = None;
    let mut samples_before = film.total_samples();
    let deadline = match options.goal {
        Goal::Time(limit) => start.checked_add(limit),
        Goal::Samples(_) => None,
    };
    let counter = observer.counter();
    let stop_pass = Stop::new(stop, deadline).counting(counter.as_deref());
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
        let pending = film.pending_mut().take();
        let is_rest = pending.is_some();
        let (per_pixel, counts) = match pending {
            Some(pending) if options.adaptive => (pending.per_pixel, Some(pending.counts)),
            Some(pending) => {
                let pending = pending.up_to(left);
                (pending.per_pixel, Some(pending.counts))
            }
            None if options.adaptive => {
                // Where adaptive passes begin decides the image, so their size may not depend on the clock.
                let per_pixel = adaptive_pass_size(state.samples).min(left);
                let counts = adaptive::next_sample_counts(film, per_pixel);
                (per_pixel, Some(counts))
            }
            None => {
                let budget = match options.goal {
                    Goal::Time(limit) => (limit - elapsed).as_secs_f64().min(PASS_SECONDS),
                    Goal::Samples(_) => PASS_SECONDS,
                };
                (pass_size(seconds_per_sample, budget).min(left), None)
            }
        };
        let targets = options.adaptive.then(|| targets(film, counts.as_deref()));
        let pass_start = Instant::now();
        let pass = backend.pass(film, per_pixel, counts.as_deref(), &stop_pass);
        let seconds = pass_start.elapsed().as_secs_f64();
        let is_complete = matches!(pass, Ok(PassEnd::Complete));
        if is_complete {
            state.samples += per_pixel;
        }
        match targets {
            Some(targets) if !is_complete => {
                *film.pending_mut() = Some(rest(film, per_pixel, &targets))
            }
            None if !is_complete || is_rest => {
                let counts = film.statistics().iter().map(|p| p.count);
                let (complete, pending) = PendingSamples::to_equal(counts, state.samples);
                state.samples = complete;
                *film.pending_mut() = pending;
            }
            _ => {}
        }
        let samples_after = film.total_samples();
        let taken = samples_after - samples_before;
        samples_before = samples_after;
        if taken > 0 {
            state.passes += 1;
            let per_pixel = taken as f64 / film.statistics().len() as f64;
            seconds_per_sample = Some(seconds / per_pixel);
        }
        state.seconds = seconds_before + start.elapsed().as_secs_f64();
        pass?;
        tracing::debug!("pass {}: {taken} samples in {seconds:.3} s", state.passes);
        observer.after_pass(state, film)?;
    }
}

/// Samples that each pixel has after a pass of `counts`.
fn targets(film: &Film, counts: Option<&[u32]>) -> Vec<u32> {
    let taken = film.statistics().iter().map(|p| p.count);
    let counts = counts.unwrap_or_default().iter();
    taken
        .zip(counts)
        .map(|(a, b)| a.saturating_add(*b))
        .collect()
}

/// What an adaptive pass of `per_pixel` samples still owes.
fn rest(film: &Film, per_pixel: u32, targets: &[u32]) -> PendingSamples {
    let taken = film.statistics().iter().map(|p| p.count);
    let counts = targets.iter().zip(taken);
    PendingSamples {
        per_pixel,
        counts: counts.map(|(a, b)| a.saturating_sub(b)).collect(),
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
