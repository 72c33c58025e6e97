//! The status of a farm: which tasks are done, started, missing or torn.

use super::error::FarmError;
use super::folder::Folder;
use super::plan::Plan;
use super::record::Record;
use crate::film::checkpoint::{CheckpointError, read_checkpoint};
use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

/// The status of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskState {
    /// Its film is finished and agrees with its record.
    Done,
    /// There is a sound checkpoint with this many samples per pixel, but no record: it is being rendered, or was stopped.
    Started(u32),
    /// There is neither a film nor a checkpoint.
    Missing,
    /// Its film does not agree with its record, or its checkpoint is damaged.
    Torn,
}

/// The status of a farm.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// The tasks.
    pub tasks: Vec<TaskState>,
    /// Whether the merged image was written after the last task was done.
    pub is_merged: bool,
    /// Bytes of all films that are there.
    pub bytes: u64,
    /// Seconds that finished tasks took together.
    pub seconds: f64,
}

impl Status {
    /// Examines all tasks. Finished films are checked by their length, or, with `verify`, by their digest.
    ///
    /// # Errors
    /// When a file is there but cannot be read.
    pub fn of(folder: &Folder, plan: &Plan, verify: bool) -> Result<Status, FarmError> {
        let mut status = Status {
            tasks: Vec::with_capacity(plan.tasks as usize),
            is_merged: false,
            bytes: 0,
            seconds: 0.0,
        };
        for index in 0..plan.tasks {
            let film = folder.film(0, index);
            status.bytes += std::fs::metadata(&film).map_or(0, |m| m.len());
            let state = match Record::read(&film)? {
                Some(record) => {
                    let is_sound = if verify {
                        record.is_of(&film)?
                    } else {
                        record.has_length(&film)
                    };
                    if is_sound {
                        status.seconds += record.seconds;
                        TaskState::Done
                    } else {
                        TaskState::Torn
                    }
                }
                None => unfinished(&film)?,
            };
            status.tasks.push(state);
        }
        let top = plan.levels().len() - 1;
        let root = folder.film(top, 0);
        status.is_merged = status.tasks.iter().all(|t| *t == TaskState::Done)
            && plan.output.exists()
            && is_current(folder, plan, top, 0)?
            && Record::read(&root)?.is_some_and(|record| record.has_length(&root));
        Ok(status)
    }

    /// The tasks that have to be rendered: all that are not done.
    pub fn open(&self) -> Vec<u32> {
        let tasks = (0..).zip(&self.tasks);
        tasks
            .filter(|(_, state)| **state != TaskState::Done)
            .map(|(index, _)| index)
            .collect()
    }

    /// The tasks in a state.
    pub fn having(&self, wanted: impl Fn(&TaskState) -> bool) -> Vec<u32> {
        let tasks = (0..).zip(&self.tasks);
        tasks
            .filter(|(_, state)| wanted(state))
            .map(|(index, _)| index)
            .collect()
    }
}

/// Whether a node was made from the records that are below it now.
fn is_current(folder: &Folder, plan: &Plan, level: usize, index: u32) -> Result<bool, FarmError> {
    let Some(record) = Record::read(&folder.film(level, index))? else {
        return Ok(false);
    };
    let below = plan.levels()[level - 1];
    let first = index * plan.fan_in;
    let sources = first..below.min(first + plan.fan_in);
    if record.inputs.len() != sources.len() {
        return Ok(false);
    }
    for (source, digest) in sources.zip(&record.inputs) {
        let is_same = Record::read(&folder.film(level - 1, source))?
            .is_some_and(|input| input.sha256 == *digest);
        if !is_same || (level > 1 && !is_current(folder, plan, level - 1, source)?) {
            return Ok(false);
        }
    }
    Ok(true)
}

/// The state of a task without a record.
fn unfinished(film: &Path) -> Result<TaskState, FarmError> {
    let io = |source| FarmError::Io {
        file: film.to_owned(),
        source,
    };
    let file = match File::open(film) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(TaskState::Missing),
        Err(source) => return Err(io(source)),
    };
    let length = file.metadata().map_err(io)?.len();
    match read_checkpoint(&mut BufReader::new(file), length, film) {
        Ok((progress, _)) => Ok(TaskState::Started(progress.next_sample)),
        Err(CheckpointError::Io { source, .. }) => Err(io(source)),
        Err(_) => Ok(TaskState::Torn),
    }
}
