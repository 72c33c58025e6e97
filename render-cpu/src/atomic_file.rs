//! Atomic writing of files: a file exists completely or not at all.
//!
//! The content goes to a temporary file in the same folder, is flushed to the disk, and only then takes the final
//! name by a rename, which file systems do in one step. A full disk, a crash or a kill therefore leaves the previous
//! file or none under the final name, never half of one. A killed process can leave a `.NAME.*.partial` behind.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

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
    let target = match path.canonicalize() {
        Ok(target) if !target.is_file() => {
            return Err(io::Error::other("it exists and is no regular file"));
        }
        Ok(target) => target,
        Err(_) => path.to_owned(),
    };
    let name = target
        .file_name()
        .ok_or_else(|| io::Error::other("it has no file name"))?;
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    // A prefix of the name, because the longest names leave no room for more.
    let prefix: String = std::iter::once('.')
        .chain(name.to_string_lossy().chars().take(48))
        .chain(['.'])
        .collect();
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".partial");
    #[cfg(unix)]
    {
        // The usual mode of new files, less the user's mask; temporary files are private by default.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let (file, temporary) = builder.tempfile_in(folder)?.into_parts();
    let mut writer = BufWriter::new(file);
    write(&mut writer)?;
    writer.flush()?;
    let file = writer
        .into_inner()
        .map_err(io::IntoInnerError::into_error)?;
    file.sync_all()?;
    drop(file);
    temporary.persist(&target).map_err(|e| e.error)?;
    // The rename itself lives in the folder; some file systems refuse to flush folders, which loses nothing written.
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}
