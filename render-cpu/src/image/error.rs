//! What can be wrong with an image file.

use std::path::{Path, PathBuf};

/// Why an image could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file could not be opened or read.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The bytes are not a valid image of their format, or end too early.
    #[error("{}: {what}", file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A valid image that this reader does not take.
    #[error("{}: {what} is not supported", file.display())]
    Unsupported {
        /// The file.
        file: PathBuf,
        /// The unsupported feature.
        what: String,
    },
    /// The header announces more pixels than the limits of [`super`] allow, or than the file's length can hold.
    #[error("{}: an image of {width} x {height} pixels is refused: {why}", file.display())]
    TooLarge {
        /// The file.
        file: PathBuf,
        /// Announced width.
        width: u64,
        /// Announced height.
        height: u64,
        /// Which limit is exceeded.
        why: String,
    },
}

impl ImageError {
    pub(super) fn malformed(file: &Path, what: impl Into<String>) -> ImageError {
        ImageError::Malformed {
            file: file.to_owned(),
            what: what.into(),
        }
    }

    pub(super) fn unsupported(file: &Path, what: impl Into<String>) -> ImageError {
        ImageError::Unsupported {
            file: file.to_owned(),
            what: what.into(),
        }
    }
}
