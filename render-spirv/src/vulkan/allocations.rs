//! Accounting of the device memory that buffers take.

use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes of device memory that buffers take.
#[derive(Debug)]
pub(super) struct Allocations {
    /// Bytes of all buffers that exist.
    pub used: AtomicU64,
    /// The most that there have been.
    pub peak: AtomicU64,
    /// Beyond this an allocation counts as out of memory.
    pub limit: AtomicU64,
}

impl Default for Allocations {
    fn default() -> Allocations {
        Allocations {
            used: AtomicU64::new(0),
            peak: AtomicU64::new(0),
            limit: AtomicU64::new(u64::MAX),
        }
    }
}

impl Allocations {
    /// Counts an allocation; false, and nothing counted, beyond the limit.
    pub(super) fn add(&self, bytes: u64) -> bool {
        let used = self.used.fetch_add(bytes, Ordering::Relaxed) + bytes;
        if used > self.limit.load(Ordering::Relaxed) {
            self.remove(bytes);
            return false;
        }
        self.peak.fetch_max(used, Ordering::Relaxed);
        true
    }

    /// Subtracts a buffer that is freed.
    pub(super) fn remove(&self, bytes: u64) {
        self.used.fetch_sub(bytes, Ordering::Relaxed);
    }
}
