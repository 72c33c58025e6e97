//! Colours and spectra as scene files give them.

use std::path::PathBuf;
use std::sync::Arc;

/// A colour given by a triplet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Color {
    /// Linear sRGB.
    pub rgb: [f32; 3],
    /// It was given in `<srgb>`, or as a hexadecimal number there, and was linearised.
    pub was_encoded: bool,
}

/// A colour given over the wavelengths.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same at every wavelength.
    Uniform(f64),
    /// Pairs of a wavelength in nanometres, strictly increasing, and a value; linear in between, zero outside.
    Samples(Arc<[(f64, f64)]>),
    /// A file of such pairs, one per line; already found, not yet read.
    File(PathBuf),
}
