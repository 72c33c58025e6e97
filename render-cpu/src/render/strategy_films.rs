//! The images of all strategies of bidirectional path tracing at once: one pass that sorts what each of them finds.
//!
//! A strategy takes s vertices of the light and t of the camera subpath and makes paths of k = s + t - 1 edges. The strategies
//! of all lengths up to a limit are the rows of a [`StrategyPyramid`] (Veach 1997, figure 10.2). Their images stand one below
//! the other on one [`Film`], so that the run loop, its goals and the film's variances serve all of them.
//! Invariants (tests): the images add up to that of the whole algorithm, and do not depend on threads.

use super::backend::{Backend, PassEnd, PassError};
use super::bidirectional_job::Vertices;
use super::film_tiles::{Tile, tile_samples};
use super::options::RenderOptions;
use super::splat::{Splat, SplatFilter};
use super::stop::Stop;
use crate::accel::Accel;
use crate::film::aov::AovSet;
use crate::film::{Film, FilmError};
use crate::scene::build::Scene;
use glam::Vec3;
use halflight_kernel::math::Rgb;
use halflight_kernel::sampler::{IndependentSampler, LaneSampler, SobolSampler, sampler_kind};
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::scene::{SceneView, camera_kind};
use halflight_kernel::transport::{bidirectional, camera_ray};
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// Rows of the image whose samples one thread takes at a time.
const ROWS: u32 = 8;

/// The strategies of all paths of 1 to `length` edges, by rows of equal length and columns of equal s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StrategyPyramid {
    /// Edges of the longest paths.
    pub length: u32,
    /// Whether light may meet the lens (t = 0).
    pub has_lens: bool,
}

impl StrategyPyramid {
    /// Of a scene's camera, up to `length` edges and the scene's own limit.
    pub fn new(scene: &Scene, length: u32) -> StrategyPyramid {
        StrategyPyramid {
            length: length.min(scene.settings.rules.max_depth),
            has_lens: scene.tables.camera.kind == camera_kind::THIN_LENS,
        }
    }

    /// Number of strategies that make paths of `k` edges: s = 0 ... k, and k + 1 where there is a lens.
    pub fn columns(&self, k: u32) -> u32 {
        k + 1 + u32::from(self.has_lens)
    }

    /// Number of strategies of all lengths.
    pub fn count(&self) -> u32 {
        (1..=self.length).map(|k| self.columns(k)).sum()
    }

    /// Index of a strategy among all, row by row.
    pub fn index(&self, s: u32, t: u32) -> Option<usize> {
        let k = (s + t).checked_sub(1)?;
        let is_there = (1..=self.length).contains(&k) && s < self.columns(k);
        is_there.then(|| ((1..k).map(|k| self.columns(k)).sum::<u32>() + s) as usize)
    }

    /// A black film of the images of all strategies, one below the other.
    ///
    /// # Errors
    /// If it does not fit into memory.
    pub fn film(&self, scene: &Scene) -> Result<Film, FilmError> {
        let [width, height] = scene.tables.camera.crop_size;
        let rows = u64::from(height) * u64::from(self.count());
        let rows = u32::try_from(rows).map_err(|_| FilmError::TooLarge(width, u32::MAX))?;
        Film::new(width, rows, [0; 2], AovSet::NONE)
    }
}

/// Samples of all strategies, taken by all threads of the processor.
pub struct StrategyBackend<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Its ray tracer.
    pub accel: &'a Accel,
    /// Seed and first sample.
    pub options: &'a RenderOptions,
    /// The strategies.
    pub pyramid: StrategyPyramid,
}

impl Backend for StrategyBackend<'_> {
    fn pass(
        &mut self,
        film: &mut Film,
        per_pixel: u32,
        counts: Option<&[u32]>,
        stop: &Stop<'_>,
    ) -> Result<PassEnd, PassError> {
        if counts.is_some() {
            return Err("samples of strategies go to all pixels alike".into());
        }
        let tables = self.scene.tables.view();
        let traverse = self.accel.traverse(tables);
        let view = SceneView {
            tables,
            traverse: &traverse,
        };
        for _ in 0..per_pixel {
            if stop.is_set() {
                return Ok(PassEnd::Cut);
            }
            if self.scene.sampler == sampler_kind::SOBOL {
                self.add_layer(&view, film, SobolSampler::new);
            } else {
                self.add_layer(&view, film, IndependentSampler::new);
            }
            stop.took(film.statistics().len());
        }
        Ok(PassEnd::Complete)
    }
}

/// What one strategy found in some rows.
#[derive(Clone, Default)]
struct StrategySamples {
    /// Index of the pixel in the image, and what its own sample found.
    of_pixel: Vec<(u32, Rgb)>,
    splats: Vec<Splat>,
}

impl StrategyBackend<'_> {
    /// Adds one sample to every pixel of every image.
    fn add_layer<T: Traverse + Sync, S: LaneSampler + Send>(
        &self,
        view: &SceneView<'_, T>,
        film: &mut Film,
        new: impl Fn(u32, u32, u32) -> S + Sync,
    ) {
        let camera = &view.tables.camera;
        let [width, height] = camera.crop_size;
        let first = self.options.first_sample;
        let layer = first.wrapping_add(film.pixel(0, 0).count);
        let results: Vec<Vec<StrategySamples>> = (0..height.div_ceil(ROWS))
            .into_par_iter()
            .map(|band| {
                let tile = Tile {
                    x: 0,
                    y: band * ROWS,
                    width,
                    height: ROWS.min(height - band * ROWS),
                };
                let samples = tile_samples(view, self.options.seed, layer, tile, &new);
                self.sample_rows(view, samples, tile.y * width)
            })
            .collect();
        let filter = SplatFilter::new(camera);
        let images = film.bands_mut(height);
        let indexed = images.into_par_iter().enumerate();
        indexed.for_each(|(strategy, mut image)| {
            let mut sums = vec![[0.0; 3]; width as usize * height as usize];
            // In the order of rows and samples, whatever thread took them.
            for found in results.iter().map(|of_rows| &of_rows[strategy]) {
                for (pixel, value) in &found.of_pixel {
                    let sum = &mut sums[*pixel as usize];
                    *sum = (Vec3::from_array(*sum) + *value).to_array();
                }
                for splat in &found.splats {
                    filter.add(splat, 0, &mut sums);
                }
            }
            let top = image.y();
            for (i, sum) in sums.iter().enumerate() {
                let (x, y) = (i as u32 % width, i as u32 / width);
                let mut pixel = image.pixel_mut(x, top + y);
                pixel.add_sample(Vec3::from_array(*sum));
            }
        });
    }

    /// Takes the samples of whole rows whose first pixel has the index `first`.
    fn sample_rows<T: Traverse, S: LaneSampler>(
        &self,
        view: &SceneView<'_, T>,
        samples: Vec<super::bidirectional_job::TileSample<S>>,
        first: u32,
    ) -> Vec<StrategySamples> {
        let mut settings = self.scene.settings;
        settings.rules.max_depth = self.pyramid.length;
        let mut found = vec![StrategySamples::default(); self.pyramid.count() as usize];
        let mut vertices = Vertices::default();
        for (pixel, mut sample) in (first..).zip(samples) {
            let seen = camera_ray(&view.tables, &mut sample.camera, sample.pixel);
            vertices.clear();
            bidirectional::sample(
                view,
                &settings,
                &mut sample.light,
                &mut sample.camera,
                &seen,
                &mut vertices,
                |contribution| {
                    let strategy = self.pyramid.index(contribution.s, contribution.t);
                    let Some(strategy) = strategy.filter(|_| contribution.is_some()) else {
                        return;
                    };
                    if contribution.is_splat() {
                        found[strategy].splats.push(Splat {
                            film: contribution.film,
                            value: contribution.value,
                        });
                    } else {
                        let value = contribution.value * seen.weight;
                        found[strategy].of_pixel.push((pixel, value));
                    }
                },
            );
        }
        found
    }
}
