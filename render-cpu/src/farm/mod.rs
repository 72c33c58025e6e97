//! Farms: one image rendered by many processes that share nothing but a folder.
//!
//! ```text
//!   out.farm/plan.json            what is rendered, and how it is divided        (plan)
//!   out.farm/tasks/000000.*       a checkpoint per task, and its record          (task, record)
//!   out.farm/merge-1/000000.*     films merged by tens, and their records        (merge)
//!   out.farm/log/                 what the processes said
//!   out.exr                       the image
//! ```
//!
//! A *task* renders a share of the samples into its checkpoint. Killed at any time and started again, anywhere, it goes on
//! from there. When it is done it writes a *record* with the SHA-256 of the finished file; merging believes nothing else.
//! Films are merged as a tree of fixed shape, so that the image does not depend on when or where its tasks ran, and memory
//! does not depend on their number: a merge holds two films.
//!
//! Schedulers are other people's: [`slurm`] writes the scripts of one; whatever can start `halflight farm task FOLDER N` for
//! N from 0 on serves as well.
//!
//! What tasks find is a function of their samples alone, and so is a film that is merged in a fixed order. Beside one process
//! with the same samples: divided by pixels, the image is its image to the last bit; divided by samples, a pixel's running
//! mean (f64) is that of other partial sums, a few parts in 1e16 away, which shows where it decides how a value rounds to f32.
//!
//! Invariants (tests): an image does not change with kills, restarts and torn files; a task that is done is not rendered
//! again; what is torn is found by its digest.

pub mod folder;
pub mod merge;
pub mod plan;
pub mod record;
pub mod slurm;
pub mod status;
pub mod task;

use crate::atomic_file::WriteError;
use crate::film::FilmError;
use crate::film::checkpoint::CheckpointError;
use crate::scene::error::SceneError;
use std::io;
use std::path::PathBuf;

/// Why something about a farm cannot be done.
#[derive(Debug, thiserror::Error)]
pub enum FarmError {
    /// What was asked makes no farm.
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
        /// Files that are not what their records say.
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
        parts.push(format!("not done yet: {}", status::ranges(missing)));
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
