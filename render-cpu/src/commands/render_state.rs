//! Where a run of `halflight render` begins: with nothing, or where an earlier one stopped; and how it goes on after that.

use super::render_args::RenderArgs;
use crate::film::checkpoint::{CheckpointError, load_checkpoint};
use crate::film::{Film, FilmError};
use crate::render::record::{CLAMP, run_settings};
use crate::render::{CheckpointFile, Goal, RenderOptions, RunState};
use crate::run_lock::RunLock;
use crate::say::note;
use crate::scene::build::Scene;
use std::error::Error;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

impl RenderArgs {
    /// The film and its state, and the file that the state is saved to, if any. A checkpoint that is there is gone on from or
    /// refused, never replaced by a run that begins anew.
    ///
    /// # Errors
    /// If a checkpoint cannot be read or is of another image, or the film does not fit into memory.
    pub(super) fn begin(
        &self,
        scene: &Scene,
        options: &RenderOptions,
    ) -> Result<(Film, RunState, Option<CheckpointFile>), Box<dyn Error + Send + Sync>> {
        let camera = &scene.tables.camera;
        let [width, height] = camera.crop_size;
        let layers = self.layers(scene);
        let clamp = self.look.clamp.unwrap_or(f32::INFINITY);
        let parts = || scene.parts.layer_names();
        let empty = || {
            let mut film = Film::with_parts(width, height, camera.crop_offset, layers, parts())?;
            film.set_clamp(clamp);
            Ok::<_, FilmError>(film)
        };
        let Some((from, path)) = self.checkpoint_files()? else {
            return Ok((empty()?, RunState::default(), None));
        };
        let lock = RunLock::take(&path)?;
        // Only checkpoints hold them, and the tables of a large scene take a while to read.
        let mut settings = run_settings(&self.scene.scene, scene, options, layers);
        if let Some(clamp) = self.look.clamp {
            settings.insert(CLAMP.to_owned(), clamp.to_string());
        }
        let (film, state) = match from {
            Some(from) => {
                let (progress, mut film) = load_checkpoint(&from, &settings).map_err(explained)?;
                film.set_clamp(clamp);
                let state = RunState {
                    passes: progress.passes,
                    samples: progress.next_sample,
                    seconds: progress.render_seconds,
                };
                tracing::info!("resumed after {} samples per pixel", state.samples);
                if let Goal::Samples(goal) = options.goal
                    && goal < state.samples
                {
                    tracing::warn!(
                        "{} holds {} samples per pixel already, more than the {goal} asked for; the image has them all",
                        from.display(),
                        state.samples
                    );
                }
                (film, state)
            }
            None => (empty()?, RunState::default()),
        };
        let file =
            CheckpointFile::new(path, settings, self.checkpoint_interval, &state).with_lock(lock);
        Ok((film, state, Some(file)))
    }

    /// The file to go on from, if there is one, and the one to save to.
    fn checkpoint_files(&self) -> Result<Option<(Option<PathBuf>, PathBuf)>, String> {
        let is_there = |path: &Path| path.symlink_metadata().is_ok();
        Ok(match (&self.checkpoint, &self.resume) {
            (None, None) => None,
            (Some(path), None) => Some((is_there(path).then(|| path.clone()), path.clone())),
            (None, Some(path)) => Some((Some(path.clone()), path.clone())),
            (Some(path), Some(from)) => {
                let real = |path: &Path| path.canonicalize().ok();
                if is_there(path) && real(path) != real(from) {
                    return Err(format!(
                        "{} is there already and is not replaced; --checkpoint {0} alone goes on from it",
                        path.display()
                    ));
                }
                Some((Some(from.clone()), path.clone()))
            }
        })
    }

    /// Says how an interrupted run goes on.
    pub(super) fn report_interruption(&self, is_saved: bool) {
        if is_saved {
            let command = command_to_go_on(std::env::args_os(), self.checkpoint.is_some());
            note(format_args!("interrupted; to go on: {command}"));
        } else {
            note("interrupted; with --checkpoint FILE, the same command would go on another time");
        }
    }
}

/// With what can be done about it.
fn explained(error: CheckpointError) -> Box<dyn Error + Send + Sync> {
    match error {
        CheckpointError::OtherSettings { .. } => {
            format!("{error}; it is not replaced: name another file to begin anew").into()
        }
        other => other.into(),
    }
}

/// The command line of this run for a shell, without `--resume` where a checkpoint of its own has more than that file by now.
fn command_to_go_on(arguments: impl Iterator<Item = OsString>, has_own: bool) -> String {
    let mut words = Vec::new();
    let mut arguments = arguments.map(|word| word.to_string_lossy().into_owned());
    while let Some(word) = arguments.next() {
        if has_own && word == "--resume" {
            arguments.next();
        } else if !(has_own && word.starts_with("--resume=")) {
            words.push(quoted(&word));
        }
    }
    words.join(" ")
}

/// A word as shells read it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_=+,./:@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_that_goes_on_is_one_for_a_shell() {
        let command = |words: &[&str], has_own| {
            command_to_go_on(words.iter().map(|w| OsString::from(*w)), has_own)
        };
        let words = [
            "halflight",
            "render",
            "it's here.xml",
            "-D",
            "a=$b",
            "--resume",
            "a",
        ];
        assert_eq!(
            command(&words, false),
            r"halflight render 'it'\''s here.xml' -D 'a=$b' --resume a"
        );
        let words = ["h", "--resume", "a", "--resume=b", "--checkpoint", "c", ""];
        assert_eq!(command(&words, true), "h --checkpoint c ''");
    }
}
