//! The samples of one tile of the film, on one thread.
//!
//! Paths are traced in waves ([`Wave`]) of consecutive samples: those of one pixel, or of neighbouring pixels where each
//! gets but a few. Samples enter their pixel in the order of their indices whatever the wave, so that sums round alike.

use crate::aov::AovSample;
use crate::film::FilmTile;
use crate::render::RenderOptions;
use halflight_kernel::math::Rgb;
use halflight_kernel::math::vectors::Vectors;
use halflight_kernel::sampler::{LaneSampler, Sampler};
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::wave::Wave;
use halflight_kernel::transport::{self, IntegratorSettings, aov, integrator_kind};

/// Slots for paths side by side: enough for whole vectors of every class, few enough that their state stays in the second
/// cache. A row of them takes an odd number of cache lines, so that the same slot of many rows does not compete for the same
/// places of the first cache (a tenth of the time of cornell-box at 1024).
const SLOTS: usize = 97 * 16;

/// What all tiles of a pass have in common.
pub struct TileJob<'a, T: Traverse> {
    /// The scene.
    pub view: &'a SceneView<'a, T>,
    /// The algorithm.
    pub settings: &'a IntegratorSettings,
    /// Seed and first sample.
    pub options: &'a RenderOptions,
    /// Whether layers of surface features are wanted.
    pub needs_surface: bool,
    /// Those of the processor.
    pub vectors: Vectors,
}

/// A sample that is under way.
#[derive(Clone, Copy)]
struct Pending<S> {
    x: u32,
    y: u32,
    /// Its numbers from the first on.
    sampler: S,
}

/// What a thread needs for its tiles.
pub struct Workspace<S> {
    wave: Box<Wave<S, SLOTS>>,
    pending: Vec<Pending<S>>,
}

impl<S: LaneSampler> Workspace<S> {
    /// Room for a wave.
    pub fn new() -> Workspace<S> {
        Workspace {
            wave: bytemuck::zeroed_box(),
            pending: Vec::with_capacity(SLOTS),
        }
    }
}

impl<T: Traverse> TileJob<'_, T> {
    /// Adds the next samples of every pixel of the tile, as many as `count` says of its coordinates; `new` makes a sampler
    /// of (seed, pixel, sample).
    pub fn sample_tile<S: LaneSampler>(
        &self,
        workspace: &mut Workspace<S>,
        tile: &mut FilmTile<'_>,
        count: impl Fn(u32, u32) -> u32,
        new: impl Fn(u32, u32, u32) -> S,
    ) {
        let film_width = self.view.tables.camera.film_size[0];
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
                    if self.settings.kind != integrator_kind::PATH {
                        let mut numbers = sampler;
                        let radiance =
                            transport::sample_pixel(self.view, self.settings, &mut numbers, pixel);
                        self.add(tile, [x, y], radiance, sampler);
                        continue;
                    }
                    workspace.wave.push(pixel, sampler);
                    workspace.pending.push(Pending { x, y, sampler });
                    if workspace.wave.is_full() {
                        self.finish(tile, workspace);
                    }
                }
            }
        }
        self.finish(tile, workspace);
    }

    /// Coordinates in the whole film of a pixel of the window.
    fn pixel(&self, x: u32, y: u32) -> [u32; 2] {
        let [left, top] = self.view.tables.camera.crop_offset;
        [left + x, top + y]
    }

    /// Traces the wave and adds its samples.
    fn finish<S: LaneSampler>(&self, tile: &mut FilmTile<'_>, workspace: &mut Workspace<S>) {
        let radiance = workspace.wave.run(self.vectors, self.view, self.settings);
        for (sample, &radiance) in workspace.pending.drain(..).zip(radiance) {
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
