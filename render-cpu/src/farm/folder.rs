//! The folder of a farm: its plan, and the names of films and logs.

use super::error::FarmError;
use super::plan::Plan;
use crate::atomic_file::write_atomically;
use crate::bytes::read_file;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Longest plan that is read.
const MAX_PLAN_BYTES: u64 = 16 << 20;

/// A farm's folder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Folder(pub PathBuf);

impl Folder {
    /// The folder of an image, unless another is named: `out.farm` for `out.exr`.
    pub fn of_output(output: &Path) -> Folder {
        Folder(output.with_extension("farm"))
    }

    /// Writes a plan into a new folder.
    ///
    /// # Errors
    /// When the folder holds another plan already, or cannot be written.
    pub fn create(&self, plan: &Plan) -> Result<(), FarmError> {
        let io = |file: &Path| {
            let file = file.to_owned();
            move |source| FarmError::Io { file, source }
        };
        if self.plan_file().exists() {
            let old = self.plan()?;
            if old != *plan {
                return Err(FarmError::Request(format!(
                    "{} holds a farm with another plan; remove the folder, or name another with --folder",
                    self.0.display()
                )));
            }
        }
        for (level, _) in plan.levels().iter().enumerate() {
            let folder = self.level(level);
            std::fs::create_dir_all(&folder).map_err(io(&folder))?;
        }
        let log = self.log();
        std::fs::create_dir_all(&log).map_err(io(&log))?;
        let text = serde_json::to_string_pretty(plan).map_err(|e| FarmError::Malformed {
            file: self.plan_file(),
            what: e.to_string(),
        })?;
        write_atomically(&self.plan_file(), |file| file.write_all(text.as_bytes()))?;
        Ok(())
    }

    /// Reads the plan.
    ///
    /// # Errors
    /// When there is none, or it is none of this program's.
    pub fn plan(&self) -> Result<Plan, FarmError> {
        let file = self.plan_file();
        let bytes = read_file(&file, MAX_PLAN_BYTES).map_err(|source| FarmError::Io {
            file: file.clone(),
            source,
        })?;
        let malformed = |what: String| FarmError::Malformed {
            file: file.clone(),
            what,
        };
        let plan: Plan = serde_json::from_slice(&bytes)
            .map_err(|e| malformed(format!("this is no plan of a farm: {e}")))?;
        if plan.is_sound() {
            Ok(plan)
        } else {
            Err(malformed("the plan contradicts itself".to_owned()))
        }
    }

    fn plan_file(&self) -> PathBuf {
        self.0.join("plan.json")
    }

    /// Where films of a level are: 0 for tasks.
    pub fn level(&self, level: usize) -> PathBuf {
        match level {
            0 => self.0.join("tasks"),
            level => self.0.join(format!("merge-{level}")),
        }
    }

    /// A film of a level.
    pub fn film(&self, level: usize, index: u32) -> PathBuf {
        self.level(level).join(format!("{index:06}.checkpoint"))
    }

    /// What processes say.
    pub fn log(&self) -> PathBuf {
        self.0.join("log")
    }
}
