//! Mean squared error, over pixels and channels: `MSE = 1/n sum (a - b)^2`, in squared radiance.

use super::{RgbImage, mean_over_channels};

/// Mean squared error.
///
/// # Panics
/// If the sizes differ.
pub fn mse(image: &RgbImage, reference: &RgbImage) -> f64 {
    mean_over_channels(image, reference, |a, b| (a - b) * (a - b))
}
