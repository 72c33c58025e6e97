//! Relative mean squared error, over pixels and channels: `1/n sum (a - b)^2 / (b^2 + 0.01)`, b the reference
//! (Rousselle, Knaus and Zwicker 2011, section 5, who introduced it with this constant). Dimensionless.
//! The constant keeps black pixels of the reference from deciding the result.

use super::{RgbImage, mean_over_channels};

/// What is added to the squared reference.
pub const EPSILON: f64 = 0.01;

/// Relative mean squared error.
///
/// # Panics
/// If the sizes differ.
pub fn relative_mse(image: &RgbImage, reference: &RgbImage) -> f64 {
    mean_over_channels(image, reference, |a, b| {
        (a - b) * (a - b) / (b * b + EPSILON)
    })
}
