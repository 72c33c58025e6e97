//! Relative mean squared error, over pixels and channels: `1/n sum (a - b)^2 / (b^2 + 0.01)`, b the reference
//! (Rousselle, Knaus and Zwicker 2011, section 5, who introduced it with this constant). Dimensionless.
//! The constant keeps black pixels of the reference from deciding the result.

use super::{RgbImage, assert_same_size, mean_over_channels};

/// What is added to the squared reference.
pub const EPSILON: f64 = 0.01;

fn relative_square(a: f64, b: f64) -> f64 {
    (a - b) * (a - b) / (b * b + EPSILON)
}

/// Relative mean squared error.
///
/// # Panics
/// If the sizes differ.
pub fn relative_mse(image: &RgbImage, reference: &RgbImage) -> f64 {
    mean_over_channels(image, reference, relative_square)
}

/// Share of the pixels that [`trimmed_relative_mse`] leaves out.
pub const TRIMMED: f64 = 0.001;

/// Relative mean squared error without the pixels of largest error, one of a thousand (rounded up), so that it tells of one run what a few
/// bright pixels would hide.
///
/// # Panics
/// If the sizes differ.
pub fn trimmed_relative_mse(image: &RgbImage, reference: &RgbImage) -> f64 {
    assert_same_size(image, reference);
    let error = |(a, b): (&[f64; 3], &[f64; 3])| {
        (0..3).map(|c| relative_square(a[c], b[c])).sum::<f64>() / 3.0
    };
    let pairs = image.pixels.iter().zip(&reference.pixels);
    let mut errors: Vec<f64> = pairs.map(error).collect();
    errors.sort_by(f64::total_cmp);
    let left_out = (errors.len() as f64 * TRIMMED).ceil() as usize;
    errors.truncate((errors.len() - left_out).max(1));
    errors.iter().sum::<f64>() / errors.len() as f64
}

/// What variances of the reference add to the relative mean squared error of an image: `1/n sum var / (b^2 + 0.01)`.
///
/// # Panics
/// If the sizes differ.
pub fn relative_variance(variance: &RgbImage, reference: &RgbImage) -> f64 {
    mean_over_channels(variance, reference, |v, b| v / (b * b + EPSILON))
}
