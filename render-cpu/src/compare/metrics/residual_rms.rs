//! Root mean square of relative residuals (Jendersie and Grosch 2019, section 4, "RMS RE"), over pixels and channels:
//!
//! `RMS RE = sqrt(1/n sum (a - b)^2 / ((a + b) / 2)^2)`.
//!
//! Symmetric in its arguments, unchanged by exposure, and between 0 and 2: a value that one image misses altogether
//! counts 2, however bright it is. That is its purpose: an absolute error penalises bright noise much more than missing
//! features. Negative values (filters with negative lobes) count as zero; where both are zero the residual is zero.

use super::{RgbImage, mean_over_channels};

/// Root mean square of relative residuals.
///
/// # Panics
/// If the sizes differ.
pub fn residual_rms(image: &RgbImage, reference: &RgbImage) -> f64 {
    let squared = mean_over_channels(image, reference, |a, b| {
        let (a, b) = (a.max(0.0), b.max(0.0));
        let mean = 0.5 * (a + b);
        if mean > 0.0 {
            ((a - b) / mean).powi(2)
        } else {
            0.0
        }
    });
    squared.sqrt()
}
