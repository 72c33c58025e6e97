//! When a preview shows the next image: at most once a second, and for at most a tenth of the time.

use std::time::{Duration, Instant};

/// Shortest time between two images.
const INTERVAL: Duration = Duration::from_secs(1);

/// Share of the time that previews may take.
const SHARE: f64 = 0.1;

/// When the next image is due.
pub(super) struct Schedule {
    next: Instant,
}

impl Schedule {
    pub fn new() -> Schedule {
        Schedule {
            next: Instant::now(),
        }
    }

    /// Calls `show` if it is time, or if this is the last image.
    pub fn show<E>(
        &mut self,
        is_last: bool,
        show: impl FnOnce() -> Result<(), E>,
    ) -> Result<(), E> {
        let start = Instant::now();
        if start < self.next && !is_last {
            return Ok(());
        }
        let shown = show();
        let took = start.elapsed();
        self.next = Instant::now() + INTERVAL.max(took.div_f64(SHARE));
        shown
    }
}
