//! How often chains come to the parts of the image: the second stage of a two-stage start (Veach 1997, chapter 11; Mitsuba 0.6: `twoStage`).
//!
//! Chains that keep to the luminance of F are where the image is bright, and dark parts get a few visits. With a factor w of the
//! film position their density is that of I = w luminance(F) instead, and states still count F / I each, so the image stays what
//! it is. Here
//!
//! ```text
//! w = m / (l + m / 4),
//! ```
//!
//! l the luminance around the position that the first stage has found, m its mean: parts that are darker than a quarter of the mean
//! are visited less for it, all others as often as each other. The first stage is a number of candidates of no group, so that all groups of
//! a run have the same w; what single ones find is limited, because w is to follow what is seen and not what is seldom found.

use glam::Vec2;

/// Pixels along a side of a cell.
pub const CELL: u32 = 8;

/// Share of the mean below which darkness is not made up for.
const DARK: f32 = 0.25;

/// The factor w by cells of the window; one everywhere without any.
#[derive(Clone, Copy, Debug)]
pub struct Importance<'a> {
    cells: &'a [f32],
    columns: u32,
    /// The window's first pixel.
    offset: [u32; 2],
}

/// Columns and rows of cells for a window of so many pixels.
#[inline]
pub fn cells_of([width, height]: [u32; 2]) -> [u32; 2] {
    [width.div_ceil(CELL).max(1), height.div_ceil(CELL).max(1)]
}

impl<'a> Importance<'a> {
    /// The same everywhere.
    pub const EVEN: Importance<'static> = Importance {
        cells: &[],
        columns: 1,
        offset: [0, 0],
    };

    /// From the cells of [`weights`], of a window that begins at `offset`.
    pub fn new(cells: &'a [f32], size: [u32; 2], offset: [u32; 2]) -> Importance<'a> {
        Importance {
            cells,
            columns: cells_of(size)[0],
            offset,
        }
    }

    /// w at a film position.
    #[inline]
    pub fn at(&self, film: Vec2) -> f32 {
        if self.cells.is_empty() {
            return 1.0;
        }
        self.cells[cell(film, self.offset, self.columns, self.cells.len())]
    }
}

/// The cell of a film position, the nearest for those outside of the window.
#[inline]
pub fn cell(film: Vec2, offset: [u32; 2], columns: u32, count: usize) -> usize {
    let along = |at: f32, offset: u32, count: u32| {
        let cell = ((at - offset as f32) / CELL as f32) as u32;
        cell.min(count - 1)
    };
    let rows = count as u32 / columns;
    let x = along(film.x, offset[0], columns);
    let y = along(film.y, offset[1], rows);
    (y * columns + x) as usize
}

/// Turns the light of the first stage in each cell, any multiple of it, into w.
pub fn weights(light: &[f32], size: [u32; 2]) -> impl Iterator<Item = f32> {
    let [columns, rows] = cells_of(size).map(|n| n as usize);
    let mean = light.iter().sum::<f32>() / light.len() as f32;
    (0..light.len()).map(move |i| {
        let (x, y) = (i % columns, i / columns);
        let mut sum = 0.0;
        let mut count = 0.0;
        for v in y.saturating_sub(1)..(y + 2).min(rows) {
            for u in x.saturating_sub(1)..(x + 2).min(columns) {
                sum += light[v * columns + u];
                count += 1.0;
            }
        }
        let w = mean / (sum / count + DARK * mean);
        if w > 0.0 && w.is_finite() { w } else { 1.0 }
    })
}
