//! Images to look at while they are rendered: in the viewer tev, or as a PNG that is rewritten.
//!
//! A preview that cannot be shown is said to be gone, once; the run goes on.

use super::preview_schedule::Schedule;
use super::preview_tev::TevPreview;
use crate::film::Film;
use crate::image::png_output::{Exposure, write_png};
use std::path::PathBuf;

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
