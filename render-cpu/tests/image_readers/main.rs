//! Readers of image files: every variant reads back what was written, and no bytes make them panic or allocate wildly.

mod bitmap_files;
mod damaged;
mod exr_files;

use halflight::image::{Bitmap, ExrImage, read_bitmap, read_exr_bytes};
use std::path::Path;

pub(crate) fn read(bytes: &[u8]) -> Result<ExrImage, String> {
    read_exr_bytes(bytes, Path::new("test.exr")).map_err(|error| error.to_string())
}

pub(crate) fn bitmap(bytes: &[u8], raw: bool, name: &str) -> Result<Bitmap, String> {
    read_bitmap(bytes, raw, Path::new(name)).map_err(|error| error.to_string())
}
