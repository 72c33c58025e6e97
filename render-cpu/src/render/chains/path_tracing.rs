//! Path tracing that accompanies chains: what it finds well is left to it ([`halflight_kernel::path::remainder`]).
//!
//! A group of chains comes with as many samples of path tracing per pixel as [`PATHS_PER_MUTATION`] says, in the same waves as those
//! of path tracing alone. How much they keep is chosen once, from candidates of their own, and is the same for all groups, so
//! that groups stay functions of seed and number.

use super::super::tile_job::SLOTS;
use crate::film::Film;
use crate::processor;
use glam::Vec3;
use halflight_kernel::path::PathRules;
use halflight_kernel::path::remainder::{LEAST_EDGES, MOST_EDGES, Remainder};
use halflight_kernel::sampler::IndependentSampler;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::scene::{SceneView, scene_flag};
use halflight_kernel::transport::markov::VeachChains;
use halflight_kernel::transport::markov::annealing::Annealing;
use halflight_kernel::transport::markov::veach::balance::balance;
use halflight_kernel::transport::settings::ChainSettings;
use halflight_kernel::transport::wavefront::Wavefront;
use halflight_kernel::transport::{IntegratorSettings, integrator_kind};
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

/// Samples of path tracing per mutation, of which one takes a tenth of the time; and fewer where chains find most of the light.
const PATHS_PER_MUTATION: u32 = 4;
const FEW_PATHS_PER_MUTATION: u32 = 1;
const MOST: f32 = 0.75;

/// Most candidates from which the remainder is chosen, and the group that they belong to, which is not one of the image's.
const MOST_CANDIDATES: u32 = 1 << 13;
const LEAST_CANDIDATES: u32 = 1 << 8;
const PILOT: u32 = u32::MAX;
const CHUNK: u32 = 256;

/// Tells the numbers of these paths from all others.
const STREAM: u32 = 0x7be5_19d3;

/// Rows of a task.
const BAND: usize = 8;

/// Path tracing for the chains of an image.
pub struct PathTracing {
    settings: IntegratorSettings,
    /// What it leaves to them.
    pub remainder: Remainder,
    samples: u32,
}

impl PathTracing {
    /// For chains of full paths that say nothing of direct illumination; none in scenes with masks, whose passage path tracing and
    /// chains sample differently.
    pub fn new<T: Traverse + Sync>(
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        seed: u32,
        pixels: u32,
    ) -> Option<PathTracing> {
        let chain_settings = &settings.chains;
        let has_masks = view.tables.info.flags & scene_flag::HAS_NULL != 0;
        if settings.kind != integrator_kind::VEACH_MLT
            || chain_settings.direct_samples != ChainSettings::SOME
            || has_masks
        {
            return None;
        }
        let chains = VeachChains::new(view, settings, LEAST_EDGES, seed, PILOT);
        let radius = view.tables.info.radius;
        let chains = chains.annealed(Annealing::of_group(&settings.regularization, radius, 0));
        let mutations = u64::from(chain_settings.mutations_per_pixel(pixels)) * u64::from(pixels);
        let candidates =
            (mutations / 64).clamp(LEAST_CANDIDATES.into(), MOST_CANDIDATES.into()) as u32;
        let chunks = candidates.div_ceil(CHUNK);
        let probes: Vec<_> = (0..chunks)
            .into_par_iter()
            .flat_map_iter(|chunk| {
                let mut probes = Vec::new();
                for candidate in chunk * CHUNK..(chunk + 1) * CHUNK {
                    chains.probe(candidate, |probe| probes.push(probe));
                }
                probes
            })
            .collect();
        let of_ratio = |paths: u32| balance(&probes, chunks * CHUNK, 1.0 / paths as f32);
        let (mut paths, mut found) = (PATHS_PER_MUTATION, of_ratio(PATHS_PER_MUTATION));
        if found.left > MOST {
            paths = FEW_PATHS_PER_MUTATION;
            found = of_ratio(paths);
        }
        tracing::debug!(
            "chains are left {:.1} % of the light, beside {paths} paths per mutation",
            100.0 * found.left
        );
        Some(PathTracing {
            settings: IntegratorSettings {
                kind: integrator_kind::PATH,
                rules: PathRules {
                    max_depth: settings.rules.max_depth.min(MOST_EDGES),
                    rr_depth: u32::MAX,
                    ..settings.rules
                },
                ..*settings
            },
            remainder: found.remainder,
            samples: chain_settings.mutations_per_pixel(pixels) * paths,
        })
    }

    /// What a group's samples of every pixel keep, in rows of pixels.
    pub fn render<T: Traverse + Sync>(
        &self,
        view: &SceneView<'_, T>,
        seed: u32,
        group: u32,
        film: &Film,
    ) -> Vec<Vec3> {
        let camera = &view.tables.camera;
        let width = film.width() as usize;
        let mut means = vec![Vec3::ZERO; width * film.height() as usize];
        let simd = processor::simd_level();
        means
            .par_chunks_mut(width * BAND)
            .enumerate()
            .for_each_init(
                || -> Box<Wavefront<IndependentSampler, SLOTS>> { bytemuck::zeroed_box() },
                |wave, (band, means)| {
                    wave.keep(self.remainder);
                    let first = band * width * BAND;
                    let count = means.len();
                    let mut runs: Vec<(usize, usize)> = Vec::new();
                    let mut finish = |wave: &mut Wavefront<_, SLOTS>, runs: &mut Vec<_>| {
                        let mut radiance = wave.run(simd, view, &self.settings);
                        for (at, count) in runs.drain(..) {
                            let (of_pixel, rest) = radiance.split_at(count);
                            radiance = rest;
                            means[at] += of_pixel.iter().sum::<Vec3>();
                        }
                    };
                    for at in 0..count {
                        let (x, y) = ((first + at) % width, (first + at) / width);
                        let pixel = [
                            camera.crop_offset[0] + x as u32,
                            camera.crop_offset[1] + y as u32,
                        ];
                        let index = pixel[1]
                            .wrapping_mul(camera.film_size[0])
                            .wrapping_add(pixel[0]);
                        let base = group.wrapping_mul(self.samples);
                        let mut done = 0;
                        while done < self.samples {
                            let sampler = |i: u32| {
                                let number = base.wrapping_add(done + i);
                                IndependentSampler::new(seed ^ STREAM, index, number)
                            };
                            let taken = wave.push_samples(pixel, self.samples - done, sampler);
                            runs.push((at, taken as usize));
                            done += taken;
                            if wave.is_full() {
                                finish(wave, &mut runs);
                            }
                        }
                    }
                    finish(wave, &mut runs);
                    means
                        .iter_mut()
                        .for_each(|mean| *mean /= self.samples as f32);
                },
            );
        means
    }
}
