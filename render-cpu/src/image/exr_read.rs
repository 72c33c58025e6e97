//! Reading OpenEXR files as planes of `f32`, with any names of channels.
//!
//! Scan lines or tiles, any number of parts, half, float and unsigned samples, every compression of the `exr` crate.
//! Only the largest resolution level is read. Parts (layers) prefix the names of their channels: channel `R` of part
//! `albedo` is `albedo.R`, which is also how a single-part file spells its layers.
//!
//! # Hostile files
//! The header is parsed and judged by the limits of [`super`] before any pixel storage is allocated. Blocks are copied by
//! our own code with checked lengths instead of the crate's image builders, which index without checks; a block that
//! occurs twice or not at all is an error. So is a DWA block whose counters are implausible, by which the crate would
//! reserve memory. Its B44 decoder (`exr` 1.74.2) subtracts with overflow, which panics where overflow is checked, so
//! decoding runs under `catch_unwind`, in this thread, and a panic becomes [`ImageError::Malformed`].

use super::{ImageError, MAX_DIMENSION, MAX_SAMPLES, believable_bytes, read_file};
use crate::bytes::image_format;
use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock};
use exr::block::reader::ChunksReader;
use exr::compression::Compression;
use exr::meta::attribute::{AttributeValue, SampleType};
use exr::meta::header::Header;
use std::borrow::Cow;
use std::collections::HashSet;
use std::io::Cursor;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// An OpenEXR image: one plane of samples per channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExrImage {
    /// Width of the data window in pixels.
    pub width: u32,
    /// Height of the data window in pixels.
    pub height: u32,
    /// First pixel of the data window, in the coordinates of the display window.
    pub origin: [i32; 2],
    /// Width and height of the display window: the whole image, of which this may be a crop.
    pub display_size: [u32; 2],
    /// Name and `width * height` samples of each channel, rows from top to bottom; sorted by name within a part.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Name and value of each attribute that is text, a number or a matrix, as text, sorted by name. Parts after the first
    /// prefix the names of theirs like those of channels.
    pub attributes: Vec<(String, String)>,
    /// What was left out, a sentence each.
    pub warnings: Vec<String>,
}

impl ExrImage {
    /// The samples of the channel of exactly this name.
    pub fn channel(&self, name: &str) -> Option<&[f32]> {
        let (_, samples) = self.channels.iter().find(|(n, _)| n == name)?;
        Some(samples)
    }

    /// Samples of every pixel: of the layer `samples`, or as many for all as the attribute `samplesPerPixel` says.
    pub fn sample_counts(&self) -> Option<Cow<'_, [f32]>> {
        if let Some(counts) = self.channel("samples") {
            return Some(Cow::Borrowed(counts));
        }
        let count: f32 = self.attribute("samplesPerPixel")?.parse().ok()?;
        let pixels = self.width as usize * self.height as usize;
        Some(Cow::Owned(vec![count; pixels]))
    }

    /// The value of the attribute of exactly this name.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        let (_, value) = self.attributes.iter().find(|(n, _)| n == name)?;
        Some(value)
    }
}

/// Reads an OpenEXR file.
///
/// # Errors
/// When the file cannot be read, is not OpenEXR, is damaged, is deep or subsampled, or exceeds the limits above.
pub fn read_exr(path: impl AsRef<Path>) -> Result<ExrImage, ImageError> {
    let path = path.as_ref();
    read_exr_bytes(&read_file(path)?, path)
}

/// Reads an OpenEXR file from memory; `file` is for messages only.
///
/// # Errors
/// As [`read_exr`].
pub fn read_exr_bytes(bytes: &[u8], file: &Path) -> Result<ExrImage, ImageError> {
    if let Some(name) = image_format(bytes)
        && name != "OpenEXR"
    {
        let what = format!("is no OpenEXR file, but of the format {name}");
        return Err(ImageError::malformed(file, what));
    }
    // The decoder works on its own locals only, and they are dropped: nothing broken is observed afterwards.
    catch_unwind(AssertUnwindSafe(|| decode(bytes, file))).unwrap_or_else(|_| {
        Err(ImageError::malformed(
            file,
            "the file is damaged in a way that its decoder did not foresee",
        ))
    })
}

fn exr_error(file: &Path, error: exr::error::Error) -> ImageError {
    match error {
        exr::error::Error::NotSupported(what) => ImageError::unsupported(file, what),
        other => ImageError::malformed(file, format!("damaged OpenEXR file: {other}")),
    }
}

fn decode(bytes: &[u8], file: &Path) -> Result<ExrImage, ImageError> {
    let reader =
        exr::block::read(Cursor::new(bytes), false).map_err(|error| exr_error(file, error))?;
    let headers: Vec<Header> = reader.headers().to_vec();
    check_headers(&headers, bytes.len(), file)?;

    // Parts of another size cannot share planes with the first: they are left out.
    let size = headers[0].layer_size;
    let (width, height) = (size.width(), size.height());
    let mut image = ExrImage {
        width: width as u32,
        height: height as u32,
        origin: [
            headers[0].own_attributes.layer_position.x(),
            headers[0].own_attributes.layer_position.y(),
        ],
        display_size: {
            let size = headers[0].shared_attributes.display_window.size;
            [size.width(), size.height()].map(|side| u32::try_from(side).unwrap_or(u32::MAX))
        },
        ..ExrImage::default()
    };
    let mut first_channel = Vec::with_capacity(headers.len());
    for (part, header) in headers.iter().enumerate() {
        let prefix = match &header.own_attributes.layer_name {
            Some(name) if headers.len() > 1 => format!("{name}."),
            _ => String::new(),
        };
        collect_attributes(header, if part == 0 { "" } else { &prefix }, &mut image);
        first_channel.push(image.channels.len());
        if header.layer_size != size {
            image.warnings.push(format!(
                "part {part} differs in size from the first and is left out"
            ));
            continue;
        }
        for channel in &header.channels.list {
            let samples = vec![0.0; width * height];
            image
                .channels
                .push((format!("{prefix}{}", channel.name), samples));
        }
    }

    let chunks = reader
        .filter_chunks(false, |meta, tile, block| {
            tile.is_largest_resolution_level() && meta.headers[block.layer].layer_size == size
        })
        .map_err(|error| exr_error(file, error))?;
    let meta = chunks.meta_data().clone();
    let mut seen = HashSet::new();
    for chunk in chunks {
        let chunk = chunk.map_err(|error| exr_error(file, error))?;
        if !has_plausible_counts(&chunk, &headers) {
            return Err(ImageError::malformed(
                file,
                "a DWA block announces more data than it can decode to",
            ));
        }
        let block = UncompressedBlock::decompress_chunk(chunk, &meta, false)
            .map_err(|error| exr_error(file, error))?;
        let index = block.index;
        // The offset table is not trusted: it may lead to blocks that were not asked for, or twice to one.
        if index.level != exr::math::Vec2(0, 0)
            || headers[index.layer].layer_size != size
            || !seen.insert((
                index.layer,
                index.pixel_position.x(),
                index.pixel_position.y(),
            ))
        {
            return Err(ImageError::malformed(
                file,
                "a block of pixels occurs twice, another is missing",
            ));
        }
        let planes = &mut image.channels[first_channel[index.layer]..];
        copy_block(&block, &headers[index.layer], planes, width, height)
            .ok_or_else(|| ImageError::malformed(file, "a block of pixels has the wrong length"))?;
    }
    image.attributes.sort();
    Ok(image)
}

fn check_headers(headers: &[Header], file_bytes: usize, file: &Path) -> Result<(), ImageError> {
    let mut samples = 0_u64;
    let mut decoded_bytes = 0_u64;
    for header in headers {
        let (width, height) = (
            header.layer_size.width() as u64,
            header.layer_size.height() as u64,
        );
        let refuse = |why: &str| {
            Err(ImageError::TooLarge {
                file: file.to_owned(),
                width,
                height,
                why: why.to_owned(),
            })
        };
        if width == 0 || height == 0 || header.channels.list.is_empty() {
            return Err(ImageError::malformed(
                file,
                "the image has no pixels or no channels",
            ));
        }
        if width > u64::from(MAX_DIMENSION) || height > u64::from(MAX_DIMENSION) {
            return refuse("a side is too long");
        }
        samples = samples.saturating_add(width * height * header.channels.list.len() as u64);
        decoded_bytes = decoded_bytes.saturating_add(
            (width * height).saturating_mul(header.channels.bytes_per_pixel as u64),
        );
        if samples > MAX_SAMPLES {
            return refuse("too many samples");
        }
        if decoded_bytes > believable_bytes(file_bytes) {
            return refuse("the file is too short to hold them");
        }
        // The crate reserves a whole block at a time, and a block may be larger than its image.
        if max_block_bytes(header) > believable_bytes(file_bytes) {
            return refuse("the file is too short to hold one of its tiles");
        }
    }
    if headers.is_empty() {
        return Err(ImageError::malformed(file, "the file holds no image"));
    }
    Ok(())
}

/// Decoded size of the largest block that the header allows; `Header::max_block_byte_size` without overflow.
fn max_block_bytes(header: &Header) -> u64 {
    let size = header.max_block_pixel_size();
    (size.width() as u64)
        .saturating_mul(size.height() as u64)
        .saturating_mul(header.channels.bytes_per_pixel as u64)
}

/// Whether the counters of a DWA block fit its extent; true for all other compressions.
///
/// A DWA block begins with eleven 64-bit counters, by which the crate (1.74.2) reserves memory unseen: 1 is the decoded
/// size of the section without transform, 6 and 7 the sizes of the run-length section, 8 and 9 the numbers of AC and DC
/// coefficients. None exceeds the block by more than the padding to 8 x 8 pixels.
fn has_plausible_counts(chunk: &Chunk, headers: &[Header]) -> bool {
    let header = &headers[chunk.layer_index];
    if !matches!(
        header.compression,
        Compression::DWAA(_) | Compression::DWAB(_)
    ) {
        return true;
    }
    let bytes = match &chunk.compressed_block {
        CompressedBlock::ScanLine(block) => &block.compressed_pixels_le,
        CompressedBlock::Tile(block) => &block.compressed_pixels_le,
        _ => return false,
    };
    // A block that compression would lengthen is stored as it is. Coordinates out of range are the crate's to refuse.
    let extent = header
        .get_block_data_indices(&chunk.compressed_block)
        .and_then(|tile| header.get_absolute_block_pixel_coordinates(tile));
    let pixels = extent.map_or(0, |extent| extent.size.area());
    if bytes.len() == pixels * header.channels.bytes_per_pixel {
        return true;
    }
    let (counters, _) = bytes.as_chunks::<8>();
    let limit = max_block_bytes(header)
        .saturating_mul(16)
        .saturating_add(1 << 16);
    [1, 6, 7, 8, 9].iter().all(|&k: &usize| {
        let counter = counters.get(k).copied().map(u64::from_le_bytes);
        counter.is_none_or(|counter| counter <= limit)
    })
}

/// Copies a block's samples to its part's planes; `None` when its length does not fit its extent.
fn copy_block(
    block: &UncompressedBlock,
    header: &Header,
    planes: &mut [(String, Vec<f32>)],
    width: usize,
    height: usize,
) -> Option<()> {
    let (x, y) = (
        block.index.pixel_position.x(),
        block.index.pixel_position.y(),
    );
    let (block_width, block_height) = (block.index.pixel_size.x(), block.index.pixel_size.y());
    if x.checked_add(block_width)? > width || y.checked_add(block_height)? > height {
        return None;
    }
    // Line by line, and within a line channel by channel.
    let mut rest = &block.data[..];
    for row in y..y + block_height {
        for (channel, (_, plane)) in header.channels.list.iter().zip(planes.iter_mut()) {
            let line = &mut plane[row * width + x..][..block_width];
            let bytes_per_sample = channel.sample_type.bytes_per_sample();
            let bytes = rest.split_off(..block_width * bytes_per_sample)?;
            match channel.sample_type {
                SampleType::F16 => {
                    for (to, from) in line.iter_mut().zip(bytes.chunks_exact(2)) {
                        *to = exr::prelude::f16::from_ne_bytes([from[0], from[1]]).to_f32();
                    }
                }
                SampleType::F32 => {
                    for (to, from) in line.iter_mut().zip(bytes.chunks_exact(4)) {
                        *to = f32::from_ne_bytes([from[0], from[1], from[2], from[3]]);
                    }
                }
                SampleType::U32 => {
                    for (to, from) in line.iter_mut().zip(bytes.chunks_exact(4)) {
                        *to = u32::from_ne_bytes([from[0], from[1], from[2], from[3]]) as f32;
                    }
                }
            }
        }
    }
    rest.is_empty().then_some(())
}

fn collect_attributes(header: &Header, prefix: &str, image: &mut ExrImage) {
    for (name, value) in header.all_named_attributes() {
        let text = match value {
            AttributeValue::Text(text) => String::from_utf8_lossy(text.as_slice()).into_owned(),
            AttributeValue::F32(number) => number.to_string(),
            AttributeValue::F64(number) => number.to_string(),
            AttributeValue::I32(number) => number.to_string(),
            AttributeValue::Matrix4x4(numbers) => {
                let numbers: Vec<String> = numbers.iter().map(ToString::to_string).collect();
                numbers.join(" ")
            }
            _ => continue,
        };
        let name = String::from_utf8_lossy(name);
        image.attributes.push((format!("{prefix}{name}"), text));
    }
}
