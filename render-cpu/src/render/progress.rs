//! Progress of a run: a bar on a terminal, plain lines elsewhere, no output with `--quiet`.
//!
//! A pass may take minutes. What it has taken so far is counted ([`super::stop::Stop::took`]), and a thread of the report's own looks at the
//! count a few times a second.

use super::chains::MutationsPerPixel;
use super::options::{Goal, RunState};
use crate::film::Film;
use crate::say::note;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Time between two reports of an unfinished pass.
const LOOK_INTERVAL: Duration = Duration::from_millis(250);

/// Steps of the bar.
const STEPS: u64 = 1000;

/// Reports the progress of one run on standard error.
pub struct ProgressReport {
    shared: Option<Arc<Shared>>,
    observer: Option<JoinHandle<()>>,
}

/// What the run and the watching thread have in common.
struct Shared {
    goal: Goal,
    start: Instant,
    samples_before: u32,
    unit: u32,
    pixels: usize,
    /// Samples of pixels that the unfinished pass has taken.
    taken: Arc<AtomicU64>,
    is_over: AtomicBool,
    shown: Mutex<Shown>,
}

struct Shown {
    display: Display,
    /// Samples per pixel and noise after the last pass.
    samples: u32,
    noise: Option<f64>,
}

enum Display {
    Bar(ProgressBar),
    Lines(Instant),
}

impl ProgressReport {
    /// A report of a run that starts at `state` with a film of so many pixels; samples count as so many mutations each.
    pub fn new(
        goal: Goal,
        state: RunState,
        quiet: bool,
        unit: MutationsPerPixel,
        pixels: usize,
    ) -> ProgressReport {
        if quiet {
            return ProgressReport {
                shared: None,
                observer: None,
            };
        }
        let display = if std::io::stderr().is_terminal() {
            let bar = ProgressBar::new(STEPS);
            // The template is a constant that parses.
            if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3}%  {msg}") {
                bar.set_style(style);
            }
            Display::Bar(bar)
        } else {
            Display::Lines(Instant::now())
        };
        let shared = Arc::new(Shared {
            goal,
            start: Instant::now(),
            samples_before: state.samples,
            unit: unit.0,
            pixels: pixels.max(1),
            taken: Arc::default(),
            is_over: AtomicBool::new(false),
            shown: Mutex::new(Shown {
                display,
                samples: state.samples,
                noise: None,
            }),
        });
        let watched = shared.clone();
        let watch = move || {
            while !watched.is_over.load(Ordering::Relaxed) {
                std::thread::park_timeout(LOOK_INTERVAL);
                watched.show(&mut watched.lock());
            }
        };
        // Without a thread it is reported between passes only.
        let observer = std::thread::Builder::new().spawn(watch).ok();
        ProgressReport {
            shared: Some(shared),
            observer,
        }
    }

    /// Where passes count what they have taken.
    pub fn counter(&self) -> Option<Arc<AtomicU64>> {
        self.shared.as_ref().map(|shared| shared.taken.clone())
    }

    /// Reports the state after a pass.
    pub fn update(&self, state: &RunState, film: &Film) {
        let Some(shared) = &self.shared else { return };
        let mut shown = shared.lock();
        shared.taken.store(0, Ordering::Relaxed);
        shown.samples = state.samples;
        shown.noise = Some(film.relative_noise());
        shared.show(&mut shown);
    }

    /// Leaves the last state on the terminal.
    pub fn finish(&mut self) {
        let Some(shared) = &self.shared else { return };
        shared.is_over.store(true, Ordering::Relaxed);
        if let Some(observer) = self.observer.take() {
            observer.thread().unpark();
            // It does nothing that could panic but write lines, which never does.
            let _ = observer.join();
        }
        if let Display::Bar(bar) = &shared.lock().display {
            bar.abandon();
        }
    }
}

impl Drop for ProgressReport {
    fn drop(&mut self) {
        self.finish();
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Shown> {
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows the state, with what the unfinished pass has taken.
    fn show(&self, shown: &mut Shown) {
        let elapsed = self.start.elapsed();
        let taken = self.taken.load(Ordering::Relaxed) as f64 / self.pixels as f64;
        let samples = f64::from(shown.samples) + taken;
        let done = match self.goal {
            Goal::Samples(n) => samples / f64::from(n.max(1)),
            Goal::Time(time) => elapsed.as_secs_f64() / time.as_secs_f64(),
        }
        .min(1.0);
        let text = self.message(samples, shown, elapsed);
        match &mut shown.display {
            Display::Bar(bar) => {
                bar.set_position((done * STEPS as f64) as u64);
                bar.set_message(text);
            }
            Display::Lines(last) => {
                if last.elapsed() >= LINE_INTERVAL {
                    *last = Instant::now();
                    note(format_args!("{:3.0}%  {text}", done * 100.0));
                }
            }
        }
    }

    /// Samples, rate, time left and noise.
    fn message(&self, samples: f64, shown: &Shown, elapsed: Duration) -> String {
        let seconds = elapsed.as_secs_f64().max(1e-9);
        let unit = f64::from(self.unit);
        let new = (samples - f64::from(self.samples_before)).max(0.0);
        let rate = new * unit * self.pixels as f64 / seconds;
        let left = match self.goal {
            Goal::Samples(n) if new > 0.0 => (f64::from(n) - samples).max(0.0) * seconds / new,
            Goal::Samples(_) => 0.0,
            Goal::Time(time) => time.saturating_sub(elapsed).as_secs_f64(),
        };
        let count = if samples == f64::from(shown.samples) {
            format!("{}", samples * unit)
        } else {
            format!("{:.1}", samples * unit)
        };
        let noise = match shown.noise {
            Some(noise) => format!("  noise {:.2}%", noise * 100.0),
            None => String::new(),
        };
        format!(
            "{count} {}  {:.2} M {}/s  {} left{noise}",
            if self.unit > 1 {
                "mutations per pixel"
            } else {
                "spp"
            },
            rate / 1e6,
            if self.unit > 1 {
                "mutations"
            } else {
                "samples"
            },
            duration(left),
        )
    }
}

fn duration(seconds: f64) -> String {
    let s = seconds.round() as u64;
    if s >= 3600 {
        format!("{}h{:02}m", s / 3600, s % 3600 / 60)
    } else if s >= 60 {
        format!("{}m{:02}s", s / 60, s % 60)
    } else {
        format!("{s}s")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_under_way_is_reported() {
        let state = RunState {
            samples: 2,
            ..RunState::default()
        };
        let mut report =
            ProgressReport::new(Goal::Samples(4), state, false, MutationsPerPixel(1), 100);
        report
            .counter()
            .expect("a counter")
            .store(50, Ordering::Relaxed);
        let shared = report.shared.clone().expect("a report");
        let text = |samples: f64| shared.message(samples, &shared.lock(), Duration::from_secs(3));
        // Half a sample of 100 pixels in three seconds, one and a half to go.
        let expected = "2.5 spp  0.00 M samples/s  9s left";
        assert_eq!(text(2.5), expected);
        assert_eq!(text(2.0), "2 spp  0.00 M samples/s  0s left");
        report.finish();
        assert!(shared.is_over.load(Ordering::Relaxed) && report.observer.is_none());
        let silent = ProgressReport::new(Goal::Samples(4), state, true, MutationsPerPixel(1), 100);
        assert!(silent.counter().is_none());
    }
}
