//! One task: its share of the samples into its checkpoint, however often it is killed and started again.
//!
//! What is there decides where it begins: nothing to do where a record says that the share is done and the bytes agree; from
//! the checkpoint where there is a sound one; else from the start. A checkpoint that is damaged, or a finished film that is
//! not what its record says, is removed: its samples are a function of scene, seed and index, so nothing is lost but time.

use super::error::FarmError;
use super::folder::Folder;
use super::plan::{Division, Plan};
use super::record::{Record, record_file};
use crate::accel::Accel;
use crate::film::Film;
use crate::film::checkpoint::{CheckpointError, load_checkpoint};
use crate::render::{
    Backend, CheckpointFile, CpuBackend, Observer, Outcome, PassEnd, PassError, RunState, Stop,
    render_with,
};
use std::io;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// What a task has come to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskOutcome {
    /// It is rendered.
    Done,
    /// It had been rendered before.
    AlreadyDone,
    /// It was asked to stop; its checkpoint holds what there is.
    Interrupted,
}

/// A backend that takes samples of a task's own pixels only.
struct OwnPixels<'a> {
    threads: CpuBackend<'a>,
    /// By rows: one for the task's pixels, zero for others.
    is_own: Vec<u32>,
}

impl Backend for OwnPixels<'_> {
    fn pass(
        &mut self,
        film: &mut Film,
        per_pixel: u32,
        counts: Option<&[u32]>,
        stop: &Stop<'_>,
    ) -> Result<PassEnd, PassError> {
        let wanted = |pixel: usize| counts.map_or(per_pixel, |counts| counts[pixel]);
        let own = self.is_own.iter().enumerate();
        let counts: Vec<u32> = own.map(|(pixel, own)| own * wanted(pixel)).collect();
        self.threads.pass(film, per_pixel, Some(&counts), stop)
    }
}

/// Saves checkpoints between passes.
struct Saving {
    checkpoint: CheckpointFile,
}

impl Observer for Saving {
    fn after_pass(&mut self, state: &RunState, film: &Film) -> Result<(), PassError> {
        self.checkpoint.save_if_due(state, film);
        Ok(())
    }
}

/// Renders a task to its end, or until `stop` is set; a checkpoint is saved every `interval`.
///
/// # Errors
/// When the plan has no such task, the scene is not the planned one, or the checkpoint cannot be written.
pub fn run_task(
    folder: &Folder,
    plan: &Plan,
    index: u32,
    interval: Duration,
    stop: &AtomicBool,
) -> Result<TaskOutcome, FarmError> {
    if index >= plan.tasks {
        return Err(FarmError::Request(format!(
            "the farm has {} tasks, from 0 on; there is no task {index}",
            plan.tasks
        )));
    }
    let path = folder.film(0, index);
    if let Some(record) = Record::read(&path)? {
        if record.is_of(&path)? {
            return Ok(TaskOutcome::AlreadyDone);
        }
        tracing::warn!("{} is torn; it is rendered again", path.display());
        remove(&path)?;
        remove(&record_file(&path))?;
    }
    let share = plan.share(index);
    let settings = plan.settings_of(share);
    let scene = plan.scene.load()?;
    plan.check(&scene)?;
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let clamp = plan.scene.look.clamp.unwrap_or(f32::INFINITY);
    let (mut film, mut state) = match load_checkpoint(&path, &settings) {
        Ok((progress, film)) => {
            let state = RunState {
                passes: progress.passes,
                samples: progress.next_sample,
                seconds: progress.render_seconds,
            };
            tracing::info!("resumed after {} samples per pixel", state.samples);
            (film, state)
        }
        Err(CheckpointError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
            start(plan, &scene)?
        }
        Err(CheckpointError::Malformed { file, what }) => {
            tracing::warn!("{}: {what}; it is rendered again", file.display());
            remove(&path)?;
            start(plan, &scene)?
        }
        Err(other) => return Err(other.into()),
    };
    film.set_clamp(clamp);
    let mut observer = Saving {
        checkpoint: CheckpointFile::new(path.clone(), settings, interval, &state),
    };
    let options = plan.options(share);
    let mut threads = CpuBackend::new(&scene, &accel, &options);
    let mut own_pixels;
    let backend: &mut dyn Backend = if plan.division == Division::Pixels {
        let [width, height] = [film.width(), film.height()];
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        own_pixels = OwnPixels {
            threads,
            is_own: pixels
                .map(|(x, y)| plan.has_pixel(index, x, y, width).into())
                .collect(),
        };
        &mut own_pixels
    } else {
        &mut threads
    };
    let outcome = render_with(
        backend,
        &options,
        &mut film,
        &mut state,
        stop,
        &mut observer,
    );
    observer
        .checkpoint
        .save(&state, &film)
        .map_err(FarmError::Render)?;
    match outcome.map_err(FarmError::Render)? {
        Outcome::Interrupted => Ok(TaskOutcome::Interrupted),
        Outcome::Finished => {
            Record::write(&path, state.samples, state.seconds, Vec::new())?;
            Ok(TaskOutcome::Done)
        }
    }
}

/// A film without samples.
fn start(plan: &Plan, scene: &crate::scene::build::Scene) -> Result<(Film, RunState), FarmError> {
    let camera = &scene.tables.camera;
    let [width, height] = camera.crop_size;
    let parts = scene.parts.layer_names();
    let film = Film::with_parts(width, height, camera.crop_offset, plan.aovs()?, parts)?;
    Ok((film, RunState::default()))
}

/// Removes a file that may be gone already.
fn remove(path: &Path) -> Result<(), FarmError> {
    match std::fs::remove_file(path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => Err(FarmError::Io {
            file: path.to_owned(),
            source,
        }),
        _ => Ok(()),
    }
}
