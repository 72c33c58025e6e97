//! Reading whole files into memory, with a limit on their size.
//!
//! Readers of this crate take byte slices; only this module gets them from the file system. Anything but a regular file (a
//! device, a pipe, a directory) is refused, because it may never end, and so is what a failed download leaves instead of a
//! file: a pointer of Git LFS, a web page.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Reads a regular file of at most `max_bytes`.
///
/// # Errors
/// Those of the operating system; [`io::ErrorKind::InvalidInput`] for anything but a regular file,
/// [`io::ErrorKind::FileTooLarge`] for more than `max_bytes`, [`io::ErrorKind::InvalidData`] for what [`mistaken`] detects.
pub fn read_file(path: &Path, max_bytes: u64) -> io::Result<Vec<u8>> {
    let file = File::open(path)?;
    let metadata = file.metadata()?;
    if !metadata.is_file() {
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "not a regular file",
        ));
    }
    let too_large = || {
        io::Error::new(
            io::ErrorKind::FileTooLarge,
            format!("longer than {max_bytes} bytes"),
        )
    };
    if metadata.len() > max_bytes {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(metadata.len() as usize)
        .map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    // The file may grow while it is read.
    file.take(max_bytes + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > max_bytes {
        return Err(too_large());
    }
    tracing::debug!("read {}, {} bytes", path.display(), bytes.len());
    match mistaken(path, &bytes) {
        Some(what) => Err(io::Error::new(io::ErrorKind::InvalidData, what)),
        None => Ok(bytes),
    }
}

/// Detects a pointer of Git LFS or a web page instead of the file; returns a sentence about it.
pub fn mistaken(path: &Path, bytes: &[u8]) -> Option<String> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if bytes.starts_with(b"version https://git-lfs.github.com/spec/") {
        return Some(
            "is a pointer to a file in Git LFS; \"git lfs pull\" in its repository fetches the file itself"
                .into(),
        );
    }
    let start = bytes.trim_ascii_start();
    let begins = |with: &[u8]| {
        start
            .get(..with.len())
            .is_some_and(|start| start.eq_ignore_ascii_case(with))
    };
    if !begins(b"<!doctype html") && !begins(b"<html") {
        return None;
    }
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    Some(match extension.to_uppercase().as_str() {
        "" => "is a web page".into(),
        // Letters whose names begin with a vowel.
        name if name.starts_with(['A', 'E', 'F', 'H', 'I', 'L', 'M', 'N', 'O', 'R', 'S', 'X']) => {
            format!("is a web page, not an {name} file")
        }
        name => format!("is a web page, not a {name} file"),
    })
}

/// The format of an image, in capitals as in "PNG", if the bytes begin like one.
pub fn image_format(bytes: &[u8]) -> Option<String> {
    let format = image::guess_format(bytes).ok()?;
    Some(match format {
        image::ImageFormat::OpenExr => "OpenEXR".to_owned(),
        other => other.extensions_str().first()?.to_uppercase(),
    })
}
