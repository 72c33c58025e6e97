//! What happens between the passes of `halflight render`: a progress report and checkpoints.

use super::preview::Previews;
use crate::film::Film;
use crate::render::progress::ProgressReport;
use crate::render::{CheckpointFile, Observer, RunState};
use std::error::Error;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// Reports progress and saves checkpoints between passes.
pub(super) struct RunObserver {
    /// To the terminal.
    pub report: ProgressReport,
    /// Where the run is saved, if it is.
    pub checkpoint: Option<CheckpointFile>,
    /// Where it is shown.
    pub previews: Previews,
}

impl Observer for RunObserver {
    fn after_pass(
        &mut self,
        state: &RunState,
        film: &Film,
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
        self.report.update(state, film);
        if let Some(checkpoint) = &mut self.checkpoint {
            checkpoint.save_if_due(state, film);
        }
        self.previews.show(film, false);
        Ok(())
    }

    fn counter(&self) -> Option<Arc<AtomicU64>> {
        self.report.counter()
    }
}
