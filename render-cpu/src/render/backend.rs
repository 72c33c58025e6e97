//! What takes samples: the threads of the processor, or a device of another front end.

use crate::film::Film;

/// What a pass failed of.
pub type PassError = Box<dyn std::error::Error + Send + Sync>;

/// What takes samples: the processor's threads, or a device of another front end.
pub trait Backend {
    /// Adds `per_pixel` samples to every pixel, or `counts` (by rows) where given. The next sample of a pixel has the
    /// index [`super::RenderOptions::first_sample`] plus the pixel's count.
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
