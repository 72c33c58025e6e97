//! Structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004), of luminance as shown: clamped to [0, 1] linear
//! RGB, luminance, sRGB encoded.
//!
//! `SSIM = (2 mu_a mu_b + C1)(2 sigma_ab + C2) / ((mu_a^2 + mu_b^2 + C1)(sigma_a^2 + sigma_b^2 + C2))`  (equation 13)
//!
//! with means, variances and covariance under an 11 x 11 Gaussian window of deviation 1.5, C1 = 0.01^2, C2 = 0.03^2
//! (range 1), averaged over the windows that lie inside the image. At most 1, which equal images reach.

use super::convolution::{Border, convolve, gaussian};
use super::{RgbImage, assert_same_size};

const RADIUS: usize = 5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean structural similarity; `None` for images smaller than the window.
///
/// # Panics
/// If the sizes differ.
pub fn ssim(image: &RgbImage, reference: &RgbImage) -> Option<f64> {
    assert_same_size(image, reference);
    if image.width.min(image.height) < 2 * RADIUS + 1 {
        return None;
    }
    let window = gaussian(1.5, RADIUS);
    let smooth = |plane: &[f64]| convolve(plane, image.width, &window, &window, Border::Valid);
    let (a, b) = (image.displayed_luminance(), reference.displayed_luminance());
    let product =
        |a: &[f64], b: &[f64]| smooth(&a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<_>>());
    let (mean_a, mean_b) = (smooth(&a), smooth(&b));
    let (aa, bb, ab) = (product(&a, &a), product(&b, &b), product(&a, &b));
    let mut sum = 0.0;
    for i in 0..mean_a.len() {
        let (ma, mb) = (mean_a[i], mean_b[i]);
        let (va, vb, cov) = (aa[i] - ma * ma, bb[i] - mb * mb, ab[i] - ma * mb);
        sum +=
            (2.0 * ma * mb + C1) * (2.0 * cov + C2) / ((ma * ma + mb * mb + C1) * (va + vb + C2));
    }
    Some(sum / mean_a.len() as f64)
}
