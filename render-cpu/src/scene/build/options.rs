//! What the command line changes about a scene while it is built.

use std::path::PathBuf;

/// Everything that the command line may change.
#[derive(Clone, Debug, Default)]
pub struct BuildOptions {
    /// Size and crop of the film.
    pub film: FilmOverride,
    /// Integrator instead of the scene's.
    pub integrator: Option<String>,
    /// Sampler instead of the scene's.
    pub sampler: Option<String>,
    /// Which of several sensors, counted from 0 in the order of the file.
    pub sensor: usize,
    /// A file with edits of light transport.
    pub edit: Option<PathBuf>,
    /// The moment of their keyframes, if it is given.
    pub edit_time: Option<f64>,
}

/// A rectangle of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// First pixel.
    pub offset: [u32; 2],
    /// Width and height.
    pub size: [u32; 2],
}

/// Changes of the film.
#[derive(Clone, Copy, Debug, Default)]
pub struct FilmOverride {
    /// Width and height.
    pub size: Option<[u32; 2]>,
    /// Width; the height follows in proportion.
    pub width: Option<u32>,
    /// Part of the film to render.
    pub crop: Option<Crop>,
}
