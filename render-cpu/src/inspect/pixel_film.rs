//! A film of samples of every pixel, each of something that a camera ray sees.

use crate::film::aov::AovSet;
use crate::film::{Film, FilmError};
use halflight_kernel::math::{Ray, Rgb};
use halflight_kernel::sampler::IndependentSampler;
use halflight_kernel::scene::Tables;
use halflight_kernel::transport::camera_ray;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Side of the squares of pixels that a thread takes at a time.
const TILE: u32 = 16;

/// Takes `samples` of every pixel of what `seen` finds along camera rays.
///
/// # Errors
/// If the film does not fit into memory.
pub(super) fn pixel_film(
    tables: &Tables<'_>,
    samples: u32,
    seed: u32,
    seen: impl Fn(&mut IndependentSampler, &Ray) -> Rgb + Sync,
) -> Result<Film, FilmError> {
    let camera = &tables.camera;
    let [width, height] = camera.crop_size;
    let mut film = Film::new(width, height, camera.crop_offset, AovSet::NONE)?;
    film.tiles_mut(TILE).into_par_iter().for_each(|mut tile| {
        for y in tile.y()..tile.y() + tile.height() {
            for x in tile.x()..tile.x() + tile.width() {
                let pixel = [camera.crop_offset[0] + x, camera.crop_offset[1] + y];
                let index = pixel[1] * camera.film_size[0] + pixel[0];
                for sample in 0..samples {
                    let mut sampler = IndependentSampler::new(seed, index, sample);
                    let sample = camera_ray(tables, &mut sampler, pixel);
                    let found = seen(&mut sampler, &sample.ray);
                    tile.pixel_mut(x, y).add_sample(found * sample.weight);
                }
            }
        }
    });
    Ok(film)
}
