//! The contact sheet: every material of the gallery on the material ball.

use super::examples::Example;
use super::preview::{AnyError, Preview};
use super::source::inline;
use crate::plot::canvas::{Canvas, text_style};
use plotters::prelude::Text;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Side of a picture of the contact sheet.
pub const PICTURE: u32 = 156;
/// Height of a label.
const LABEL: u32 = 26;
/// Space between pictures.
const GAP: u32 = 6;
/// Pictures in a row.
const COLUMNS: u32 = 7;

/// Draws the contact sheet with `spp` samples per pixel; `done` is called after every picture.
///
/// # Errors
/// When an example cannot be built, or the drawing library fails.
pub fn contact_sheet(
    examples: &[Example],
    spp: u32,
    mut done: impl FnMut(&str),
) -> Result<Canvas, AnyError> {
    let columns = COLUMNS.min(examples.len() as u32).max(1);
    let rows = (examples.len() as u32).div_ceil(columns);
    let (step_x, step_y) = (PICTURE + GAP, PICTURE + LABEL + GAP);
    let mut canvas = Canvas::new(columns * step_x + GAP, rows * step_y + GAP);
    let corner = |i: usize| {
        let i = i as u32;
        (GAP + i % columns * step_x, GAP + i / columns * step_y)
    };
    canvas.draw(|area| {
        for (i, example) in examples.iter().enumerate() {
            let (x, y) = corner(i);
            let style = text_style(12).pos(Pos::new(HPos::Center, VPos::Top));
            let at = ((x + PICTURE / 2) as i32, (y + PICTURE + 6) as i32);
            area.draw(&Text::new(example.name, at, style))?;
        }
        Ok(())
    })?;
    for (i, example) in examples.iter().enumerate() {
        let picture = Preview::new(&inline(example.name, example.bsdf), PICTURE)?.render(spp)?;
        let (x, y) = corner(i);
        canvas.paste(&picture, [PICTURE; 2], x, y);
        done(example.name);
    }
    Ok(canvas)
}
