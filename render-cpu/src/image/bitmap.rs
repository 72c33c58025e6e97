//! Textures from image files.
//!
//! PNG (grey, colour, palette, alpha, 1 to 16 bits), JPEG, BMP, TGA, TIFF, PNM, PFM, Radiance HDR and OpenEXR. The format
//! is detected from the first bytes; TGA, which has no mark, from the file's extension. Images of 8 bits stay bytes, all others
//! become three floats per pixel. Grey images repeat their value, alpha of float images is dropped; [`load_channel`] reads
//! one channel alone.
//!
//! `raw` says that the file's values are data (normals, roughness), not sRGB-encoded colours. It matters for integer
//! formats only: float formats are linear anyway.
//!
//! # Values
//! What is not finite in a float image becomes finite, with a warning: NaN zero, infinities the largest half float.

use super::exr_read::{ExrImage, read_exr_bytes};
use super::{ImageError, MAX_DIMENSION, MAX_SAMPLES, believable_bytes, pfm, radiance, read_file};
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
    /// What was left out or replaced, a sentence each.
    pub warnings: Vec<String>,
}

/// A channel of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Channel {
    /// The first.
    Red,
    /// The second.
    Green,
    /// The third.
    Blue,
    /// Opacity; one where the file has none.
    Alpha,
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
    read(bytes, raw, None, file)
}

/// Reads one channel of an image file, as a grey image; see the module for `raw`. Alpha is never encoded.
///
/// # Errors
/// As [`load_bitmap`].
pub fn load_channel(
    path: impl AsRef<Path>,
    raw: bool,
    channel: Channel,
) -> Result<Bitmap, ImageError> {
    let path = path.as_ref();
    let raw = raw || channel == Channel::Alpha;
    read(&read_file(path)?, raw, Some(channel), path)
}

fn read(
    bytes: &[u8],
    raw: bool,
    channel: Option<Channel>,
    file: &Path,
) -> Result<Bitmap, ImageError> {
    const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    if bytes.starts_with(&EXR_MAGIC) {
        return from_exr(&read_exr_bytes(bytes, file)?, channel, file);
    }
    if pfm::is_pfm(bytes) {
        let map = pfm::read(bytes, file)?;
        return Ok(of_floats(map.data, map.width, map.height, channel));
    }
    if radiance::is_radiance(bytes) {
        let (common, order, warnings) = radiance::normalize(bytes, file)?;
        let mut bitmap = decode(&common, ImageFormat::Hdr, raw, None, file)?;
        if let Texels::Rgb32F(data) = bitmap.texels {
            let (data, width, height) = order.apply(data, bitmap.width, bitmap.height);
            let repairs = bitmap.warnings;
            bitmap = of_floats(data, width, height, channel);
            bitmap.warnings.extend(repairs);
        }
        bitmap.warnings.extend(warnings);
        return Ok(bitmap);
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
    decode(bytes, format, raw, channel, file)
}

/// What a decoder does not take, as the subject of a sentence.
fn feature(error: &image::error::UnsupportedError) -> String {
    use image::error::UnsupportedErrorKind;
    match error.kind() {
        UnsupportedErrorKind::Color(color) => format!("an image with colours of type {color:?}"),
        UnsupportedErrorKind::Format(format) => format!("the image's format, {format},"),
        UnsupportedErrorKind::GenericFeature(feature) => {
            format!("a feature of the image ({feature})")
        }
        _ => "a feature of the image".into(),
    }
}

/// An image of floats, or one channel of it; there is no alpha.
fn of_floats(mut data: Vec<f32>, width: u32, height: u32, channel: Option<Channel>) -> Bitmap {
    if let Some(channel) = channel {
        for pixel in data.as_chunks_mut::<3>().0 {
            *pixel = [match channel {
                Channel::Alpha => 1.0,
                color => pixel[color as usize],
            }; 3];
        }
    }
    let warnings = make_finite(&mut data);
    Bitmap {
        width,
        height,
        texels: Texels::Rgb32F(data),
        warnings,
    }
}

fn decode(
    bytes: &[u8],
    format: ImageFormat,
    raw: bool,
    channel: Option<Channel>,
    file: &Path,
) -> Result<Bitmap, ImageError> {
    let error = |error: image::ImageError| match error {
        image::ImageError::Unsupported(what) => ImageError::unsupported(file, feature(&what)),
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
    let is_float = matches!(
        image.color(),
        image::ColorType::Rgb32F | image::ColorType::Rgba32F
    );
    let (image, channel) = match channel {
        Some(channel) if image.color().bytes_per_pixel() == image.color().channel_count() => {
            let mut rgba = image.into_rgba8();
            for pixel in rgba.pixels_mut() {
                let value = pixel.0[channel as usize];
                pixel.0 = [value, value, value, 255];
            }
            (DynamicImage::from(rgba), None)
        }
        Some(channel) => {
            let floats = image.into_rgba32f();
            let grey = image::ImageBuffer::from_fn(width, height, |x, y| {
                image::Rgb([floats.get_pixel(x, y).0[channel as usize]; 3])
            });
            (DynamicImage::ImageRgb32F(grey), Some(channel))
        }
        None => (image, None),
    };
    let is_encoded = !raw && channel.is_some() && !is_float;
    let mut warnings = Vec::new();
    let texels = match &image {
        DynamicImage::ImageLuma8(_)
        | DynamicImage::ImageLumaA8(_)
        | DynamicImage::ImageRgb8(_)
        | DynamicImage::ImageRgba8(_) => Texels::Rgba8 {
            data: image.into_rgba8().into_raw(),
            srgb: !raw,
        },
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let mut data = image.into_rgb32f().into_raw();
            if is_encoded {
                data.iter_mut().for_each(|v| *v = srgb_to_linear(*v));
            }
            warnings = make_finite(&mut data);
            Texels::Rgb32F(data)
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
        warnings,
    })
}

impl Bitmap {
    /// The image with values that were read raw decoded by a power: linear = encoded^gamma.
    #[must_use]
    pub fn with_gamma(self, gamma: f32) -> Bitmap {
        self.decoded(|encoded| encoded.abs().powf(gamma).copysign(encoded))
    }

    /// The image with values that were read raw decoded as sRGB.
    #[must_use]
    pub fn with_srgb(self) -> Bitmap {
        match self.texels {
            Texels::Rgba8 { data, .. } => Bitmap {
                texels: Texels::Rgba8 { data, srgb: true },
                ..self
            },
            Texels::Rgb32F(_) => self.decoded(srgb_to_linear),
        }
    }

    fn decoded(self, decode: impl Fn(f32) -> f32) -> Bitmap {
        let data = match self.texels {
            Texels::Rgb32F(data) => data.into_iter().map(decode).collect(),
            Texels::Rgba8 { data, .. } => {
                let table: Vec<f32> = (0..=255).map(|i| decode(i as f32 / 255.0)).collect();
                data.as_chunks::<4>()
                    .0
                    .iter()
                    .flat_map(|texel| [texel[0], texel[1], texel[2]])
                    .map(|byte| table[usize::from(byte)])
                    .collect()
            }
        };
        Bitmap {
            texels: Texels::Rgb32F(data),
            ..self
        }
    }
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
fn from_exr(exr: &ExrImage, channel: Option<Channel>, file: &Path) -> Result<Bitmap, ImageError> {
    if channel == Some(Channel::Alpha)
        && let Some(alpha) = exr.channel("A")
    {
        let data = alpha.iter().flat_map(|&a| [a; 3]).collect();
        return Ok(of_floats(data, exr.width, exr.height, None));
    }
    let Some((layer, planes)) = color_planes(exr) else {
        let names: Vec<&str> = exr.channels.iter().map(|(name, _)| name.as_str()).collect();
        let what = format!("an image with the channels {}", names.join(", "));
        return Err(ImageError::unsupported(file, what));
    };
    let pixels = exr.width as usize * exr.height as usize;
    let mut data = Vec::with_capacity(pixels * 3);
    for i in 0..pixels {
        data.extend(planes.map(|plane| plane[i]));
    }
    let mut bitmap = of_floats(data, exr.width, exr.height, channel);
    bitmap.warnings.extend(exr.warnings.iter().cloned());
    if let Some(layer) = layer
        && exr
            .channels
            .iter()
            .any(|(name, _)| !name.starts_with(layer))
    {
        bitmap.warnings.push(format!(
            "there are several layers and none without a name; \"{}\" is read",
            layer.trim_end_matches('.')
        ));
    }
    Ok(bitmap)
}

/// The planes, and the layer with its dot if it has a name.
fn color_planes(exr: &ExrImage) -> Option<(Option<&str>, [&[f32]; 3])> {
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
        .find_map(|layer| Some(((!layer.is_empty()).then_some(layer), of_layer(layer)?)))
        .or_else(|| {
            let mut colors = exr.channels.iter().filter(|(name, _)| name != "A");
            match (colors.next(), colors.next()) {
                (Some((_, only)), None) => Some((None, [only.as_slice(); 3])),
                _ => None,
            }
        })
}

/// Replaces values that are not finite; returns warnings.
fn make_finite(data: &mut [f32]) -> Vec<String> {
    let mut repaired = 0_usize;
    for value in data {
        if !value.is_finite() {
            repaired += 1;
            *value = match *value {
                v if v.is_nan() => 0.0,
                v => MAX_HALF.copysign(v),
            };
        }
    }
    if repaired == 0 {
        return Vec::new();
    }
    vec![format!("{repaired} values are not finite and are replaced")]
}
