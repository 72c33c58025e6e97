//! Farms: one image rendered by many processes that share only a folder.
//!
//! ```text
//!   out.farm/plan.json            what is rendered, and how it is divided        (plan)
//!   out.farm/tasks/000000.*       a checkpoint per task, and its record          (task, record)
//!   out.farm/merge-1/000000.*     films merged by tens, and their records        (merge)
//!   out.farm/log/                 output of the processes
//!   out.exr                       the image
//! ```
//!
//! A *task* renders a share of the samples into its checkpoint. If it is killed at any time and started again on any machine,
//! it continues from there. When it is done it writes a *record* with the SHA-256 of the finished file; merging accepts no
//! film without one. Films are merged as a tree of fixed shape, so that the image does not depend on when or where its tasks
//! ran, and memory does not depend on their number: a merge holds two films.
//!
//! Scheduling is left to others: [`slurm`] writes scripts for Slurm; any system that can start `halflight farm task FOLDER N`
//! for N from 0 on serves as well.
//!
//! The film of a task is a function of its samples alone, and so is a film that is merged in a fixed order. Compared with one
//! process that takes the same samples: if the work is divided by pixels, the images agree to the last bit; if it is divided by
//! samples, the running mean of a pixel (f64) is computed from other partial sums and differs by a few parts in 1e16, which
//! is visible where it changes the rounding of a value to f32.
//!
//! Invariants (tests): an image does not change with kills, restarts and torn files; a task that is done is not rendered
//! again; torn files are detected by their digests.

mod error;
pub mod folder;
pub mod merge;
pub mod plan;
mod planned_scene;
pub mod ranges;
pub mod record;
pub mod slurm;
pub mod status;
pub mod task;

pub use error::FarmError;
