//! Tone-mapped 8-bit PNG for viewing; the EXR beside it has the data.
//!
//! Per channel, with radiance x:
//!
//! 1. exposure: x' = 2^EV x, with EV = 0 by default, so that two renders of a scene can be compared by eye;
//! 2. tone curve: y = x' up to a = 0.8, above it the soft shoulder y = a + (1 - a)(1 - exp(-(x' - a) / (1 - a))),
//!    which continues with the same slope and approaches 1: mid-tones are unchanged, white paper (1.0) is 247 of 255, a
//!    lamp fades to white instead of being clipped;
//! 3. sRGB transfer (IEC 61966-2-1): 12.92 y below 0.0031308, else 1.055 y^(1/2.4) - 0.055;
//! 4. rounding to the nearest of 256 values, without dithering, so that equal images give equal files.
//!
//! The automatic exposure scales the log-average luminance to 0.18 (Reinhard et al. 2002, equations 1 and 2), taken
//! over the pixels that are not black.

use crate::atomic_file::{WriteError, write_atomically};
use crate::film::luminance;
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use std::path::Path;

/// How radiance is scaled before the tone curve.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Exposure {
    /// By 2^EV.
    Stops(f32),
    /// So that the log-average luminance becomes 0.18.
    Automatic,
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Stops(0.0)
    }
}

/// How values above one are shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum ToneCurve {
    /// Unchanged up to 0.8, a soft shoulder above.
    #[default]
    Soft,
    /// Cut at one, as the transfer function of sRGB has it.
    Clip,
    /// x / (1 + x) (Reinhard et al. 2002, equation 3), per channel.
    Reinhard,
}

/// Exposure and tone curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Scale before the curve.
    pub exposure: Exposure,
    /// The curve.
    pub curve: ToneCurve,
}

/// Where the shoulder of the tone curve begins.
const SHOULDER: f64 = 0.8;

/// The tone curve: identity up to 0.8, then a soft shoulder towards 1. Negative values become black.
pub fn tone_curve(x: f64) -> f64 {
    if x <= SHOULDER {
        x.max(0.0)
    } else {
        let room = 1.0 - SHOULDER;
        SHOULDER + room * -(-(x - SHOULDER) / room).exp_m1()
    }
}

/// Transfer function of sRGB, [0, 1] to [0, 1] (IEC 61966-2-1).
pub fn srgb_encode(linear: f64) -> f64 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// Factor of an exposure for an image.
pub fn exposure_scale(pixels: &[[f64; 3]], exposure: Exposure) -> f64 {
    match exposure {
        Exposure::Stops(stops) => f64::from(stops).exp2(),
        Exposure::Automatic => {
            let mut sum = 0.0;
            let mut count = 0_u64;
            for l in pixels
                .iter()
                .map(|&p| luminance(p))
                .filter(|l| l.is_finite() && *l > 1e-6)
            {
                sum += l.ln();
                count += 1;
            }
            if count == 0 {
                1.0
            } else {
                0.18 / (sum / count as f64).exp()
            }
        }
    }
}

/// 8-bit sRGB of an image, three bytes per pixel.
pub fn tone_map(pixels: &[[f64; 3]], exposure: Exposure) -> Vec<u8> {
    let look = Look {
        exposure,
        ..Look::default()
    };
    tone_map_with(pixels, look)
}

/// [`tone_map`] with a curve of choice.
pub fn tone_map_with(pixels: &[[f64; 3]], look: Look) -> Vec<u8> {
    let scale = exposure_scale(pixels, look.exposure);
    let curve = |v: f64| match look.curve {
        ToneCurve::Soft => tone_curve(v),
        ToneCurve::Clip => v.clamp(0.0, 1.0),
        ToneCurve::Reinhard if v.is_finite() => v.max(0.0) / (1.0 + v.max(0.0)),
        ToneCurve::Reinhard => v.clamp(0.0, 1.0),
    };
    // A float cast saturates and takes NaN to zero.
    let encode = |v: f64| (srgb_encode(curve(v * scale)) * 255.0).round() as u8;
    pixels.iter().flat_map(|p| p.map(encode)).collect()
}

/// Writes an image as tone-mapped PNG, atomically.
///
/// # Errors
/// If the file cannot be written; nothing is left under its name then.
///
/// # Panics
/// If there are not `width * height` pixels.
pub fn write_png(
    path: &Path,
    width: u32,
    height: u32,
    pixels: &[[f64; 3]],
    exposure: Exposure,
) -> Result<(), WriteError> {
    write_png_bytes(path, width, height, &tone_map(pixels, exposure))
}

/// Writes 8-bit sRGB, three bytes per pixel, as PNG, atomically.
///
/// # Errors
/// If the file cannot be written; nothing is left under its name then.
///
/// # Panics
/// If there are not `3 * width * height` bytes.
pub fn write_png_bytes(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<(), WriteError> {
    assert_eq!(
        rgb.len(),
        3 * width as usize * height as usize,
        "bytes do not fill the image"
    );
    write_atomically(path, |file| {
        PngEncoder::new_with_quality(file, CompressionType::Best, FilterType::Adaptive)
            .write_image(rgb, width, height, image::ExtendedColorType::Rgb8)
            .map_err(|e| match e {
                image::ImageError::IoError(e) => e,
                e => std::io::Error::other(e),
            })
    })
}
