//! Writing a picture in the format that the file's name says.
//!
//! OpenEXR, PFM and Radiance files get the values as they are; PNG and JPEG what [`super::png_output`] makes of them.

use super::exr_output::{ChannelValues, LayeredImage, write_exr};
use super::metadata::ImageMetadata;
use super::picture::Picture;
use super::png_output::{Look, tone_map_with, write_png_bytes};
use crate::atomic_file::{WriteError, write_atomically};
use image::codecs::hdr::HdrEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder, ImageError, Rgb};
use std::io::{self, Write};
use std::path::Path;

/// Quality of JPEG files, of 100.
const JPEG_QUALITY: u8 = 95;

/// Formats of image files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// OpenEXR: layers and linear values.
    Exr,
    /// Portable float maps.
    Pfm,
    /// Radiance: values with a common exponent.
    Hdr,
    /// Pictures to look at.
    Png,
    /// The same, smaller.
    Jpeg,
}

/// Endings of the names of the formats that can be written.
pub const EXTENSIONS: [&str; 6] = ["exr", "pfm", "hdr", "png", "jpg", "jpeg"];

impl ImageFormat {
    /// The format that a file's name asks for.
    pub fn of_file(path: &Path) -> Option<ImageFormat> {
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        Some(match extension.as_str() {
            "exr" => ImageFormat::Exr,
            "pfm" => ImageFormat::Pfm,
            "hdr" => ImageFormat::Hdr,
            "png" => ImageFormat::Png,
            "jpg" | "jpeg" => ImageFormat::Jpeg,
            _ => return None,
        })
    }

    /// Whether it holds radiance rather than what a screen shows of it.
    pub fn is_linear(self) -> bool {
        matches!(self, ImageFormat::Exr | ImageFormat::Pfm | ImageFormat::Hdr)
    }
}

/// Writes a picture, atomically.
///
/// # Errors
/// If the file cannot be written; nothing is left under its name then.
pub fn write_picture(
    path: &Path,
    format: ImageFormat,
    picture: &Picture,
    look: Look,
) -> Result<(), WriteError> {
    let (width, height) = (picture.window.width, picture.window.height);
    let screen = || {
        let pixels: Vec<[f64; 3]> = picture.pixels.iter().map(|p| p.map(f64::from)).collect();
        tone_map_with(&pixels, look)
    };
    match format {
        ImageFormat::Exr => {
            let channel = |c: usize| picture.pixels.iter().map(|p| p[c]).collect();
            let names = ["R", "G", "B"].into_iter().enumerate();
            let image = LayeredImage {
                width,
                height,
                offset: picture.window.origin,
                full_size: picture.full_size,
                channels: names
                    .map(|(c, name)| (name.to_owned(), ChannelValues::Float(channel(c))))
                    .collect(),
                metadata: ImageMetadata {
                    software: concat!("halflight ", env!("CARGO_PKG_VERSION")).to_owned(),
                    ..ImageMetadata::default()
                },
            };
            write_exr(path, &image, false)
        }
        ImageFormat::Png => write_png_bytes(path, width, height, &screen()),
        ImageFormat::Jpeg => {
            let bytes = screen();
            write_atomically(path, |file| {
                JpegEncoder::new_with_quality(file, JPEG_QUALITY)
                    .write_image(&bytes, width, height, ExtendedColorType::Rgb8)
                    .map_err(io_error)
            })
        }
        ImageFormat::Hdr => {
            // The format has no negative values and no infinities.
            let value = |v: f32| if v > 0.0 { v.min(f32::MAX) } else { 0.0 };
            let pixels: Vec<Rgb<f32>> = picture.pixels.iter().map(|p| Rgb(p.map(value))).collect();
            write_atomically(path, |file| {
                HdrEncoder::new(file)
                    .encode(&pixels, width as usize, height as usize)
                    .map_err(io_error)
            })
        }
        ImageFormat::Pfm => write_atomically(path, |file| {
            write!(file, "PF\n{width} {height}\n-1.0\n")?;
            // From the bottom row to the top one.
            for row in picture.pixels.chunks(width.max(1) as usize).rev() {
                for value in row.iter().flatten() {
                    file.write_all(&value.to_le_bytes())?;
                }
            }
            Ok(())
        }),
    }
}

fn io_error(error: ImageError) -> io::Error {
    match error {
        ImageError::IoError(error) => error,
        other => io::Error::other(other),
    }
}
