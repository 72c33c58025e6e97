//! The driver of algorithms with light walks, photon mapping among them, for images whose paths are followed one by one: those that
//! path expressions divide, those whose light is edited, those that are regularised as each path needs it, and those that connect
//! to lights through interfaces. Layers of samples, as in `splatting`, each with an image for every part.
//!
//! Samples are taken one by one, because what is divided follows each of its walks. Samples and splats are added in the order
//! of rows and samples, so that the sums depend on the layer's index alone.

use super::backend::PassEnd;
use super::film_tiles::{Tile, pixel, tile_samples};
use super::first_radii::FirstRadii;
use super::followed_samples::{Followed, FollowedSamples, OwnRadii, RowSamples, sample_adaptive};
use super::layer_photons::{regularization, trace_photons};
use super::pass_context::PassContext;
use super::photon_cache::SortedPhotons;
use super::photon_pass::{PhotonTask, WorkspacePool};
use super::photon_statistics::{PixelStatistics, update};
use super::pilot::{PilotDensity, Pilots};
use super::splat::SplatFilter;
use super::surface_sample::surface_sample;
use crate::film::Film;
use crate::film::aov::Aov;
use glam::Vec3;
use halflight_kernel::path::PhotonDensity;
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::bidirectional::adaptive::{Adaptive, AdaptivePhotons};
use halflight_kernel::transport::bidirectional::{Bidirectional, DividedPhotons};
use halflight_kernel::transport::integrator_kind;
use halflight_kernel::transport::photon::adaptive::next_radii;
use halflight_kernel::transport::photon::merging::PassPhotons;
use halflight_kernel::transport::photon::progressive::{
    Progressive, light_walks, pass_radius, radius_after,
};
use halflight_kernel::transport::retargeted::photons::EditedPhotons;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// Rows whose samples one thread takes, and whose splats one thread adds, at a time.
const ROWS: u32 = 8;

/// Adds `layers` samples to every pixel of the film, or fewer when it is to stop; a layer that is not complete is dropped.
pub(super) fn render_divided_layers<T: Traverse + Sync, S: LaneSampler + Send>(
    pass: &PassContext<'_, T, S>,
    followed: Followed<'_>,
    film: &mut Film,
    layers: u32,
    pilots: &Pilots,
) -> PassEnd {
    let (view, settings) = (pass.view, pass.settings);
    let (width, height) = (film.width(), film.height());
    let filter = SplatFilter::new(&view.tables.camera);
    let merges = settings.kind == integrator_kind::VERTEX_MERGING;
    let density = PilotDensity::of_run(&pilots.density, pass);
    let radii = FirstRadii::of_run(&pilots.radii, pass, film);
    let (Some(density), Some(first_radii)) = (density, radii) else {
        return PassEnd::Cut;
    };
    let idle = WorkspacePool::new();
    for i in 0..layers {
        if i > 0 && pass.stop.is_set() {
            return PassEnd::Cut;
        }
        let first = pass.options.first_sample;
        let layer = first.wrapping_add(film.pixel(0, 0).count);
        let sorted = match photons_of_layer(pass, followed, layer, density, &idle) {
            Photons::Interrupted => return PassEnd::Cut,
            Photons::None => None,
            Photons::Sorted(sorted) => Some(sorted),
        };
        let emitted = light_walks(&view.tables, settings);
        let radius = pass_radius(&view.tables, settings, layer);
        let photons = sorted.as_ref().map(|sorted| DividedPhotons {
            photons: PassPhotons {
                cache: sorted.view(),
                radius,
                emitted,
                density,
            },
            states: sorted.states(),
        });
        let edited = photons
            .as_ref()
            .zip(sorted.as_ref())
            .map(|(photons, sorted)| EditedPhotons {
                photons: photons.photons,
                states: sorted.edit_states(),
            });
        let nodes = photons
            .as_ref()
            .zip(sorted.as_ref())
            .map(|(photons, sorted)| AdaptivePhotons {
                photons: photons.photons,
                nodes: sorted.nodes(),
            });
        let mut algorithm = Bidirectional::new(&view.tables, settings);
        if merges {
            algorithm = algorithm.merging(radius, emitted, density);
        }
        let adaptive = followed.is_adaptive.then(|| {
            let of_layer = regularization(view, settings, layer);
            Adaptive::new(&algorithm.regularized(of_layer))
        });
        let one_by_one = FollowedSamples {
            view,
            settings,
            algorithm: &algorithm,
            followed,
            photons,
            edited,
        };
        let keeps_regularized = film.aovs().contains(Aov::Regularization);
        let statistics = PixelStatistics::new(film);
        let is_own = settings.kind == integrator_kind::ADAPTIVE_PHOTONS;
        let found: Option<Vec<RowSamples>> = (0..height.div_ceil(ROWS))
            .into_par_iter()
            .map(|band| {
                if pass.stop.is_urgent() {
                    return None;
                }
                let tile = Tile {
                    x: 0,
                    y: band * ROWS,
                    width,
                    height: ROWS.min(height - band * ROWS),
                };
                let mut samples =
                    tile_samples(view, pass.options.seed, layer, tile, &pass.new_sampler);
                let radii = match first_radii {
                    Some(first) if is_own => {
                        let known = statistics.of_tile(tile).zip(first.of_tile(tile));
                        let next = |(s, first)| next_radii(&view.tables, settings, &s, first);
                        OwnRadii::Adaptive(known.map(next).collect())
                    }
                    Some(first) => {
                        let of_pass = |first| radius_after(first, settings, layer);
                        OwnRadii::Scheduled(first.of_tile(tile).map(of_pass).collect())
                    }
                    None => OwnRadii::Shared,
                };
                pass.stop.took(samples.len());
                if let Some(adaptive) = &adaptive {
                    let photons = nodes.as_ref();
                    let keeps = keeps_regularized;
                    return Some(sample_adaptive(
                        view,
                        adaptive,
                        photons,
                        keeps,
                        &mut samples,
                    ));
                }
                Some(one_by_one.sample_rows(&radii, &mut samples))
            })
            .collect();
        let Some(found) = found else {
            return PassEnd::Cut;
        };
        add_layer(pass, layer, film, &filter, &found);
        if let Some(first) = first_radii.filter(|_| is_own) {
            add_statistics(pass, film, first, &found);
        }
    }
    PassEnd::Complete
}

/// The photons of a layer.
enum Photons {
    /// The algorithm has none.
    None,
    /// It was to stop.
    Interrupted,
    /// With the states of their walks.
    Sorted(SortedPhotons),
}

/// Traces the photons of a layer, if the algorithm has any.
fn photons_of_layer<T: Traverse + Sync, S: LaneSampler + Send>(
    pass: &PassContext<'_, T, S>,
    followed: Followed<'_>,
    layer: u32,
    density: PhotonDensity<'_>,
    idle: &WorkspacePool,
) -> Photons {
    let (view, settings) = (pass.view, pass.settings);
    let expressions = followed.division.map(|division| division.expressions);
    let sorted = match settings.kind {
        integrator_kind::VERTEX_MERGING => trace_photons(
            pass,
            layer,
            density,
            expressions,
            followed.edits.copied(),
            idle,
        ),
        integrator_kind::PROGRESSIVE_PHOTONS | integrator_kind::ADAPTIVE_PHOTONS => {
            let task = PhotonTask {
                view,
                tracer: Progressive::new(&view.tables, settings).tracer(),
                expressions,
                edits: followed.edits.copied(),
                adaptive: None,
                emitted: light_walks(&view.tables, settings),
                seed: pass.options.seed,
                index: layer,
            };
            task.trace(idle, pass.stop, &pass.new_sampler)
        }
        _ => return Photons::None,
    };
    sorted.map_or(Photons::Interrupted, Photons::Sorted)
}

/// Adds what a layer has found to the statistics of adaptive photon mapping.
fn add_statistics<T: Traverse + Sync, S>(
    pass: &PassContext<'_, T, S>,
    film: &mut Film,
    first: &FirstRadii,
    found: &[RowSamples],
) {
    let (tables, settings) = (&pass.view.tables, pass.settings);
    let emitted = light_walks(tables, settings);
    let (width, mut top) = (film.width(), 0);
    for found in found {
        for (i, sums) in (0..).zip(&found.statistics) {
            let (x, y) = (i % width, top + i / width);
            if let Some(numbers) = film.pixel_mut(x, y).bandwidth_numbers() {
                let first = first.of_pixel(x, y);
                update(tables, settings, numbers, sums, emitted, first);
            }
        }
        top += ROWS;
    }
}

/// Adds a layer to the film.
fn add_layer<T: Traverse + Sync, S: LaneSampler>(
    pass: &PassContext<'_, T, S>,
    layer: u32,
    film: &mut Film,
    filter: &SplatFilter,
    found: &[RowSamples],
) {
    let needs_surface = film.aovs().needs_surface();
    let film_has_parts = !film.parts().is_empty();
    let bands = film.bands_mut(ROWS).into_par_iter().zip(found);
    bands.for_each(|(mut band, band_images)| {
        let (top, width) = (band.y(), band.width());
        let sums: Vec<Vec<[f32; 3]>> = band_images
            .radiance
            .iter()
            .enumerate()
            .map(|(image, radiance)| {
                let mut sums: Vec<[f32; 3]> = radiance.iter().map(|v| v.to_array()).collect();
                for splat in found.iter().flat_map(|rows| &rows.splats[image]) {
                    filter.add(splat, top, &mut sums);
                }
                sums
            })
            .collect();
        let mut parts = vec![Vec3::ZERO; sums.len() - 1];
        for i in 0..sums[0].len() {
            let (x, y) = (i as u32 % width, top + i as u32 / width);
            let whole = Vec3::from_array(sums[0][i]);
            for (part, sums) in parts.iter_mut().zip(&sums[1..]) {
                *part = Vec3::from_array(sums[i]);
            }
            let mut entry = band.pixel_mut(x, y);
            entry.add_sample(whole);
            if !film_has_parts && let [regularized] = parts[..] {
                entry.add_regularized(whole, [regularized.x, regularized.y]);
            } else {
                entry.add_parts(whole, &parts);
            }
            if needs_surface {
                let (pixel, index) = pixel(pass.view, x, y);
                let sampler = (pass.new_sampler)(pass.options.seed, index, layer);
                entry.add_aovs(&surface_sample(pass.view, sampler, pixel));
            }
        }
    });
}
