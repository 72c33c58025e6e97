//! Scripts for Slurm: an array of tasks, and merges that depend on it.
//!
//! | file | what it does |
//! |---|---|
//! | `render.sbatch` | one task per element of the array; its argument is added to the index |
//! | `merge-L.sbatch` | one node of level L per element |
//! | `submit.sh` | submits what is open, in this order, each level when the one below has ended |
//!
//! Tasks can be requeued at any time: they go on from their checkpoint. Slurm does so by itself after a preemption or the
//! loss of a node (`--requeue`); a minute before the time limit it sends SIGTERM, on which a task saves its checkpoint and
//! requeues itself. Merges start when the tasks have ended, well or not (`afterany`): a merge names what is missing, where
//! one that waited for success would wait for ever.
//!
//! Slurm's arrays end at `MaxArraySize`, 1001 by default: larger farms are several arrays.

use super::error::FarmError;
use super::folder::Folder;
use super::plan::Plan;
use super::ranges::ranges;
use crate::atomic_file::write_atomically;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Elements of an array.
const ARRAY: u32 = 1000;

/// Exit code of a task that has saved its checkpoint and wants to be started again (EX_TEMPFAIL of sysexits.h).
pub const EXIT_AGAIN: u8 = 75;

/// How tasks are run.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct SlurmOptions {
    /// The program.
    pub program: PathBuf,
    /// Processors of a task.
    pub cpus: Option<u32>,
    /// Time limit of a task, as Slurm writes it.
    pub time_limit: Option<String>,
    /// Time between two checkpoints, as `farm task` takes it.
    pub checkpoint_interval: Option<String>,
    /// Further options of sbatch, for all jobs.
    pub options: Vec<String>,
}

/// A word of a shell script.
fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', "'\\''"))
}

fn quoted_path(path: &Path) -> String {
    quoted(&path.to_string_lossy())
}

/// The first lines of a script. Only what follows `#SBATCH` without a shell's quotes is understood by all versions, so that
/// paths are given on the command line.
fn header(name: &str, options: &SlurmOptions) -> String {
    let mut text = format!("#!/bin/bash\n#SBATCH --job-name={name}\n#SBATCH --open-mode=append\n");
    for option in &options.options {
        let _ = writeln!(text, "#SBATCH {option}");
    }
    text
}

/// The script of a task.
fn render_script(folder: &Folder, options: &SlurmOptions) -> String {
    let mut text = header("halflight", options);
    text.push_str("#SBATCH --requeue\n#SBATCH --signal=B:TERM@60\n");
    if let Some(cpus) = options.cpus {
        let _ = writeln!(text, "#SBATCH --cpus-per-task={cpus}");
    }
    if let Some(limit) = &options.time_limit {
        let _ = writeln!(text, "#SBATCH --time={limit}");
    }
    let _ = write!(
        text,
        r#"
task=$(($1 + SLURM_ARRAY_TASK_ID))
echo "task $task on $(hostname), restart ${{SLURM_RESTART_COUNT:-0}}"
child=
# The signal before the time limit comes to this shell.
trap '[ -n "$child" ] && kill -TERM "$child"' TERM
{program} farm task --threads "${{SLURM_CPUS_PER_TASK:-0}}" --checkpoint-interval {interval} {folder} "$task" &
child=$!
wait "$child"
code=$?
if [ "$code" -gt 128 ] && kill -0 "$child" 2>/dev/null; then
    wait "$child"
    code=$?
fi
if [ "$code" = {EXIT_AGAIN} ]; then
    scontrol requeue "${{SLURM_ARRAY_JOB_ID}}_${{SLURM_ARRAY_TASK_ID}}"
fi
exit "$code"
"#,
        program = quoted_path(&options.program),
        interval = quoted(options.checkpoint_interval.as_deref().unwrap_or("30s")),
        folder = quoted_path(&folder.0),
    );
    text
}

/// The script of a node.
fn merge_script(folder: &Folder, options: &SlurmOptions, level: usize) -> String {
    let mut text = header("halflight-merge", options);
    let _ = write!(
        text,
        "#SBATCH --requeue\n\nexec {} farm merge {} --level {level} --node $(($1 + SLURM_ARRAY_TASK_ID))\n",
        quoted_path(&options.program),
        quoted_path(&folder.0),
    );
    text
}

/// Indices as arrays of at most [`ARRAY`] elements: what is added to the elements, and the elements.
fn arrays(indices: &[u32]) -> Vec<(u32, String)> {
    let chunks = indices.chunk_by(|a, b| a / ARRAY == b / ARRAY);
    chunks
        .map(|chunk| {
            let offset = chunk[0] / ARRAY * ARRAY;
            let elements: Vec<u32> = chunk.iter().map(|i| i - offset).collect();
            (offset, ranges(&elements))
        })
        .collect()
}

/// The commands that submit `tasks` and the merges after them.
fn submit_script(folder: &Folder, plan: &Plan, tasks: &[u32]) -> String {
    let mut text = String::from(
        "#!/bin/bash\n# Submits the open tasks of a farm and the merges that depend on them.\nset -euo pipefail\n",
    );
    let _ = writeln!(text, "farm={}", quoted_path(&folder.0));
    text.push_str("jobs=\n");
    let mut submit = |script: &str, log: &str, indices: &[u32]| {
        text.push_str("after=${jobs:+--dependency=afterany$jobs}\njobs=\n");
        for (offset, elements) in arrays(indices) {
            let _ = writeln!(
                text,
                "id=$(sbatch --parsable $after --array={elements} --output=\"$farm/log/{log}-{offset}+%a.log\" \
                 \"$farm/{script}.sbatch\" {offset})\njobs=$jobs:${{id%%;*}}\necho \"{script} {elements}: job ${{id%%;*}}\""
            );
        }
    };
    if !tasks.is_empty() {
        submit("render", "task", tasks);
    }
    for (level, &count) in plan.levels().iter().enumerate().skip(1) {
        let nodes: Vec<u32> = (0..count).collect();
        let name = format!("merge-{level}");
        submit(&name, &name, &nodes);
    }
    text
}

/// Writes the scripts of a farm, with the tasks that are to be submitted; returns that of the submission.
///
/// # Errors
/// When a file cannot be written.
pub fn write_scripts(
    folder: &Folder,
    plan: &Plan,
    options: &SlurmOptions,
    tasks: &[u32],
) -> Result<PathBuf, FarmError> {
    let write = |name: &str, text: &str| {
        let path = folder.0.join(name);
        write_atomically(&path, |file| file.write_all(text.as_bytes()))?;
        Ok::<PathBuf, FarmError>(path)
    };
    write("render.sbatch", &render_script(folder, options))?;
    for level in 1..plan.levels().len() {
        let script = merge_script(folder, options, level);
        write(&format!("merge-{level}.sbatch"), &script)?;
    }
    let options = serde_json::to_string_pretty(options).unwrap_or_default();
    write("slurm.json", &options)?;
    write("submit.sh", &submit_script(folder, plan, tasks))
}

/// The options that the scripts of a farm were written with.
///
/// # Errors
/// When the farm has no scripts for Slurm.
pub fn read_options(folder: &Folder) -> Result<SlurmOptions, FarmError> {
    let file = folder.0.join("slurm.json");
    let text = std::fs::read(&file).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => FarmError::Request(format!(
            "{} has no scripts for Slurm (it was made by farm plan): run its tasks by \"halflight farm task\"",
            folder.0.display()
        )),
        _ => FarmError::Io {
            file: file.clone(),
            source,
        },
    })?;
    serde_json::from_slice(&text).map_err(|e| FarmError::Malformed {
        file,
        what: e.to_string(),
    })
}

/// Runs the submission, which prints its job numbers.
///
/// # Errors
/// When there is no bash, or sbatch refuses.
pub fn submit(script: &Path) -> Result<(), FarmError> {
    let status = Command::new("bash")
        .arg(script)
        .status()
        .map_err(|source| FarmError::Io {
            file: script.to_owned(),
            source,
        })?;
    if status.success() {
        Ok(())
    } else {
        Err(FarmError::Request(format!(
            "{} failed; what it submitted before goes on",
            script.display()
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_farms_are_several_arrays() {
        let all: Vec<u32> = (0..2500).collect();
        let expected = [(0, "0-999"), (1000, "0-999"), (2000, "0-499")];
        let found = arrays(&all);
        assert!(found.iter().map(|(o, e)| (*o, e.as_str())).eq(expected));
        assert_eq!(
            arrays(&[3, 999, 1000, 2001]),
            [
                (0, "3,999".to_owned()),
                (1000, "0".to_owned()),
                (2000, "1".to_owned())
            ]
        );
    }

    #[test]
    fn paths_with_quotes_stay_one_word() {
        assert_eq!(quoted("it's a $farm"), r"'it'\''s a $farm'");
    }
}
