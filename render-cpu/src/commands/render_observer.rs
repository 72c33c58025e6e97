//! What happens between the passes of `halflight render`: a progress report and checkpoints.

use crate::film::Film;
use crate::film::checkpoint::{Progress, Settings, save_checkpoint};
use crate::render::progress::ProgressReport;
use crate::render::{Observer, RunState};
use std::error::Error;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Reports progress and saves checkpoints between passes.
pub(super) struct RunObserver {
    /// To the terminal.
    pub report: ProgressReport,
    /// Where the run is saved, if it is.
    pub checkpoint: Option<Checkpoint>,
}

/// The file of a run's state.
pub(super) struct Checkpoint {
    path: PathBuf,
    settings: Settings,
    saved: Instant,
    interval: Duration,
    /// Passes of the state that the file holds.
    passes: u32,
}

impl Checkpoint {
    /// A file that holds, or will hold, the state of a run.
    pub fn new(
        path: PathBuf,
        settings: Settings,
        interval: Duration,
        state: &RunState,
    ) -> Checkpoint {
        Checkpoint {
            path,
            settings,
            saved: Instant::now(),
            interval,
            passes: state.passes,
        }
    }

    /// Writes the file, unless it holds this state already.
    pub fn save(
        &mut self,
        state: &RunState,
        film: &Film,
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
        if self.passes == state.passes {
            return Ok(());
        }
        let progress = Progress {
            settings: self.settings.clone(),
            passes: state.passes,
            next_sample: state.samples,
            render_seconds: state.seconds,
        };
        save_checkpoint(&self.path, &progress, film)?;
        self.saved = Instant::now();
        self.passes = state.passes;
        Ok(())
    }
}

impl Observer for RunObserver {
    fn after_pass(
        &mut self,
        state: &RunState,
        film: &Film,
    ) -> Result<(), Box<dyn Error + Send + Sync>> {
        self.report.update(state, film);
        if let Some(checkpoint) = &mut self.checkpoint
            && checkpoint.saved.elapsed() >= checkpoint.interval
            && let Err(error) = checkpoint.save(state, film)
        {
            // A full disk now may be free again at the end; the film in memory is not given up for it.
            tracing::warn!("no checkpoint was saved: {error}");
            checkpoint.saved = Instant::now();
        }
        Ok(())
    }
}
