//! The checkpoint file of a run, written at intervals and when the run ends.

use super::options::RunState;
use crate::film::Film;
use crate::film::checkpoint::{Progress, Settings, save_checkpoint};
use crate::run_lock::RunLock;
use std::error::Error;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// The file of a run's state.
#[derive(Debug)]
pub struct CheckpointFile {
    path: PathBuf,
    settings: Settings,
    saved: Instant,
    interval: Duration,
    /// Passes of the state that the file holds.
    passes: u32,
    /// Keeps other runs from the file.
    _lock: Option<RunLock>,
}

impl CheckpointFile {
    /// A file that holds, or will hold, the state of a run.
    pub fn new(
        path: PathBuf,
        settings: Settings,
        interval: Duration,
        state: &RunState,
    ) -> CheckpointFile {
        CheckpointFile {
            path,
            settings,
            saved: Instant::now(),
            interval,
            passes: state.passes,
            _lock: None,
        }
    }

    /// The same, with a lock that is held as long.
    pub fn with_lock(self, lock: Option<RunLock>) -> CheckpointFile {
        CheckpointFile {
            _lock: lock,
            ..self
        }
    }

    /// Writes the file, unless it holds this state already.
    ///
    /// # Errors
    /// If the file cannot be written; the previous one is still there then.
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
        tracing::debug!(
            "saved {}, {} samples per pixel",
            self.path.display(),
            state.samples
        );
        Ok(())
    }

    /// Writes the file if the interval is over. A full disk now may be free again at the end: the film in memory is not
    /// given up for it.
    pub fn save_if_due(&mut self, state: &RunState, film: &Film) {
        if self.saved.elapsed() >= self.interval
            && let Err(error) = self.save(state, film)
        {
            tracing::warn!("no checkpoint was saved: {error}");
            self.saved = Instant::now();
        }
    }
}
