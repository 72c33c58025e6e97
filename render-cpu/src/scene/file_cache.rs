//! A cache of decoded files, for scenes that are built repeatedly.
//!
//! A scene whose parameters change is built anew from its object tree ([`super::xml::ParsedScene::with_values`]). The contents
//! of meshes, bitmaps and measurements do not change, so they are read and decoded once. For a scene that is built once nothing
//! is kept: contents are dropped as soon as they are in the tables.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Type of the contents, path, and how the file was read.
type Key = (TypeId, PathBuf, u64);

/// Contents of files by path; shared by all objects of a scene and by scenes that were made of it.
#[derive(Default)]
pub struct FileCache {
    keeps: AtomicBool,
    contents: Mutex<HashMap<Key, Arc<dyn Any + Send + Sync>>>,
}

impl fmt::Debug for FileCache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FileCache")
            .field("keeps", &self.keeps)
            .finish_non_exhaustive()
    }
}

impl FileCache {
    /// Keeps what is read from now on.
    pub fn keep(&self) {
        self.keeps.store(true, Ordering::Relaxed);
    }

    /// The contents of a file, read unless cached; `variant` distinguishes how the same file is read.
    ///
    /// # Errors
    /// What `read` returns.
    pub fn get<T: Any + Send + Sync, E>(
        &self,
        path: &Path,
        variant: u64,
        read: impl FnOnce() -> Result<T, E>,
    ) -> Result<Arc<T>, E> {
        if !self.keeps.load(Ordering::Relaxed) {
            return read().map(Arc::new);
        }
        let key = (TypeId::of::<T>(), path.to_owned(), variant);
        let known = self.lock().get(&key).cloned();
        if let Some(known) = known.and_then(|known| known.downcast::<T>().ok()) {
            return Ok(known);
        }
        // Not under the lock: several files may be read at a time.
        let contents = Arc::new(read()?);
        self.lock().insert(key, contents.clone());
        Ok(contents)
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<Key, Arc<dyn Any + Send + Sync>>> {
        self.contents.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    #[test]
    fn files_are_read_once_per_variant_when_kept() {
        let files = FileCache::default();
        let reads = std::cell::Cell::new(0);
        let read = |variant| {
            let contents: Result<Arc<u32>, Infallible> = files.get("a".as_ref(), variant, || {
                reads.set(reads.get() + 1);
                Ok(reads.get())
            });
            contents.map_or(0, |n| *n)
        };
        assert_eq!([read(0), read(0)], [1, 2]);
        files.keep();
        assert_eq!([read(0), read(0), read(1), read(0)], [3, 3, 4, 3]);
    }
}
