//! When a pass is to end before it is complete.
//!
//! A pass may take minutes: one sample of every pixel of a large image. So those who take samples look here now and then, often
//! enough that a run ends well within two seconds of being asked to. They count what they have taken here as well, so that the
//! progress of a long pass can be seen.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// How long samples that would be lost if a pass ended may go on after the time is over.
const GRACE: Duration = Duration::from_secs(1);

/// A request to stop, and the time when a run is over.
#[derive(Clone, Copy, Debug)]
pub struct Stop<'a> {
    request: Option<&'a AtomicBool>,
    deadline: Option<Instant>,
    taken: Option<&'a AtomicU64>,
}

impl<'a> Stop<'a> {
    /// Never.
    pub const NEVER: Stop<'static> = Stop {
        request: None,
        deadline: None,
        taken: None,
    };

    /// When the request is made or the deadline is over.
    pub fn new(request: &'a AtomicBool, deadline: Option<Instant>) -> Stop<'a> {
        Stop {
            request: Some(request),
            deadline,
            taken: None,
        }
    }

    /// With a counter of the samples that the pass takes, for those who watch it.
    #[must_use]
    pub fn counting(self, taken: Option<&'a AtomicU64>) -> Stop<'a> {
        Stop { taken, ..self }
    }

    /// Counts samples of single pixels that a pass has taken.
    pub fn took(&self, samples: usize) {
        if let Some(taken) = self.taken {
            taken.fetch_add(samples as u64, Ordering::Relaxed);
        }
    }

    /// Whether to stop, for those who lose nothing by it: the samples that they have taken are in the film.
    pub fn is_set(&self) -> bool {
        self.is_requested() || self.deadline.is_some_and(|end| Instant::now() >= end)
    }

    /// Whether to stop, for those who lose what they have begun: at once when asked to, a second after the deadline.
    pub fn is_urgent(&self) -> bool {
        self.is_requested()
            || self
                .deadline
                .is_some_and(|end| Instant::now() >= end + GRACE)
    }

    fn is_requested(&self) -> bool {
        self.request.is_some_and(|r| r.load(Ordering::Relaxed))
    }
}
