//! The goal of a run, its state, and its outcome.

use std::time::Duration;

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

/// The state of a run; kept in checkpoints.
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
    /// A request to stop ended it.
    Interrupted,
}
