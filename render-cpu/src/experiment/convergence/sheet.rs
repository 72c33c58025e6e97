//! The contact sheet: all images side by side, and the same parts of each enlarged below.
//!
//! Unless they are given, the parts are those where the algorithms differ most: square windows of a sixth of the image, not
//! overlapping, by the spread between algorithms of the mean square root of the error per pixel, which a few bright pixels do
//! not dominate.

use super::Outcome;
use crate::plot::canvas::{Canvas, DrawError, text_style};
use crate::plot::picture::{Picture, Window};
use plotters::prelude::Text;

/// Parts that are enlarged, at most, unless they are given.
const INSETS: usize = 3;
/// Width of an image where it is larger, and at least.
const COLUMN: [u32; 2] = [420, 240];
/// Height of a label.
const LABEL: u32 = 44;
/// Space between pictures.
const GAP: u32 = 8;
/// Colours of the windows.
const COLOURS: [[u8; 3]; 3] = [[230, 60, 40], [40, 160, 60], [40, 110, 230]];

/// A column of the sheet.
#[derive(Clone, Debug)]
pub struct Column {
    /// Two lines above it.
    pub label: [String; 2],
    /// The whole image.
    pub picture: Picture,
}

/// Draws the sheet; all pictures have the same size.
///
/// # Errors
/// If the drawing library fails.
pub fn draw(columns: &[Column], insets: &[Window]) -> Result<Canvas, DrawError> {
    let Some([width, height]) = columns.first().map(|c| c.picture.size()) else {
        return Err("there is nothing to show".into());
    };
    let column = width.clamp(COLUMN[1], COLUMN[0]);
    let scale = f64::from(column) / f64::from(width);
    let row = ((f64::from(height) * scale).round() as u32).max(1);
    let parts = insets.len() as u32;
    let part_width = (column - GAP * parts.saturating_sub(1)) / parts.max(1);
    let part_height = |window: &Window| {
        let ratio = f64::from(window[3]) / f64::from(window[2]);
        ((f64::from(part_width) * ratio).round() as u32).max(1)
    };
    let bottom = insets.iter().map(part_height).max().unwrap_or(0);
    let mut canvas = Canvas::new(
        GAP + columns.len() as u32 * (column + GAP),
        LABEL + row + 2 * GAP + bottom,
    );
    let left = |i: usize| GAP + i as u32 * (column + GAP);
    canvas.draw(|area| {
        for (i, c) in columns.iter().enumerate() {
            for (line, (text, size)) in c.label.iter().zip([16, 13]).enumerate() {
                let at = (left(i) as i32, 6 + 20 * line as i32);
                area.draw(&Text::new(text.clone(), at, text_style(size)))?;
            }
        }
        Ok(())
    })?;
    for (i, c) in columns.iter().enumerate() {
        let mut whole = c.picture.scaled(column, row);
        for (window, colour) in insets.iter().zip(COLOURS.into_iter().cycle()) {
            let scaled = window.map(|v| (f64::from(v) * scale).round() as u32);
            whole.frame(scaled, 2, colour);
        }
        canvas.paste(whole.rgb(), whole.size(), left(i), LABEL);
        for (k, (window, colour)) in insets.iter().zip(COLOURS.into_iter().cycle()).enumerate() {
            let size = [part_width, part_height(window)];
            let mut part = c.picture.part(*window).scaled(size[0], size[1]);
            part.frame([0, 0, size[0], size[1]], 3, colour);
            let x = left(i) + k as u32 * (part_width + GAP);
            canvas.paste(part.rgb(), part.size(), x, LABEL + row + GAP);
        }
    }
    Ok(canvas)
}

/// The windows in which the algorithms differ most.
pub fn most_different_windows(outcomes: &[Outcome], [width, height]: [u32; 2]) -> Vec<Window> {
    let side = (width.min(height) / 6).max(8).min(width.min(height));
    let step = (side / 2).max(1) as usize;
    let error = |outcome: &Outcome, x: u32, y: u32| -> f64 {
        let rows = (y..y + side).map(|y| (y * width + x) as usize);
        rows.flat_map(|at| &outcome.error_map[at..at + side as usize])
            .map(|e| e.sqrt())
            .sum()
    };
    let mut rated: Vec<(f64, Window)> = Vec::new();
    for y in (0..=height - side).step_by(step) {
        for x in (0..=width - side).step_by(step) {
            let errors: Vec<f64> = outcomes.iter().map(|o| error(o, x, y)).collect();
            let most = errors.iter().copied().fold(0.0, f64::max);
            let least = errors.iter().copied().fold(f64::MAX, f64::min);
            // A single algorithm differs from the truth alone.
            let spread = if errors.len() > 1 { most - least } else { most };
            rated.push((spread, [x, y, side, side]));
        }
    }
    rated.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<Window> = Vec::new();
    for (_, [x, y, ..]) in rated {
        let overlaps = |w: &Window| x.abs_diff(w[0]) < side && y.abs_diff(w[1]) < side;
        if chosen.len() < INSETS && !chosen.iter().any(overlaps) {
            chosen.push([x, y, side, side]);
        }
    }
    chosen
}
