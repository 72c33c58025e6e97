//! One render: the library's run loop, in the thread that Python called from, without the interpreter's lock.
//!
//! The loop heeds requests to stop between its passes, of up to two seconds. Here each pass is handed on in parts of about
//! a tenth of a second, whole samples of all pixels, and between two parts the interpreter is asked for signals: Ctrl-C
//! raises KeyboardInterrupt there, which ends the render with what it has. Samples enter a pixel in the order of their
//! indices, so that the parts leave the image as it is, to the bit.

use crate::error::run_error;
use halflight::accel::Accel;
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::render::{
    Backend, CpuBackend, Goal, Observer, Outcome, PassEnd, PassError, RenderOptions, RunState,
    Stop, render_with,
};
use halflight::scene::build::Scene;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// How long a part of a pass should take.
const PART_SECONDS: f64 = 0.1;

/// What a render has come to.
pub(crate) struct Run {
    /// The pixels.
    pub film: Film,
    /// How far it came.
    pub state: RunState,
    /// Whether it was interrupted.
    pub interrupted: bool,
}

/// An exception of Python, on its way through the run loop.
#[derive(Debug)]
struct Raised(PyErr);

impl std::fmt::Display for Raised {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for Raised {}

/// A backend that looks for signals between parts of its passes.
struct Interruptible<'a> {
    backend: &'a mut dyn Backend,
    seconds_per_sample: Option<f64>,
}

impl Backend for Interruptible<'_> {
    fn pass(
        &mut self,
        film: &mut Film,
        per_pixel: u32,
        counts: Option<&[u32]>,
        stop: &Stop<'_>,
    ) -> Result<PassEnd, PassError> {
        let mut left = per_pixel;
        while left > 0 {
            let part = match (counts, self.seconds_per_sample) {
                // Counts per pixel are of the pass as a whole.
                (Some(_), _) => left,
                (None, Some(cost)) => (PART_SECONDS / cost.max(1e-9)).clamp(1.0, 64.0) as u32,
                (None, None) => 1,
            }
            .min(left);
            let start = Instant::now();
            if self.backend.pass(film, part, counts, stop)? == PassEnd::Cut {
                return Ok(PassEnd::Cut);
            }
            self.seconds_per_sample = Some(start.elapsed().as_secs_f64() / f64::from(part));
            left -= part;
            Python::attach(|py| py.check_signals()).map_err(Raised)?;
        }
        Ok(PassEnd::Complete)
    }
}

/// Tells a callable of Python how far the render is.
struct Progress<'a> {
    callback: Option<&'a Py<PyAny>>,
    goal: Goal,
    start: Instant,
}

impl Observer for Progress<'_> {
    fn after_pass(&mut self, state: &RunState, film: &Film) -> Result<(), PassError> {
        let Some(callback) = self.callback else {
            return Ok(());
        };
        let done = match self.goal {
            Goal::Samples(n) => f64::from(state.samples) / f64::from(n.max(1)),
            Goal::Time(limit) => self.start.elapsed().as_secs_f64() / limit.as_secs_f64(),
        };
        let noise = film.relative_noise();
        let arguments = (done.min(1.0), state.samples, state.seconds, noise);
        Python::attach(|py| callback.call1(py, arguments))
            .map_err(Raised)
            .map(drop)
            .map_err(PassError::from)
    }
}

/// Renders a scene to its goal; `progress` is called after every pass with (share of the goal, samples per pixel, seconds,
/// relative noise).
pub(crate) fn run(
    py: Python<'_>,
    scene: &Scene,
    accel: &Accel,
    options: &RenderOptions,
    aovs: AovSet,
    progress: Option<&Py<PyAny>>,
) -> PyResult<Run> {
    let camera = &scene.tables.camera;
    let [width, height] = camera.crop_size;
    let film = Film::new(width, height, camera.crop_offset, aovs).map_err(run_error)?;
    let mut run = Run {
        film,
        state: RunState::default(),
        interrupted: false,
    };
    let outcome = py.detach(|| {
        let mut threads = CpuBackend::new(scene, accel, options);
        let mut backend = Interruptible {
            backend: &mut threads,
            seconds_per_sample: None,
        };
        let mut observer = Progress {
            callback: progress,
            goal: options.goal,
            start: Instant::now(),
        };
        // Signals end it, never this.
        let never = AtomicBool::new(false);
        render_with(
            &mut backend,
            options,
            &mut run.film,
            &mut run.state,
            &never,
            &mut observer,
        )
    });
    match outcome {
        Ok(Outcome::Finished) => Ok(run),
        Ok(Outcome::Interrupted) => {
            run.interrupted = true;
            Ok(run)
        }
        Err(error) => match error.downcast::<Raised>() {
            Ok(raised) if raised.0.is_instance_of::<PyKeyboardInterrupt>(py) => {
                run.interrupted = true;
                Ok(run)
            }
            Ok(raised) => Err(raised.0),
            Err(other) => Err(run_error(other)),
        },
    }
}
