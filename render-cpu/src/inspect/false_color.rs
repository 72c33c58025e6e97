//! Radiance or irradiance of an image in colours that tell its numbers.
//!
//! The colour map is that of error maps ([`crate::compare::heatmap`]): perceptually even, and readable in grey and with red-green
//! blindness.

use super::legend::{ColorScale, WIDTH};
use super::pixel_film::pixel_film;
use crate::accel::Accel;
use crate::film::{Film, FilmError, luminance};
use crate::plot::canvas::{Canvas, DrawError};
use crate::scene::build::Scene;
use glam::Vec3;
use halflight_kernel::scene::SceneView;
use halflight_kernel::transport::irradiance::irradiance;

/// The irradiance of what each pixel of a scene's image sees, of the paths of its expression if it has one.
///
/// # Errors
/// If the film does not fit into memory.
pub fn irradiance_film(scene: &Scene, samples: u32, seed: u32) -> Result<Film, FilmError> {
    let tables = scene.tables.view();
    let accel = Accel::build(tables, &scene.tables.groups);
    let traverse = accel.traverse(tables);
    let view = SceneView {
        tables,
        traverse: &traverse,
    };
    let expressions = scene.parts.view();
    pixel_film(&tables, samples, seed, |sampler, ray| {
        irradiance(&view, &scene.settings, expressions.as_ref(), sampler, ray)
    })
}

/// Draws the luminance of an image of a width, by rows, beside a legend.
///
/// # Errors
/// If the drawing library fails.
pub fn draw(
    mean: &[[f64; 3]],
    width: u32,
    scale: impl FnOnce(&[f64]) -> ColorScale,
    quantity: &str,
) -> Result<Canvas, DrawError> {
    let values: Vec<f64> = mean.iter().map(|p| luminance(*p)).collect();
    let scale = scale(&values);
    let height = mean.len() as u32 / width.max(1);
    // Small images in whole pixels, so that there is something to see.
    let zoom = (240 / width.max(1)).clamp(1, 16);
    let mut rgb = Vec::new();
    for y in 0..height * zoom {
        for x in 0..width * zoom {
            let value = values[((y / zoom) * width + x / zoom) as usize];
            rgb.extend(scale.color(value));
        }
    }
    let size = [width * zoom, height * zoom];
    let mut canvas = Canvas::new(size[0] + WIDTH, size[1].max(160));
    canvas.paste(&rgb, size, 0, 0);
    scale.draw(&mut canvas, size[0], quantity)?;
    Ok(canvas)
}

/// A colour as numbers.
pub(super) fn numbers(color: Vec3) -> [f64; 3] {
    color.to_array().map(f64::from)
}
