//! Atomic writing of files: a file exists completely or not at all.
//!
//! The content goes to a temporary file in the same folder, is flushed to the disk, and only then takes the final
//! name by a rename, which file systems do in one step. A full disk, a crash or a kill therefore leaves the previous
//! file or none under the final name, never half of one. A killed process can leave a `.NAME.*.partial` behind; the next one
//! that writes the same name removes it. Files that are being written are locked, so that they are not removed.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Links that are followed one after the other.
const MAX_LINKS: usize = 40;

/// End of the names of temporary files.
const SUFFIX: &str = ".partial";

/// A file could not be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    /// The file that was to be written.
    pub path: PathBuf,
    /// What went wrong.
    pub source: io::Error,
}

/// Calls `write` on a temporary file and renames it to `path` when everything succeeded.
/// A symbolic link is followed, so that the file it names is replaced and not the link.
///
/// # Errors
/// If the folder does not take the file, `write` fails, or `path` exists and is no regular file.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), WriteError> {
    write_and_rename(path, write).map_err(|source| WriteError {
        path: path.to_owned(),
        source,
    })
}

fn write_and_rename(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let target = destination(path);
    if target.metadata().is_ok_and(|metadata| !metadata.is_file()) {
        return Err(io::Error::other("it exists and is no regular file"));
    }
    let prefix = prefix(&target).ok_or_else(|| io::Error::other("it has no file name"))?;
    clean_up(&target);
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(SUFFIX);
    #[cfg(unix)]
    {
        // The usual mode of new files, less the user's mask; temporary files are private by default.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let (file, temporary) = loop {
        let (file, temporary) = builder.tempfile_in(folder)?.into_parts();
        // Where files cannot be locked, they are not removed either. Another process may have removed this one before it was locked.
        if file.lock().is_err() || temporary.exists() {
            break (file, temporary);
        }
    };
    let mut writer = BufWriter::new(file);
    write(&mut writer)?;
    writer.flush()?;
    let file = writer
        .into_inner()
        .map_err(io::IntoInnerError::into_error)?;
    file.sync_all()?;
    // Still locked.
    temporary.persist(&target).map_err(|e| e.error)?;
    drop(file);
    // The rename is recorded in the folder; some file systems refuse to flush folders, which loses no written data.
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// The file that a path names, links followed, those to files that are not there yet included.
pub fn destination(path: &Path) -> PathBuf {
    let mut target = path.to_owned();
    for _ in 0..MAX_LINKS {
        if let Ok(real) = target.canonicalize() {
            return real;
        }
        match std::fs::read_link(&target) {
            Ok(link) => target = target.parent().unwrap_or(Path::new("")).join(link),
            Err(_) => break,
        }
    }
    target
}

/// How the names of the temporary files of a file begin: a prefix of its name, because the longest names leave no space for
/// more.
fn prefix(target: &Path) -> Option<String> {
    let name = target.file_name()?.to_string_lossy().into_owned();
    Some(format!(".{}.", name.chars().take(48).collect::<String>()))
}

/// Removes temporary files that killed processes left of a file.
pub fn clean_up(target: &Path) {
    let Some(prefix) = prefix(target) else {
        return;
    };
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if !name.starts_with(&prefix) || !name.ends_with(SUFFIX) {
            continue;
        }
        // Held until it is gone, so that a process that has just made it sees that it was removed.
        let is_left = File::open(entry.path()).and_then(|file| {
            file.try_lock()?;
            std::fs::remove_file(entry.path())
        });
        if is_left.is_ok() {
            tracing::debug!(
                "removed {}, left by a run that was killed",
                entry.path().display()
            );
        }
    }
}
