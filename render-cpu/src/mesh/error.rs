//! What can be wrong with a mesh file, and where in it.

use std::fmt;
use std::path::{Path, PathBuf};

/// The location of an error in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileLocation {
    /// A line of a text file, counted from one.
    Line(u64),
    /// A byte of a binary file, counted from zero.
    Offset(u64),
    /// A byte of the decompressed contents of a compressed file, counted from zero.
    Decompressed(u64),
    /// The mesh as a whole.
    Whole,
}

impl fmt::Display for FileLocation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FileLocation::Line(line) => write!(f, ":{line}"),
            FileLocation::Offset(offset) => write!(f, ": at byte {offset}"),
            FileLocation::Decompressed(offset) => {
                write!(f, ": at byte {offset} after decompression")
            }
            FileLocation::Whole => Ok(()),
        }
    }
}

/// Why a mesh could not be read.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file could not be opened or read.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The contents are not a usable mesh.
    #[error("{}{location}: {what}", file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// Its location in the file.
        location: FileLocation,
        /// What is wrong.
        what: String,
    },
}

impl MeshError {
    pub(super) fn malformed(
        file: &Path,
        location: FileLocation,
        what: impl Into<String>,
    ) -> MeshError {
        MeshError::Malformed {
            file: file.to_owned(),
            location,
            what: what.into(),
        }
    }
}
