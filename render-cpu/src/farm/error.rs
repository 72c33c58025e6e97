//! What can go wrong with a farm.

use super::ranges::ranges;
use crate::atomic_file::WriteError;
use crate::film::FilmError;
use crate::film::checkpoint::CheckpointError;
use crate::scene::error::SceneError;
use std::io;
use std::path::PathBuf;

/// Why something about a farm cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum FarmError {
    /// The request is inconsistent.
    #[error("{0}")]
    Request(String),
    /// The scene cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The film cannot be made.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// A checkpoint cannot be used.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file of the farm cannot be read.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: io::Error,
    },
    /// A file of the farm is none.
    #[error("{}: {what}", file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// Scene or program are not those of the plan.
    #[error("the scene is not the one that was planned: {differences}")]
    OtherScene {
        /// Names and values of what differs.
        differences: String,
    },
    /// Tasks that a merge needs are missing or torn.
    #[error("{}", incomplete(missing, torn))]
    Incomplete {
        /// Tasks that are not done.
        missing: Vec<u32>,
        /// Files that do not agree with their records.
        torn: Vec<PathBuf>,
    },
    /// Rendering failed.
    #[error("{0}")]
    Render(Box<dyn std::error::Error + Send + Sync>),
}

/// What is missing, in one line.
fn incomplete(missing: &[u32], torn: &[PathBuf]) -> String {
    let mut parts = Vec::new();
    if !missing.is_empty() {
        parts.push(format!("not done yet: {}", ranges(missing)));
    }
    if !torn.is_empty() {
        let names: Vec<_> = torn.iter().map(|p| p.display().to_string()).collect();
        parts.push(format!("torn: {}", names.join(", ")));
    }
    format!(
        "{}; `halflight farm resume` has them rendered",
        parts.join("; ")
    )
}
