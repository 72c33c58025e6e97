//! One run at a time on a file that a run goes on from.
//!
//! Two runs with one checkpoint would render the same samples and replace each other's file. So a run holds a lock, as long as it
//! lives, on `.NAME.lock` beside the file; the file itself does not do, because it is replaced by every new one. Where files cannot
//! be locked, as on some network file systems, runs are not kept apart.

use crate::atomic_file::destination;
use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

/// A lock that this process holds; the file of the lock is removed with it.
#[derive(Debug)]
pub struct RunLock {
    path: PathBuf,
    _file: File,
}

/// Another run holds the lock.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} is in use by another run; wait for it, or name another file", .0.display())]
pub struct InUse(pub PathBuf);

impl RunLock {
    /// Takes the lock of a file, which need not exist; none where locks do not work.
    ///
    /// # Errors
    /// If another run holds it.
    pub fn take(file: &Path) -> Result<Option<RunLock>, InUse> {
        let target = destination(file);
        let Some(name) = target.file_name() else {
            return Ok(None);
        };
        let mut lock_name = std::ffi::OsString::from(".");
        lock_name.push(name);
        lock_name.push(".lock");
        let path = target.with_file_name(lock_name);
        loop {
            let options = OpenOptions::new()
                .create(true)
                .truncate(false)
                .write(true)
                .open(&path);
            let Ok(lock) = options else {
                return Ok(None);
            };
            match lock.try_lock() {
                // Who held it may have removed it just before.
                Ok(()) if !path.exists() => {}
                Ok(()) => return Ok(Some(RunLock { path, _file: lock })),
                Err(TryLockError::WouldBlock) => return Err(InUse(file.to_owned())),
                Err(TryLockError::Error(error)) => {
                    tracing::debug!("{} cannot be locked: {error}", path.display());
                    // Empty, and of no use.
                    let _ = std::fs::remove_file(&path);
                    return Ok(None);
                }
            }
        }
    }
}

impl Drop for RunLock {
    fn drop(&mut self) {
        // Still locked, so that no other process has it by then.
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_is_held_once_and_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("c");
        let lock = RunLock::take(&file).unwrap();
        assert!(lock.is_some());
        assert_eq!(RunLock::take(&file).unwrap_err(), InUse(file.clone()));
        assert!(RunLock::take(&folder.path().join("d")).unwrap().is_some());
        drop(lock);
        assert!(RunLock::take(&file).unwrap().is_some());
        assert_eq!(folder.path().read_dir().unwrap().count(), 0);
    }

    #[cfg(unix)]
    #[test]
    fn names_of_one_file_have_one_lock() {
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("c"), folder.path().join("l"));
        std::os::unix::fs::symlink("c", &link).unwrap();
        let _lock = RunLock::take(&file).unwrap();
        assert!(RunLock::take(&link).is_err());
    }
}
