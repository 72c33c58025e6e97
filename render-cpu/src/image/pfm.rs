//! Portable float maps: three lines of text, then floats.
//!
//! `PF` (three channels) or `Pf` (one), width and height, and a scale: negative for the lowest byte first, and its size
//! multiplies the values, as in Mitsuba. Rows go from the bottom of the image to its top.

use super::{ImageError, MAX_DIMENSION, MAX_SAMPLES};
use std::path::Path;

/// Width, height and the three channels of each pixel, rows from top to bottom.
pub(super) struct FloatMap {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) data: Vec<f32>,
}

/// Whether the bytes begin as a float map does.
pub(super) fn is_pfm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'F' | b'f', next, ..] if next.is_ascii_whitespace())
}

/// Reads a float map; `file` is for messages only.
pub(super) fn read(bytes: &[u8], file: &Path) -> Result<FloatMap, ImageError> {
    let malformed = |what: &str| ImageError::malformed(file, format!("damaged PFM image: {what}"));
    let channels = if bytes.get(1) == Some(&b'F') { 3 } else { 1 };
    let mut rest = &bytes[2..];
    let width: u32 = word(&mut rest).ok_or_else(|| malformed("no width"))?;
    let height: u32 = word(&mut rest).ok_or_else(|| malformed("no height"))?;
    let scale: f32 = word(&mut rest).ok_or_else(|| malformed("no scale"))?;
    // One character of white space ends the header; all that follow are values.
    let mut values = rest.get(1..).unwrap_or(&[]);
    if rest.starts_with(b"\r\n") {
        values = &rest[2..];
    }
    if width == 0 || height == 0 {
        return Err(malformed("it has no pixels"));
    }
    let samples = u64::from(width) * u64::from(height) * channels;
    let needed = samples * 4;
    let too_large = width > MAX_DIMENSION || height > MAX_DIMENSION || samples > MAX_SAMPLES;
    if too_large || needed > values.len() as u64 {
        return Err(ImageError::TooLarge {
            file: file.to_owned(),
            width: width.into(),
            height: height.into(),
            why: if too_large {
                "it is too large".into()
            } else {
                "the file is too short to hold it".into()
            },
        });
    }
    let factor = match scale.abs() {
        size if size.is_finite() && size > 0.0 => size,
        _ => return Err(malformed("the scale is zero or no number")),
    };
    let row = width as usize * channels as usize * 4;
    let mut data = Vec::with_capacity(width as usize * height as usize * 3);
    for line in values[..needed as usize].chunks_exact(row).rev() {
        for word in line.as_chunks::<4>().0 {
            let value = if scale < 0.0 {
                f32::from_le_bytes(*word)
            } else {
                f32::from_be_bytes(*word)
            };
            let repeats = if channels == 3 { 1 } else { 3 };
            data.extend(std::iter::repeat_n(value * factor, repeats));
        }
    }
    Ok(FloatMap {
        width,
        height,
        data,
    })
}

/// The next word of the header.
fn word<T: std::str::FromStr>(rest: &mut &[u8]) -> Option<T> {
    let text = rest.trim_ascii_start();
    // No number is longer.
    let end = text.iter().take(64).position(u8::is_ascii_whitespace)?;
    *rest = &text[end..];
    std::str::from_utf8(&text[..end]).ok()?.parse().ok()
}
