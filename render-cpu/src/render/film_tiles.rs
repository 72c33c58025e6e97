//! Tiles of the film and the samples of their pixels in one layer.

use super::bidirectional_job::TileSample;
use crate::film::Film;
use halflight_kernel::sampler::mix;
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;

/// Turns the seed of camera walks into that of light walks.
const LIGHT_STREAM: u32 = 0x3c6e_f35f;

/// A rectangle of pixels of the window: its first pixel and its size.
#[derive(Clone, Copy)]
pub(super) struct Tile {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

impl Tile {
    /// The numbers of its pixels in a film of a width, by rows.
    pub fn pixels(self, width: usize) -> impl Iterator<Item = usize> {
        (0..self.height * self.width).map(move |i| {
            let (x, y) = (self.x + i % self.width, self.y + i / self.width);
            y as usize * width + x as usize
        })
    }
}

/// The tiles of a film, by rows.
pub(super) fn tiles(film: &Film, size: u32) -> Vec<Tile> {
    let mut tiles = Vec::new();
    for y in (0..film.height()).step_by(size as usize) {
        for x in (0..film.width()).step_by(size as usize) {
            tiles.push(Tile {
                x,
                y,
                width: size.min(film.width() - x),
                height: size.min(film.height() - y),
            });
        }
    }
    tiles
}

/// Pixel in the whole film, and its number.
pub(super) fn pixel<T: Traverse>(view: &SceneView<'_, T>, x: u32, y: u32) -> ([u32; 2], u32) {
    let camera = &view.tables.camera;
    let pixel = [camera.crop_offset[0] + x, camera.crop_offset[1] + y];
    let index = pixel[1]
        .wrapping_mul(camera.film_size[0])
        .wrapping_add(pixel[0]);
    (pixel, index)
}

/// The samples of a tile in a layer.
pub(super) fn tile_samples<T: Traverse, S>(
    view: &SceneView<'_, T>,
    seed: u32,
    layer: u32,
    tile: Tile,
    new: &impl Fn(u32, u32, u32) -> S,
) -> Vec<TileSample<S>> {
    let light_seed = mix(seed ^ LIGHT_STREAM);
    let mut samples = Vec::with_capacity((tile.width * tile.height) as usize);
    for y in tile.y..tile.y + tile.height {
        for x in tile.x..tile.x + tile.width {
            let (pixel, index) = pixel(view, x, y);
            samples.push(TileSample {
                pixel,
                light: new(light_seed, index, layer),
                camera: new(seed, index, layer),
            });
        }
    }
    samples
}
