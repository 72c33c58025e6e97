//! Image files: textures as [`Bitmap`]s, and OpenEXR files with all their layers.
//!
//! # Limits
//! Every reader judges an image by its header before it allocates: at most [`MAX_DIMENSION`] pixels per side,
//! [`MAX_SAMPLES`] samples, and no more decoded bytes than the file's length times [`MAX_COMPRESSION_RATIO`] (plus a
//! small allowance). Memory is therefore proportional to the file.

pub mod bitmap;
pub mod camera_attributes;
mod error;
pub mod exr_output;
pub mod exr_read;
pub mod merge;
pub mod merge_error;
mod merge_layers;
mod merge_shares;
pub mod metadata;
mod pfm;
pub mod picture;
pub mod picture_output;
pub mod png_output;
mod radiance;
pub mod window;

pub use bitmap::{Bitmap, Channel, Texels, load_bitmap, load_channel, read_bitmap};
pub use error::ImageError;
pub use exr_read::{ExrImage, read_exr, read_exr_bytes};

use std::path::Path;

/// Largest width and height of an image, in pixels.
pub const MAX_DIMENSION: u32 = 1 << 16;

/// Most samples (pixels times channels) of an image: a square of 16384 pixels with four channels.
pub const MAX_SAMPLES: u64 = 4 << 28;

/// Largest ratio of decoded to encoded bytes that is believed. The densest codecs in use reach 1032 (deflate) and about
/// 1500 (the first scan of a progressive JPEG).
pub const MAX_COMPRESSION_RATIO: u64 = 2048;

/// Decoded bytes that are believed of any file, however short.
const RATIO_ALLOWANCE: u64 = 1 << 20;

/// Most bytes that a file of this length is believed to decode to.
fn believable_bytes(file_bytes: usize) -> u64 {
    (file_bytes as u64)
        .saturating_mul(MAX_COMPRESSION_RATIO)
        .saturating_add(RATIO_ALLOWANCE)
}

/// Most bytes of a file that is read into memory.
const MAX_FILE_BYTES: u64 = 16 << 30;

fn read_file(path: &Path) -> Result<Vec<u8>, ImageError> {
    crate::bytes::read_file(path, MAX_FILE_BYTES).map_err(|source| ImageError::Io {
        file: path.to_owned(),
        source,
    })
}
