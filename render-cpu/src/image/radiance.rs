//! Headers of Radiance pictures, for a decoder that supports the common pixel order only.
//!
//! The last line of a header gives the sizes and the order of the pixels: `-Y 4 +X 6` is four rows of six from the top
//! left, and each sign and the order of the axes may be another (Ward, "Real Pixels", Graphics Gems II, and the Radiance
//! manual). [`normalize`] writes a header of the common order, and [`Order::apply`] reorders the pixels. Values are not
//! changed, as in Mitsuba: `EXPOSURE` and `COLORCORR` are not undone.

use super::ImageError;
use std::path::Path;

/// The order of a picture's pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Order {
    /// Scanlines are columns.
    is_transposed: bool,
    /// Columns go from right to left.
    flips_x: bool,
    /// Rows go from bottom to top.
    flips_y: bool,
}

/// Whether the bytes begin as a Radiance picture does.
pub(super) fn is_radiance(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#?RADIANCE") || bytes.starts_with(b"#?RGBE")
}

/// The picture with a header of the common order, its own order, and the parts of the header that are ignored.
pub(super) fn normalize(
    bytes: &[u8],
    file: &Path,
) -> Result<(Vec<u8>, Order, Vec<String>), ImageError> {
    let malformed = |what: &str| ImageError::malformed(file, format!("damaged image: {what}"));
    let mut warnings = Vec::new();
    let mut rest = bytes;
    loop {
        let line = line(&mut rest).ok_or_else(|| malformed("the header does not end"))?;
        let text = String::from_utf8_lossy(line);
        let text = text.trim();
        if text.is_empty() {
            break;
        }
        match text
            .split_once('=')
            .map(|(name, value)| (name.trim(), value.trim()))
        {
            Some(("FORMAT", "32-bit_rle_rgbe")) | None => {}
            Some(("FORMAT", "32-bit_rle_xyze")) => {
                return Err(ImageError::unsupported(
                    file,
                    "a Radiance picture in CIE XYZ (32-bit_rle_xyze)",
                ));
            }
            Some(("FORMAT", format)) => {
                return Err(ImageError::unsupported(
                    file,
                    format!("a Radiance picture of the format \"{format}\""),
                ));
            }
            Some((name @ ("EXPOSURE" | "COLORCORR"), value)) => {
                let is_neutral = value
                    .split_ascii_whitespace()
                    .all(|number| number.parse() == Ok(1.0_f32));
                if !is_neutral {
                    warnings.push(format!("{name}={value} in the header is not undone"));
                }
            }
            Some(_) => {}
        }
    }
    let sizes = line(&mut rest).ok_or_else(|| malformed("the header names no size"))?;
    let sizes = String::from_utf8_lossy(sizes);
    let words: Vec<&str> = sizes.split_ascii_whitespace().collect();
    let &[first, lines, second, length] = &words[..] else {
        return Err(malformed("the header names no size"));
    };
    let (y, x, is_transposed) = match (first, second) {
        (y @ ("-Y" | "+Y"), x @ ("-X" | "+X")) => (y, x, false),
        (x @ ("-X" | "+X"), y @ ("-Y" | "+Y")) => (y, x, true),
        _ => return Err(malformed("the order of the pixels cannot be understood")),
    };
    let mut common =
        format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {lines} +X {length}\n").into_bytes();
    common.extend_from_slice(rest);
    let order = Order {
        is_transposed,
        flips_x: x == "-X",
        flips_y: y == "+Y",
    };
    Ok((common, order, warnings))
}

impl Order {
    /// The pixels of `lines` scanlines of `length`, from top left to bottom right; width and height.
    pub(super) fn apply(self, data: Vec<f32>, length: u32, lines: u32) -> (Vec<f32>, u32, u32) {
        let (width, height) = if self.is_transposed {
            (lines, length)
        } else {
            (length, lines)
        };
        let is_common = !(self.is_transposed || self.flips_x || self.flips_y);
        if is_common {
            return (data, width, height);
        }
        let mut ordered = Vec::with_capacity(data.len());
        for y in 0..height {
            for x in 0..width {
                let x = if self.flips_x { width - 1 - x } else { x };
                let y = if self.flips_y { height - 1 - y } else { y };
                let (line, column) = if self.is_transposed { (x, y) } else { (y, x) };
                let at = 3 * (line as usize * length as usize + column as usize);
                ordered.extend_from_slice(&data[at..at + 3]);
            }
        }
        (ordered, width, height)
    }
}

/// The next line, without its end.
fn line<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let end = rest.iter().position(|&b| b == b'\n')?;
    let line = &rest[..end];
    *rest = &rest[end + 1..];
    Some(line)
}
