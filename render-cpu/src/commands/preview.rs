//! Images to look at while they are rendered: in the viewer tev, or as a PNG that is rewritten.
//!
//! A preview that cannot be shown is said to be gone, once; the run goes on.

use super::preview_tev::TevPreview;
use crate::film::Film;
use crate::image::png_output::{Exposure, write_png};
use std::path::PathBuf;
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

/// A PNG that is rewritten.
pub(super) struct LivePng {
    path: PathBuf,
    exposure: Exposure,
    schedule: Schedule,
}

/// What shows the image while it is rendered.
#[derive(Default)]
pub(super) struct Previews {
    pub tev: Option<TevPreview>,
    pub png: Option<LivePng>,
}

impl LivePng {
    /// At a path.
    pub fn new(path: PathBuf, exposure: Exposure) -> LivePng {
        LivePng {
            path,
            exposure,
            schedule: Schedule::new(),
        }
    }
}

impl Previews {
    /// Shows the film, not too often unless it is the last time.
    pub fn show(&mut self, film: &Film, is_last: bool) {
        if let Some(tev) = &mut self.tev
            && let Err(error) = tev.show(film, is_last)
        {
            tracing::warn!("tev is gone: {error}");
            self.tev = None;
        }
        // The last PNG is written along with the image.
        if let Some(live) = self.png.as_mut().filter(|_| !is_last) {
            let (path, exposure) = (&live.path, live.exposure);
            let shown = live.schedule.show(false, || {
                write_png(path, film.width(), film.height(), &film.mean(), exposure)
            });
            if let Err(error) = shown {
                tracing::warn!("there is no live image: {error}");
                self.png = None;
            }
        }
    }
}
