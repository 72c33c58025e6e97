//! What takes samples: the threads of the processor, or a device of another front end.

use super::stop::Stop;
use crate::film::Film;

/// What a pass failed of.
pub type PassError = Box<dyn std::error::Error + Send + Sync>;

/// How a pass ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PassEnd {
    /// With all samples that were asked for.
    Complete,
    /// Before, because it was asked to stop.
    Cut,
}

/// What takes samples: the processor's threads, or a device of another front end.
pub trait Backend {
    /// Adds `per_pixel` samples to every pixel, or `counts` (by rows) where given. The next sample of a pixel has the
    /// index [`super::RenderOptions::first_sample`] plus the pixel's count.
    ///
    /// When `stop` says so, the pass may end early: each pixel then has the first of its samples, as many as were taken. Pixels
    /// that share light get complete layers of samples, and what was begun of the next is dropped.
    ///
    /// # Errors
    /// Whatever makes going on impossible. The film then holds complete layers of samples.
    fn pass(
        &mut self,
        film: &mut Film,
        per_pixel: u32,
        counts: Option<&[u32]>,
        stop: &Stop<'_>,
    ) -> Result<PassEnd, PassError>;
}
