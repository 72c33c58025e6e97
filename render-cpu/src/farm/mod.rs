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

mod error;
pub mod folder;
pub mod merge;
pub mod plan;
pub mod ranges;
pub mod record;
pub mod slurm;
pub mod status;
pub mod task;

pub use error::FarmError;
