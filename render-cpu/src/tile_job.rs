//! The samples of one tile of the film, on one thread.
//!
//! Paths are traced in waves ([`Wave`]) of consecutive samples: those of one pixel, or of neighbouring pixels where each
//! gets but a few. Samples enter their pixel in the order of their indices whatever the wave, so that sums round alike.

use crate::aov::AovSample;
use crate::film::FilmTile;
use crate::render::RenderOptions;
use arrayvec::ArrayVec;
use halflight_kernel::math::Rgb;
use halflight_kernel::sampler::{IndependentSampler, Sampler, SobolSampler, sampler_kind};
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::wave::Wave;
use halflight_kernel::transport::{self, IntegratorSettings, aov, integrator_kind};

/// Paths side by side: enough to be worth it, few enough that their state stays in the first cache.
const WAVE: usize = 32;

/// What all tiles of a pass have in common.
pub struct TileJob<'a, T: Traverse> {
    /// The scene.
    pub view: &'a SceneView<'a, T>,
    /// The algorithm.
    pub settings: &'a IntegratorSettings,
    /// One of [`sampler_kind`].
    pub sampler_kind: u32,
    /// Seed and first sample.
    pub options: &'a RenderOptions,
    /// Whether layers of surface features are wanted.
    pub needs_surface: bool,
}

/// A sample that is under way.
struct Pending<S> {
    x: u32,
    y: u32,
    /// Its reconstruction weight.
    weight: f32,
    /// Its numbers from the first on.
    sampler: S,
}

impl<T: Traverse> TileJob<'_, T> {
    /// Adds the next samples of every pixel of the tile, as many as `count` says of its coordinates.
    pub fn sample_tile(&self, tile: &mut FilmTile<'_>, count: impl Fn(u32, u32) -> u32) {
        // Compiled once per sampler, so that numbers are drawn without a choice and a call each.
        if self.sampler_kind == sampler_kind::SOBOL {
            self.sample_tile_with(tile, count, SobolSampler::new);
        } else {
            self.sample_tile_with(tile, count, IndependentSampler::new);
        }
    }

    /// [`Self::sample_tile`] with a sampler of (seed, pixel, sample).
    fn sample_tile_with<S: Sampler + Copy>(
        &self,
        tile: &mut FilmTile<'_>,
        count: impl Fn(u32, u32) -> u32,
        new: impl Fn(u32, u32, u32) -> S,
    ) {
        let film_width = self.view.tables.camera.film_size[0];
        let mut wave = Wave::new();
        let mut pending = ArrayVec::<Pending<S>, WAVE>::new();
        for y in tile.y()..tile.y() + tile.height() {
            for x in tile.x()..tile.x() + tile.width() {
                let pixel = self.pixel(x, y);
                let index = pixel[1].wrapping_mul(film_width).wrapping_add(pixel[0]);
                let first = self
                    .options
                    .first_sample
                    .wrapping_add(tile.pixel_mut(x, y).statistics.count);
                for i in 0..count(x, y) {
                    let sampler = new(self.options.seed, index, first.wrapping_add(i));
                    let mut numbers = sampler;
                    if self.settings.kind != integrator_kind::PATH {
                        let radiance =
                            transport::sample_pixel(self.view, self.settings, &mut numbers, pixel);
                        self.add(tile, [x, y], radiance, sampler);
                        continue;
                    }
                    let sensor = transport::sensor_ray(&self.view.tables, &mut numbers, pixel);
                    wave.push(&sensor.ray, numbers);
                    pending.push(Pending {
                        x,
                        y,
                        weight: sensor.weight,
                        sampler,
                    });
                    if wave.is_full() {
                        self.finish(tile, &mut wave, &mut pending);
                    }
                }
            }
        }
        self.finish(tile, &mut wave, &mut pending);
    }

    /// Coordinates in the whole film of a pixel of the window.
    fn pixel(&self, x: u32, y: u32) -> [u32; 2] {
        let [left, top] = self.view.tables.camera.crop_offset;
        [left + x, top + y]
    }

    /// Traces the wave and adds its samples.
    fn finish<S: Sampler + Copy>(
        &self,
        tile: &mut FilmTile<'_>,
        wave: &mut Wave<S, WAVE>,
        pending: &mut ArrayVec<Pending<S>, WAVE>,
    ) {
        let radiance = wave.run(self.view, self.settings);
        for (sample, radiance) in pending.drain(..).zip(radiance) {
            let radiance = radiance * sample.weight;
            self.add(tile, [sample.x, sample.y], radiance, sample.sampler);
        }
    }

    /// Adds a sample to its pixel, with the surface that its first ray meets where that is wanted.
    #[inline]
    fn add<S: Sampler>(
        &self,
        tile: &mut FilmTile<'_>,
        [x, y]: [u32; 2],
        radiance: Rgb,
        mut sampler: S,
    ) {
        let mut film_pixel = tile.pixel_mut(x, y);
        film_pixel.add_sample(radiance);
        if self.needs_surface {
            let (features, _) = aov::sample_pixel(self.view, &mut sampler, self.pixel(x, y));
            film_pixel.add_aovs(&AovSample {
                albedo: features.albedo.to_array(),
                normal: features.normal.to_array(),
                depth: features.depth,
                position: features.position.to_array(),
                uv: features.uv.to_array(),
            });
        }
    }
}
