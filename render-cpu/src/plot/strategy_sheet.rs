//! The pyramid of all strategies of bidirectional path tracing as one picture (Veach 1997, figure 10.2).
//!
//! Rows are paths of equal length, columns strategies with equally many light vertices; each image is labelled (s, t). A row
//! has one exposure, the power of two that brings the log-average luminance of the light in it nearest to 0.18, because long
//! paths carry less light; it is stated beside the row.

use super::canvas::{Canvas, DrawError, text_style};
use super::picture::Picture;
use crate::film::Film;
use crate::image::png_output::{Exposure, exposure_scale, tone_map};
use crate::render::StrategyPyramid;
use plotters::prelude::Text;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Width of a cell where images are larger, and at least.
const CELL: [u32; 2] = [200, 72];
/// Height of a label below a cell.
const LABEL: u32 = 18;
/// Space between cells.
const GAP: u32 = 6;
/// Width of the text beside the rows.
const MARGIN: u32 = 96;
/// Height of the title.
const TITLE: u32 = 34;

/// Draws the film of [`StrategyPyramid::film`] under a title.
///
/// # Errors
/// If the drawing library fails.
pub fn draw(pyramid: StrategyPyramid, film: &Film, title: &str) -> Result<Canvas, DrawError> {
    let (width, height) = (film.width(), film.height() / pyramid.count());
    let cell_width = width.clamp(CELL[1], CELL[0]);
    let cell_height = (f64::from(cell_width) * f64::from(height) / f64::from(width)).round();
    let cell_height = (cell_height as u32).max(1);
    let (step_x, step_y) = (cell_width + GAP, cell_height + LABEL + GAP);
    let mut canvas = Canvas::new(
        MARGIN + pyramid.columns(pyramid.length) * step_x + GAP,
        TITLE + pyramid.length * step_y + GAP,
    );
    let mean = film.mean();
    let image = |s: u32, t: u32| {
        let size = width as usize * height as usize;
        let index = pyramid.index(s, t).unwrap_or(0);
        &mean[index * size..(index + 1) * size]
    };
    let factors: Vec<f64> = (1..=pyramid.length)
        .map(|k| {
            let row = (0..pyramid.columns(k)).map(|s| image(s, k + 1 - s));
            row_factor(&row.collect::<Vec<_>>())
        })
        .collect();
    let corner = |k: u32, s: u32| (MARGIN + s * step_x, TITLE + (k - 1) * step_y);
    canvas.draw(|area| {
        area.draw(&Text::new(title, (GAP as i32, 9), text_style(15)))?;
        for (k, factor) in (1..=pyramid.length).zip(&factors) {
            let (_, y) = corner(k, 0);
            let middle = (y + cell_height / 2) as i32;
            let edges = if k == 1 { "edge" } else { "edges" };
            for (text, y) in [(format!("{k} {edges}"), -17), (format!("× {factor}"), 3)] {
                area.draw(&Text::new(text, (GAP as i32, middle + y), text_style(14)))?;
            }
            for s in 0..pyramid.columns(k) {
                let (x, y) = corner(k, s);
                let at = ((x + cell_width / 2) as i32, (y + cell_height + 3) as i32);
                let style = text_style(13).pos(Pos::new(HPos::Center, VPos::Top));
                area.draw(&Text::new(format!("({s}, {})", k + 1 - s), at, style))?;
            }
        }
        Ok(())
    })?;
    for (k, factor) in (1..=pyramid.length).zip(&factors) {
        for s in 0..pyramid.columns(k) {
            let exposure = Exposure::Stops(factor.log2() as f32);
            let rgb = tone_map(image(s, k + 1 - s), exposure);
            let cell = Picture::new(width, height, rgb).scaled(cell_width, cell_height);
            let (x, y) = corner(k, s);
            canvas.paste(cell.rgb(), cell.size(), x, y);
        }
    }
    Ok(canvas)
}

/// The power of two that shows a row, judged by the sum of its images; 1 where all are black.
fn row_factor(images: &[&[[f64; 3]]]) -> f64 {
    let size = images.first().map_or(0, |image| image.len());
    let sum: Vec<[f64; 3]> = (0..size)
        .map(|i| [0, 1, 2].map(|c| images.iter().map(|image| image[i][c]).sum()))
        .collect();
    exposure_scale(&sum, Exposure::Automatic)
        .log2()
        .round()
        .exp2()
}
