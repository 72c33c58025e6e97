//! Textures from image files.
//!
//! PNG (grey, colour, palette, alpha, 1 to 16 bits), JPEG, BMP, TGA, Radiance HDR and OpenEXR. The format is told from
//! the first bytes; TGA, which has no mark, from the file's extension. Images of 8 bits stay bytes, all others become
//! three floats per pixel. Grey images repeat their value, alpha of float images is dropped.
//!
//! `raw` says that the file's values are data (normals, roughness), not sRGB-encoded colours. It matters for integer
//! formats only: float formats are linear anyway.
//!
//! # Values
//! What is not finite in a float image becomes finite, with a warning: NaN zero, infinities the largest half float.

use super::exr_read::{ExrImage, read_exr_bytes};
use super::{ImageError, MAX_DIMENSION, MAX_SAMPLES, believable_bytes, read_file};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::Cursor;
use std::path::Path;

/// Largest finite half float, what an infinite texel becomes.
const MAX_HALF: f32 = 65504.0;

/// An image as a texture reads it; rows from top to bottom.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The pixels.
    pub texels: Texels,
}

/// Pixels of a [`Bitmap`].
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Four bytes per pixel.
    Rgba8 {
        /// R, G, B, A of each pixel; A is 255 where the file has none.
        data: Vec<u8>,
        /// R, G and B are sRGB-encoded.
        srgb: bool,
    },
    /// Three linear floats per pixel, all finite.
    Rgb32F(Vec<f32>),
}

/// Reads an image file; see the module for `raw`.
///
/// # Errors
/// When the file cannot be read, its format is unknown, it is damaged, or exceeds the limits of [`super`].
pub fn load_bitmap(path: impl AsRef<Path>, raw: bool) -> Result<Bitmap, ImageError> {
    let path = path.as_ref();
    read_bitmap(&read_file(path)?, raw, path)
}

/// Reads an image from memory; `file` is for messages, and its extension for telling TGA.
///
/// # Errors
/// As [`load_bitmap`].
pub fn read_bitmap(bytes: &[u8], raw: bool, file: &Path) -> Result<Bitmap, ImageError> {
    const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    if bytes.starts_with(&EXR_MAGIC) {
        return from_exr(&read_exr_bytes(bytes, file)?, file);
    }
    let is_tga = || {
        let extension = file.extension().unwrap_or_default();
        extension.eq_ignore_ascii_case("tga")
    };
    let format = match image::guess_format(bytes) {
        Ok(format) => format,
        Err(_) if is_tga() => ImageFormat::Tga,
        Err(_) => return Err(ImageError::unsupported(file, "the image's format")),
    };
    decode(bytes, format, raw, file)
}

fn decode(bytes: &[u8], format: ImageFormat, raw: bool, file: &Path) -> Result<Bitmap, ImageError> {
    let error = |error: image::ImageError| match error {
        image::ImageError::Unsupported(what) => ImageError::unsupported(file, what.to_string()),
        other => ImageError::malformed(file, format!("damaged image: {other}")),
    };
    let believable = believable_bytes(bytes.len());
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(MAX_DIMENSION);
    limits.max_image_height = Some(MAX_DIMENSION);
    // Decoders may hold a few rows or a second copy.
    limits.max_alloc = Some(believable.saturating_mul(3));
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(error)?;

    let (width, height) = decoder.dimensions();
    let samples = u64::from(width) * u64::from(height) * 4;
    let refuse = |why: &str| {
        Err(ImageError::TooLarge {
            file: file.to_owned(),
            width: width.into(),
            height: height.into(),
            why: why.to_owned(),
        })
    };
    if width == 0 || height == 0 {
        return Err(ImageError::malformed(file, "the image has no pixels"));
    }
    if width > MAX_DIMENSION || height > MAX_DIMENSION || samples > MAX_SAMPLES {
        return refuse("it is too large");
    }
    if decoder.total_bytes() > believable {
        return refuse("the file is too short to hold it");
    }
    let image = DynamicImage::from_decoder(decoder).map_err(error)?;
    let texels = match &image {
        DynamicImage::ImageLuma8(_)
        | DynamicImage::ImageLumaA8(_)
        | DynamicImage::ImageRgb8(_)
        | DynamicImage::ImageRgba8(_) => Texels::Rgba8 {
            data: image.into_rgba8().into_raw(),
            srgb: !raw,
        },
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            Texels::Rgb32F(finite(image.into_rgb32f().into_raw(), file))
        }
        // 16 bits: floats keep them.
        _ => {
            let data = image.into_rgb16().into_raw();
            let linear = |v: u16| {
                let encoded = f32::from(v) / 65535.0;
                if raw {
                    encoded
                } else {
                    srgb_to_linear(encoded)
                }
            };
            Texels::Rgb32F(data.into_iter().map(linear).collect())
        }
    };
    Ok(Bitmap {
        width,
        height,
        texels,
    })
}

/// Inverse of the sRGB transfer function, IEC 61966-2-1.
fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// The colour channels of an OpenEXR image: `R`, `G`, `B`; or `Y`; or the first layer that has either; or the only
/// channel there is (besides alpha).
fn from_exr(exr: &ExrImage, file: &Path) -> Result<Bitmap, ImageError> {
    let Some(planes) = color_planes(exr) else {
        let names: Vec<&str> = exr.channels.iter().map(|(name, _)| name.as_str()).collect();
        let what = format!("an image with the channels {}", names.join(", "));
        return Err(ImageError::unsupported(file, what));
    };
    let pixels = exr.width as usize * exr.height as usize;
    let mut data = Vec::with_capacity(pixels * 3);
    for i in 0..pixels {
        data.extend(planes.map(|plane| plane[i]));
    }
    Ok(Bitmap {
        width: exr.width,
        height: exr.height,
        texels: Texels::Rgb32F(finite(data, file)),
    })
}

fn color_planes(exr: &ExrImage) -> Option<[&[f32]; 3]> {
    let of_layer = |layer: &str| {
        let plane = |name: &str| exr.channel(&format!("{layer}{name}"));
        if let (Some(r), Some(g), Some(b)) = (plane("R"), plane("G"), plane("B")) {
            return Some([r, g, b]);
        }
        // X and Z beside Y are a colour in CIE XYZ, RY and BY are chroma: Y alone would be a guess.
        let others = ["X", "Z", "RY", "BY"].iter().any(|n| plane(n).is_some());
        plane("Y").filter(|_| !others).map(|y| [y; 3])
    };
    let layers = exr.channels.iter().filter_map(|(name, _)| {
        let dot = name.rfind('.')?;
        Some(&name[..=dot])
    });
    std::iter::once("")
        .chain(layers)
        .find_map(of_layer)
        .or_else(|| {
            let mut colors = exr.channels.iter().filter(|(name, _)| name != "A");
            match (colors.next(), colors.next()) {
                (Some((_, only)), None) => Some([only; 3]),
                _ => None,
            }
        })
}

fn finite(mut data: Vec<f32>, file: &Path) -> Vec<f32> {
    let mut repaired = 0_usize;
    for value in &mut data {
        if !value.is_finite() {
            repaired += 1;
            *value = match *value {
                v if v.is_nan() => 0.0,
                v => MAX_HALF.copysign(v),
            };
        }
    }
    if repaired > 0 {
        tracing::warn!(
            "{}: {repaired} values are not finite and are replaced",
            file.display()
        );
    }
    data
}
