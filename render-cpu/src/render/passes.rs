//! The driver of algorithms in passes over a cache: light walks of all threads, their photons sorted, then all pixels.
//!
//! A pass makes one sample of every pixel. It depends on the seed and its own index alone, so the film's statistics, its
//! checkpoints and shares of passes work as for other algorithms: a run may be cut anywhere, and the parts of different
//! passes are merged to the same mean. The memory is that of one pass's photons and does not grow with the image.

use super::backend::PassEnd;
use super::bidirectional_job::TileSamples;
use super::film_tiles::{pixel, tile_samples, tiles};
use super::first_radii::FirstRadii;
use super::pass_context::PassContext;
use super::photon_cache::{PhotonList, SortedPhotons};
use super::photon_job::Radii;
use super::photon_pass::{PhotonTask, WorkspacePool};
use super::photon_statistics::{PixelStatistics, update};
use super::surface_sample::surface_sample;
use crate::film::Film;
use halflight_kernel::path::PhotonDensity;
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::integrator_kind;
use halflight_kernel::transport::photon::adaptive::next_radii;
use halflight_kernel::transport::photon::merging::PassPhotons;
use halflight_kernel::transport::photon::metropolis::{ChainCounts, GatherPoints, VisiblePhotons};
use halflight_kernel::transport::photon::progressive::{
    Progressive, light_walks, pass_radius, radius_after,
};
use halflight_kernel::transport::photon::statistics::PhotonPass;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use std::sync::OnceLock;

/// Side of the square of pixels whose camera walks are traced together.
const TILE: u32 = 32;

/// Chains of photons of a pass.
const CHAINS: u32 = 64;

/// Adds `passes` samples to every pixel of the film, or fewer when it is to stop; a pass that is not complete is dropped.
pub fn render_passes<T: Traverse + Sync, S: LaneSampler + Send>(
    context: &PassContext<'_, T, S>,
    film: &mut Film,
    passes: u32,
    pilot: &OnceLock<FirstRadii>,
) -> PassEnd {
    let idle = WorkspacePool::new();
    let found = FirstRadii::of_run(pilot, context, film);
    let Some(first) = found else {
        return PassEnd::Cut;
    };
    for taken in 0..passes {
        if taken > 0 && context.stop.is_set() {
            return PassEnd::Cut;
        }
        let first_pass = context.options.first_sample;
        let pass = Pass {
            context,
            index: first_pass.wrapping_add(film.pixel(0, 0).count),
            first,
            idle: &idle,
        };
        if pass.render(film).is_none() {
            return PassEnd::Cut;
        }
    }
    PassEnd::Complete
}

/// A pass.
struct Pass<'a, T: Traverse, S> {
    context: &'a PassContext<'a, T, S>,
    index: u32,
    first: Option<&'a FirstRadii>,
    idle: &'a WorkspacePool,
}

impl<T: Traverse + Sync, S: LaneSampler + Send> Pass<'_, T, S> {
    /// Adds a sample to every pixel; nothing if it is to stop.
    fn render(&self, film: &mut Film) -> Option<()> {
        let context = self.context;
        let (view, settings, seed) = (context.view, context.settings, context.options.seed);
        let algorithm = Progressive::new(&view.tables, settings);
        let emitted = light_walks(&view.tables, settings);
        let radius = pass_radius(&view.tables, settings, self.index);
        let (sorted, emitted) = if settings.kind == integrator_kind::METROPOLIS_PHOTONS {
            self.trace_visible(film, &algorithm, emitted, radius)?
        } else {
            let photons = PhotonTask {
                view,
                tracer: algorithm.tracer(),
                expressions: None,
                edits: None,
                adaptive: None,
                emitted,
                seed,
                index: self.index,
            };
            (
                photons.trace(self.idle, context.stop, &context.new_sampler)?,
                emitted,
            )
        };
        let photons = PassPhotons {
            cache: sorted.view(),
            radius,
            emitted,
            density: PhotonDensity::unknown(&view.tables),
        };
        let is_adaptive = settings.kind == integrator_kind::ADAPTIVE_PHOTONS;
        let statistics = PixelStatistics::new(film);
        let taken: Option<Vec<(TileSamples, Vec<PhotonPass>)>> = tiles(film, TILE)
            .into_par_iter()
            .map(|tile| {
                if self.context.stop.is_urgent() {
                    return None;
                }
                let mut samples = tile_samples(view, seed, self.index, tile, &context.new_sampler);
                let radii = match self.first {
                    Some(first) if is_adaptive => {
                        let known = statistics.of_tile(tile).zip(first.of_tile(tile));
                        let next = |(s, first)| next_radii(&view.tables, settings, &s, first);
                        Radii::Adaptive(known.map(next).collect())
                    }
                    Some(first) => {
                        let of_pass = |first| radius_after(first, settings, self.index);
                        Radii::Own(first.of_tile(tile).map(of_pass).collect())
                    }
                    None => Radii::Shared,
                };
                let mut out = TileSamples::default();
                let sums = self.idle.with(|workspace| {
                    workspace.gather(
                        view,
                        settings,
                        &algorithm,
                        &photons,
                        radii,
                        &mut samples,
                        &mut out,
                    )
                });
                self.context.stop.took(samples.len());
                Some((out, sums))
            })
            .collect();
        let taken = taken?;
        let needs_surface = film.aovs().needs_surface();
        let tiles = film.tiles_mut(TILE).into_par_iter().zip(taken);
        tiles.for_each(|(mut tile, (samples, sums))| {
            for (i, radiance) in samples.radiance.iter().enumerate() {
                let (i, width) = (i as u32, tile.width());
                let (x, y) = (tile.x() + i % width, tile.y() + i / width);
                let mut entry = tile.pixel_mut(x, y);
                entry.add_sample(*radiance);
                if let (Some(first), Some(sums), Some(numbers)) =
                    (self.first, sums.get(i as usize), entry.bandwidth_numbers())
                {
                    let first = first.of_pixel(x, y);
                    let emitted = photons.emitted;
                    update(&view.tables, settings, numbers, sums, emitted, first);
                }
                if needs_surface {
                    let (position, index) = pixel(view, x, y);
                    let sampler = (context.new_sampler)(seed, index, self.index);
                    entry.add_aovs(&surface_sample(view, sampler, position));
                }
            }
        });
        Some(())
    }

    /// Photons where camera walks of the pass look, of `steps` steps of chains, and the number of light walks for which they stand.
    fn trace_visible(
        &self,
        film: &Film,
        algorithm: &Progressive<'_>,
        steps: u32,
        radius: f32,
    ) -> Option<(SortedPhotons, u32)> {
        let (view, seed) = (self.context.view, self.context.options.seed);
        let new = &self.context.new_sampler;
        let points: Option<Vec<PhotonList>> = tiles(film, TILE)
            .into_par_iter()
            .map(|tile| {
                if self.context.stop.is_urgent() {
                    return None;
                }
                let mut samples = tile_samples(view, seed, self.index, tile, new);
                Some(self.idle.with(|workspace| {
                    workspace.gather_points(view, self.context.settings, algorithm, &mut samples)
                }))
            })
            .collect();
        let points = SortedPhotons::new(&points?);
        let visible = VisiblePhotons {
            view,
            tracer: algorithm.tracer(),
            seen_by: GatherPoints {
                points: points.view(),
                radius,
            },
            seed,
            pass: self.index,
        };
        let found: Option<Vec<(PhotonList, ChainCounts)>> = (0..CHAINS)
            .into_par_iter()
            .map(|number| {
                if self.context.stop.is_urgent() {
                    return None;
                }
                let mut photons = PhotonList::default();
                let mut room = [PhotonList::default(), PhotonList::default()];
                let steps = steps.div_ceil(CHAINS);
                let counts = visible.run(number, steps, &mut room, &mut photons);
                Some((photons, counts))
            })
            .collect();
        let (lists, counts): (Vec<_>, Vec<_>) = found?.into_iter().unzip();
        let mut sum = ChainCounts::default();
        counts.iter().for_each(|counts| sum.merge(counts));
        tracing::debug!(
            "pass {}: {:.4} of the light walks are seen, {:.3} of the mutations taken",
            self.index,
            f64::from(sum.uniform_seen) / f64::from(sum.uniform.max(1)),
            f64::from(sum.accepted) / f64::from(sum.proposed.max(1)),
        );
        Some((SortedPhotons::new(&lists), sum.emitted().round() as u32))
    }
}
