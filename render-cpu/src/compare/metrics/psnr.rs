//! Peak signal to noise ratio in decibel, `10 log10(1 / MSE)`, of the images as shown: clamped to [0, 1] and sRGB
//! encoded per channel, so the peak is 1. Infinite for images that look equal.

use super::{RgbImage, mean_over_channels};
use crate::image::png_output::srgb_encode;

/// Peak signal to noise ratio in decibel.
///
/// # Panics
/// If the sizes differ.
pub fn psnr(image: &RgbImage, reference: &RgbImage) -> f64 {
    let show = |v: f64| srgb_encode(v.clamp(0.0, 1.0));
    let mse = mean_over_channels(image, reference, |a, b| (show(a) - show(b)).powi(2));
    -10.0 * mse.log10()
}
