//! The error metrics in a comparison of algorithms.
//!
//! Against a reference R of relative variance V = mean of Var R / (R^2 + 0.01):
//!
//! - relative MSE: mean of e = (I - R)^2 / (R^2 + 0.01) over pixels and channels
//!   ([`crate::compare::metrics::relative_mse`]);
//! - the same without the worst 0.1 % of the pixels, by the mean of e over a pixel's channels: more meaningful for a single
//!   image, because a few very bright samples do not dominate it;
//! - both minus V, where the reference has variance layers: every measured error contains the reference's own noise. The
//!   remainder of an error near V is itself uncertain, and may be negative;
//! - RMS of relative residuals ([`crate::compare::metrics::residual_rms`]);
//! - sigma = sqrt(mean of Var I / (R^2 + 0.01)): the noise estimated from the image's own samples, comparable with the square
//!   root of the relative MSE, which is greater where an algorithm has not sampled part of the light yet.
//!
//! By pairs, the other image J is as noisy as I: squares (I - J)^2 are halved, residuals divided by sqrt(2), and R is the mean of
//! both. CIE76, SSIM and FLIP do not scale so; they state the difference between the two images.

use crate::compare::comparison::layer;
use crate::compare::metrics::RgbImage;
use crate::compare::metrics::cielab::cie76;
use crate::compare::metrics::flip::{ldr_flip, mean};
use crate::compare::metrics::relative_mse::EPSILON;
use crate::compare::metrics::residual_rms::residual_rms;
use crate::compare::metrics::ssim::ssim;
use crate::image::ExrImage;
use std::f64::consts::FRAC_1_SQRT_2;

/// Share of the pixels that the trimmed error leaves out.
pub const TRIMMED_SHARE: f64 = 0.001;

/// What an image should look like.
#[derive(Clone, Debug)]
pub struct Reference {
    /// Its radiance.
    pub image: RgbImage,
    /// Mean of its variance over its squared radiance plus 0.01, if it states variances.
    pub relative_variance: Option<f64>,
}

impl Reference {
    /// Of a file that must have the given size.
    ///
    /// # Errors
    /// If it has another size, no colours, or values that are not finite.
    pub fn new(name: &str, file: &ExrImage, [width, height]: [u32; 2]) -> Result<Self, String> {
        if [file.width, file.height] != [width, height] {
            return Err(format!(
                "{name}: the reference has {} x {} pixels, the scene {width} x {height}",
                file.width, file.height
            ));
        }
        let image = layer(file, "").ok_or_else(|| format!("{name}: no channels R, G, B"))?;
        let variance = layer(file, "variance.");
        let is_finite = |l: &RgbImage| l.pixels.iter().all(|p| p.iter().all(|v| v.is_finite()));
        if !is_finite(&image) || !variance.as_ref().is_none_or(is_finite) {
            return Err(format!(
                "{name}: the reference has values that are not finite"
            ));
        }
        let relative_variance = variance.map(|v| relative_mean(&v.pixels, &image));
        Ok(Reference {
            image,
            relative_variance,
        })
    }
}

/// What an image is measured by.
#[derive(Clone, Copy, Debug)]
pub enum ErrorReference<'a> {
    /// A reference.
    Reference(&'a Reference),
    /// An independent image by the same algorithm after the same time.
    Twin(&'a RgbImage),
}

/// The numbers of the module's header that do not depend on a display.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Relative mean squared error.
    pub relative_mse: f64,
    /// Without the worst pixels.
    pub trimmed: f64,
    /// Both less the reference's relative variance, if that is known.
    pub less_reference: Option<[f64; 2]>,
    /// Root mean square of relative residuals.
    pub residual_rms: f64,
    /// Relative noise by the image's own variance.
    pub sigma: f64,
}

impl Errors {
    /// Of an image with the variance of its pixels.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn new(image: &RgbImage, variance: &[[f64; 3]], reference: ErrorReference<'_>) -> Errors {
        let squares = relative_squares(image, reference);
        let (relative_mse, trimmed) = (mean(&squares), trimmed_mean(squares, TRIMMED_SHARE));
        let (residual_rms, reference_variance, sigma) = match reference {
            ErrorReference::Reference(reference) => (
                residual_rms(image, &reference.image),
                reference.relative_variance,
                relative_mean(variance, &reference.image),
            ),
            ErrorReference::Twin(twin) => (
                residual_rms(image, twin) * FRAC_1_SQRT_2,
                None,
                relative_mean(variance, &mean_of(image, twin)),
            ),
        };
        Errors {
            relative_mse,
            trimmed,
            less_reference: reference_variance.map(|v| [relative_mse - v, trimmed - v]),
            residual_rms,
            sigma: sigma.sqrt(),
        }
    }
}

/// Perceptual metrics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShownErrors {
    /// Mean colour difference of 1976.
    pub cie76: f64,
    /// Structural similarity; none of images that are too small.
    pub ssim: Option<f64>,
    /// Mean LDR-FLIP.
    pub flip: f64,
}

impl ShownErrors {
    /// Of an image.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn new(image: &RgbImage, reference: ErrorReference<'_>) -> ShownErrors {
        let other = match reference {
            ErrorReference::Reference(reference) => &reference.image,
            ErrorReference::Twin(twin) => twin,
        };
        ShownErrors {
            cie76: cie76(image, other),
            ssim: ssim(image, other),
            flip: mean(&ldr_flip(image, other)),
        }
    }
}

/// Relative squared error of every pixel, the mean of its channels.
pub fn relative_squares(image: &RgbImage, reference: ErrorReference<'_>) -> Vec<f64> {
    let squares = |other: &RgbImage, scale: f64| -> Vec<[f64; 3]> {
        let pixels = image.pixels.iter().zip(&other.pixels);
        pixels
            .map(|(a, b)| [0, 1, 2].map(|c| scale * (a[c] - b[c]).powi(2)))
            .collect()
    };
    match reference {
        ErrorReference::Reference(reference) => {
            relative(&squares(&reference.image, 1.0), &reference.image)
        }
        ErrorReference::Twin(twin) => relative(&squares(twin, 0.5), &mean_of(image, twin)),
    }
}

/// Values over the squared reference plus 0.01, the mean of the channels.
fn relative(values: &[[f64; 3]], reference: &RgbImage) -> Vec<f64> {
    let pixels = values.iter().zip(&reference.pixels);
    let channel = |v: &[f64; 3], r: &[f64; 3], c: usize| v[c] / (r[c] * r[c] + EPSILON);
    pixels
        .map(|(v, r)| (channel(v, r, 0) + channel(v, r, 1) + channel(v, r, 2)) / 3.0)
        .collect()
}

fn relative_mean(values: &[[f64; 3]], reference: &RgbImage) -> f64 {
    mean(&relative(values, reference))
}

fn mean_of(a: &RgbImage, b: &RgbImage) -> RgbImage {
    let pixels = a.pixels.iter().zip(&b.pixels);
    let pixels = pixels.map(|(a, b)| [0, 1, 2].map(|c| 0.5 * (a[c] + b[c])));
    RgbImage::new(a.width, a.height, pixels.collect())
}

/// Mean without the largest `share` of the values, rounded down to whole values.
pub fn trimmed_mean(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let left_out = (values.len() as f64 * share) as usize;
    mean(&values[..values.len() - left_out])
}
