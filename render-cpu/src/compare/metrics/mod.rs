//! How much two images differ: one metric per file.
//!
//! The second image is always the reference. Metrics on radiance ([`mse`], [`relative_mse`], [`residual_rms`],
//! `flip::hdr_flip`, [`ztest`]) see the values as they are; those that are defined for display images ([`psnr`],
//! [`cielab`], [`ssim`], `flip::ldr_flip`) see them at exposure 0, clamped to [0, 1] and, where the definition asks for
//! it, sRGB encoded.

pub mod cielab;
mod convolution;
pub mod flip;
pub mod mse;
pub mod psnr;
pub mod relative_mse;
pub mod residual_rms;
pub mod ssim;
pub mod ztest;

use crate::film::luminance;
use crate::image::png_output::srgb_encode;

/// Linear RGB values of an image, by rows.
#[derive(Clone, Debug, PartialEq)]
pub struct RgbImage {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Pixels by rows.
    pub pixels: Vec<[f64; 3]>,
}

impl RgbImage {
    /// An image of `width * height` pixels.
    ///
    /// # Panics
    /// If the number of pixels is another, or zero.
    pub fn new(width: usize, height: usize, pixels: Vec<[f64; 3]>) -> Self {
        assert!(
            !pixels.is_empty() && pixels.len() == width * height,
            "an image of {width} x {height} pixels"
        );
        Self {
            width,
            height,
            pixels,
        }
    }

    /// Luminance of the pixels as shown: clamped to [0, 1], then sRGB encoded.
    fn displayed_luminance(&self) -> Vec<f64> {
        self.pixels
            .iter()
            .map(|p| srgb_encode(luminance(p.map(|v| v.clamp(0.0, 1.0)))))
            .collect()
    }
}

/// Mean of `f` over all pixels and channels of two images.
fn mean_over_channels(image: &RgbImage, reference: &RgbImage, f: impl Fn(f64, f64) -> f64) -> f64 {
    assert_same_size(image, reference);
    let mut sum = 0.0;
    for (a, b) in image.pixels.iter().zip(&reference.pixels) {
        for c in 0..3 {
            sum += f(a[c], b[c]);
        }
    }
    sum / (3 * image.pixels.len()) as f64
}

fn assert_same_size(image: &RgbImage, reference: &RgbImage) {
    assert_eq!(
        (image.width, image.height),
        (reference.width, reference.height),
        "images differ in size"
    );
}
