//! Stamps of what is committed beside its sources: a hash over the names and bytes of all files that it was made from, so that a
//! test fails when it is older than they are.
//!
//! FNV-1a, 64 bits: a name and a `/` for each of its parts, then the bytes; line ends do not count, so that a checkout with other
//! ones has the same stamp.

use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};

/// The start of [`fnv`].
pub const FNV: u64 = 0xcbf2_9ce4_8422_2325;

/// FNV-1a over bytes, continued from `hash`.
pub fn fnv(hash: u64, bytes: &[u8]) -> u64 {
    bytes.iter().fold(hash, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// A hash of the names and bytes of files, and of all files in folders that `is_source` accepts, below the folder `root`.
///
/// # Errors
/// If one of them cannot be read.
pub fn source_hash(
    root: &Path,
    sources: &[&str],
    is_source: impl Fn(&Path) -> bool,
) -> io::Result<u64> {
    let mut files = Vec::new();
    for source in sources {
        collect(&root.join(source), &is_source, &mut files)?;
    }
    // The order of reading a folder is the file system's.
    files.sort();
    let mut hash = FNV;
    for file in files {
        let name = file.strip_prefix(root).unwrap_or(&file);
        for part in name {
            hash = fnv(hash, part.as_encoded_bytes());
            hash = fnv(hash, b"/");
        }
        let mut bytes = std::fs::read(&file)?;
        bytes.retain(|&b| b != b'\r');
        hash = fnv(hash, &bytes);
    }
    Ok(hash)
}

/// A file, or all sources of a folder.
fn collect(
    path: &Path,
    is_source: &impl Fn(&Path) -> bool,
    files: &mut Vec<PathBuf>,
) -> io::Result<()> {
    if !path.is_dir() {
        files.push(path.to_path_buf());
        return Ok(());
    }
    for entry in std::fs::read_dir(path)? {
        let path = entry?.path();
        // What a build leaves behind is no source.
        let is_folder = path.is_dir() && path.file_name() != Some(OsStr::new("target"));
        if is_folder || (!path.is_dir() && is_source(&path)) {
            collect(&path, is_source, files)?;
        }
    }
    Ok(())
}
