//! Progress of a run: a bar on a terminal, plain lines elsewhere, no output with `--quiet`.

use super::chains::MutationsPerPixel;
use super::options::{Goal, RunState};
use crate::film::Film;
use crate::say::note;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Seconds between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(5);

/// Reports the progress of one run on standard error.
pub struct ProgressReport {
    goal: Goal,
    start: Instant,
    samples_before: u32,
    unit: MutationsPerPixel,
    /// Samples of all pixels before this run, known after the first pass.
    display: Display,
}

enum Display {
    Quiet,
    Bar(ProgressBar),
    Lines(Instant),
}

impl ProgressReport {
    /// A report of a run that starts at `state`.
    pub fn new(goal: Goal, state: RunState, quiet: bool) -> ProgressReport {
        let display = if quiet {
            Display::Quiet
        } else if std::io::stderr().is_terminal() {
            let length = match goal {
                Goal::Samples(n) => u64::from(n),
                Goal::Time(time) => time.as_millis() as u64,
            };
            let bar = ProgressBar::new(length);
            // The template is a constant that parses.
            if let Ok(style) = ProgressStyle::with_template("{bar:32} {percent:>3}%  {msg}") {
                bar.set_style(style);
            }
            Display::Bar(bar)
        } else {
            Display::Lines(Instant::now())
        };
        ProgressReport {
            goal,
            start: Instant::now(),
            samples_before: state.samples,
            unit: MutationsPerPixel(1),
            display,
        }
    }

    /// Counts mutations, of which each sample stands for so many.
    pub fn with_unit(mut self, unit: MutationsPerPixel) -> ProgressReport {
        self.unit = unit;
        self
    }

    /// Reports the state after a pass.
    pub fn update(&mut self, state: &RunState, film: &Film) {
        let elapsed = self.start.elapsed();
        let done = match self.goal {
            Goal::Samples(n) => f64::from(state.samples) / f64::from(n.max(1)),
            Goal::Time(time) => elapsed.as_secs_f64() / time.as_secs_f64(),
        }
        .min(1.0);
        let unit = self.unit;
        match &mut self.display {
            Display::Quiet => {}
            Display::Bar(bar) => {
                bar.set_position((done * bar.length().unwrap_or(0) as f64) as u64);
                bar.set_message(message(
                    self.goal,
                    self.samples_before,
                    unit,
                    state,
                    film,
                    elapsed,
                ));
            }
            Display::Lines(last) => {
                if last.elapsed() >= LINE_INTERVAL {
                    *last = Instant::now();
                    note(format_args!(
                        "{:3.0}%  {}",
                        done * 100.0,
                        message(self.goal, self.samples_before, unit, state, film, elapsed)
                    ));
                }
            }
        }
    }

    /// Leaves the last state on the terminal.
    pub fn finish(&self) {
        if let Display::Bar(bar) = &self.display {
            bar.abandon();
        }
    }
}

/// Samples, rate, time left and noise.
fn message(
    goal: Goal,
    samples_before: u32,
    MutationsPerPixel(unit): MutationsPerPixel,
    state: &RunState,
    film: &Film,
    elapsed: Duration,
) -> String {
    let seconds = elapsed.as_secs_f64().max(1e-9);
    let samples = f64::from(state.samples - samples_before);
    let rate = samples * f64::from(unit) * film.statistics().len() as f64 / seconds;
    let left = match goal {
        Goal::Samples(n) if samples > 0.0 => {
            f64::from(n.saturating_sub(state.samples)) * seconds / samples
        }
        Goal::Samples(_) => 0.0,
        Goal::Time(time) => time.saturating_sub(elapsed).as_secs_f64(),
    };
    format!(
        "{} {}  {:.2} M {}/s  {} left  noise {:.2}%",
        u64::from(state.samples) * u64::from(unit),
        if unit > 1 {
            "mutations per pixel"
        } else {
            "spp"
        },
        rate / 1e6,
        if unit > 1 { "mutations" } else { "samples" },
        duration(left),
        film.relative_noise() * 100.0
    )
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
