//! The driver of algorithms with light walks, photon mapping among them, for images whose paths are followed one by one: those that
//! path expressions divide, those whose light is edited, those that are regularised as each path needs it, and those that connect
//! to lights through interfaces. Layers of samples, as in `splatting`, each with an image for every part.
//!
//! Samples are taken one by one, because what is divided follows each of its walks. Samples and splats are added in the order
//! of rows and samples, so that the sums depend on the layer's index alone.

use super::backend::PassEnd;
use super::bidirectional_job::{Vertices, regularized};
use super::division::Division;
use super::film_tiles::{Tile, pixel, tile_samples};
use super::first_radii::FirstRadii;
use super::layer_photons::{regularization, trace_photons};
use super::options::RenderOptions;
use super::photon_cache::SortedPhotons;
use super::photon_pass::{Idle, PhotonTask};
use super::pilot::{PilotDensity, Pilots};
use super::splat::{Splat, SplatFilter};
use super::stop::Stop;
use super::surface_sample::surface_sample;
use crate::film::Film;
use crate::film::aov::Aov;
use glam::Vec3;
use halflight_kernel::math::Rgb;
use halflight_kernel::path::retarget_states::Edits;
use halflight_kernel::path::{Contribution, PathStates, PhotonDensity, Shares};
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::camera::CameraSample;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::bidirectional::adaptive::{
    Adaptive, AdaptivePhotons, AdaptiveWorkspace,
};
use halflight_kernel::transport::bidirectional::manifold::sample_through_interfaces;
use halflight_kernel::transport::bidirectional::{
    Bidirectional, DividedPhotons, DividedSample, PathObserver, StateStore, Unshadowed, counted,
    sample_observed,
};
use halflight_kernel::transport::photon::divided::sample_among_photons;
use halflight_kernel::transport::photon::merging::PassPhotons;
use halflight_kernel::transport::photon::progressive::{
    Progressive, light_walks, pass_radius, radius_after,
};
use halflight_kernel::transport::retargeted::bidirectional::EditedPhotons;
use halflight_kernel::transport::{IntegratorSettings, camera_ray, integrator_kind, retargeted};
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

/// Rows whose samples one thread takes, and whose splats one thread adds, at a time.
const ROWS: u32 = 8;

/// What is made of the paths of an image, each followed by itself.
#[derive(Clone, Copy)]
pub(super) struct Followed<'a> {
    /// What divides it.
    pub division: Option<&'a Division<'a>>,
    /// The edits of its light transport.
    pub edits: Option<&'a Edits<'a>>,
    /// Whether its regularisation depends on whole paths.
    pub is_adaptive: bool,
}

/// The states along a light walk.
#[derive(Default)]
struct States(Vec<PathStates>);

impl StateStore for States {
    fn clear(&mut self) {
        self.0.clear();
    }

    fn push(&mut self, states: &PathStates) {
        self.0.push(*states);
    }

    fn get(&self, index: usize) -> PathStates {
        self.0.get(index).copied().unwrap_or(PathStates::DEAD)
    }
}

/// What some rows gave: for the image and for each part the radiance of their pixels, and splats.
struct Found {
    radiance: Vec<Vec<Rgb>>,
    splats: Vec<Vec<Splat>>,
}

/// Adds `layers` samples to every pixel of the film, or fewer when it is to stop; a layer that is not complete is dropped.
pub(super) fn render_divided_layers<T: Traverse + Sync, S: LaneSampler + Send>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    followed: Followed<'_>,
    options: &RenderOptions,
    film: &mut Film,
    layers: u32,
    new: impl Fn(u32, u32, u32) -> S + Sync,
    stop: &Stop<'_>,
    pilots: &Pilots,
) -> PassEnd {
    let (width, height) = (film.width(), film.height());
    let filter = SplatFilter::new(&view.tables.camera);
    let merges = settings.kind == integrator_kind::VERTEX_MERGING;
    let (seed, pilot) = (options.seed, &pilots.density);
    let density = PilotDensity::of_run(pilot, view, settings, seed, stop, &new);
    let radii = FirstRadii::of_run(&pilots.radii, view, settings, seed, film, stop, &new);
    let (Some(density), Some(first_radii)) = (density, radii) else {
        return PassEnd::Cut;
    };
    let idle = Idle::new();
    for i in 0..layers {
        if i > 0 && stop.is_set() {
            return PassEnd::Cut;
        }
        let first = options.first_sample;
        let layer = first.wrapping_add(film.pixel(0, 0).count);
        let sorted = match photons_of_layer(
            view, settings, followed, options, layer, density, &idle, stop, &new,
        ) {
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
            let own = regularization(view, settings, layer);
            Adaptive::new(&algorithm.regularized(own))
        });
        let keeps_regularized = film.aovs().contains(Aov::Regularization);
        let found: Option<Vec<Found>> = (0..height.div_ceil(ROWS))
            .into_par_iter()
            .map(|band| {
                if stop.is_urgent() {
                    return None;
                }
                let tile = Tile {
                    x: 0,
                    y: band * ROWS,
                    width,
                    height: ROWS.min(height - band * ROWS),
                };
                let mut samples = tile_samples(view, options.seed, layer, tile, &new);
                let radii: Option<Vec<f32>> = first_radii.map(|first| {
                    let of_pass = |first| radius_after(first, settings, layer);
                    first.of_tile(tile).map(of_pass).collect()
                });
                stop.took(samples.len());
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
                Some(sample_rows(
                    view,
                    settings,
                    &algorithm,
                    followed,
                    photons,
                    radii.as_deref(),
                    edited.as_ref(),
                    &mut samples,
                ))
            })
            .collect();
        let Some(found) = found else {
            return PassEnd::Cut;
        };
        add_layer(view, options.seed, layer, film, &filter, &found, &new);
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
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    followed: Followed<'_>,
    options: &RenderOptions,
    layer: u32,
    density: PhotonDensity<'_>,
    idle: &Idle,
    stop: &Stop<'_>,
    new: &(impl Fn(u32, u32, u32) -> S + Sync),
) -> Photons {
    let expressions = followed.division.map(|division| division.expressions);
    let sorted = match settings.kind {
        integrator_kind::VERTEX_MERGING => trace_photons(
            view,
            settings,
            options,
            layer,
            density,
            expressions,
            followed.edits.copied(),
            idle,
            stop,
            new,
        ),
        integrator_kind::PROGRESSIVE_PHOTONS => {
            let task = PhotonTask {
                view,
                tracer: Progressive::new(&view.tables, settings).tracer(),
                expressions,
                edits: None,
                adaptive: None,
                emitted: light_walks(&view.tables, settings),
                seed: options.seed,
                index: layer,
            };
            task.trace(idle, stop, new)
        }
        _ => return Photons::None,
    };
    sorted.map_or(Photons::Interrupted, Photons::Sorted)
}

/// Takes the samples of whole rows, with radii of their own if there are any.
fn sample_rows<T: Traverse, S: LaneSampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    algorithm: &Bidirectional<'_>,
    followed: Followed<'_>,
    photons: Option<DividedPhotons<'_>>,
    radii: Option<&[f32]>,
    edited: Option<&EditedPhotons<'_>>,
    samples: &mut [super::bidirectional_job::TileSample<S>],
) -> Found {
    let (first, count) = followed.division.map_or((0, 0), |d| (d.first, d.count));
    let images = 1 + count;
    let mut found = Found {
        radiance: vec![vec![Vec3::ZERO; samples.len()]; images],
        splats: vec![Vec::new(); images],
    };
    let mut vertices = Vertices::default();
    let mut states = States::default();
    let expressions = followed.division.map(|division| division.expressions);
    for (i, sample) in samples.iter_mut().enumerate() {
        let seen = camera_ray(&view.tables, &mut sample.camera, sample.pixel);
        vertices.clear();
        let mut add = |contribution: Contribution, shares: &Shares| {
            for image in 0..images {
                let value = match (image, &expressions) {
                    (_, None) => contribution.value,
                    (0, Some(expressions)) => counted(expressions, shares, contribution.value),
                    (part, _) => contribution.value * shares.of(first + part - 1),
                };
                if !(value.max_element() > 0.0) {
                    continue;
                }
                if contribution.is_splat() {
                    found.splats[image].push(Splat {
                        film: contribution.film,
                        value,
                    });
                } else {
                    found.radiance[image][i] += value * seen.weight;
                }
            }
        };
        if let (integrator_kind::PROGRESSIVE_PHOTONS, Some(photons), Some(expressions)) =
            (settings.kind, &photons, &expressions)
        {
            let algorithm = Progressive::new(&view.tables, settings);
            let mut photons = *photons;
            if let Some(radii) = radii {
                photons.photons.radius = radii[i];
            }
            sample_among_photons(
                view,
                &algorithm,
                expressions,
                &photons,
                &mut sample.camera,
                &seen,
                &mut states,
                add,
            );
            continue;
        }
        let connector = &algorithm.connector;
        match expressions {
            Some(expressions) => {
                let mut divided =
                    DividedSample::new(view, connector, expressions, photons, &mut states, add);
                follow(
                    view,
                    algorithm,
                    followed,
                    edited,
                    sample,
                    &seen,
                    &mut vertices,
                    &mut divided,
                );
            }
            None if settings.kind == integrator_kind::MANIFOLD_BIDIRECTIONAL => {
                let (light, camera) = (&mut sample.light, &mut sample.camera);
                let add = |contribution: Contribution| add(contribution, &Shares::NONE);
                sample_through_interfaces(
                    view,
                    algorithm,
                    light,
                    camera,
                    &seen,
                    &mut vertices,
                    add,
                );
            }
            None => {
                let add = |contribution: Contribution| add(contribution, &Shares::NONE);
                let mut unshadowed = Unshadowed::new(view, settings.rules, add);
                follow(
                    view,
                    algorithm,
                    followed,
                    edited,
                    sample,
                    &seen,
                    &mut vertices,
                    &mut unshadowed,
                );
            }
        }
    }
    found
}

/// Takes the samples of whole rows, regularised as each path needs it; what of them is regularised is a second image where that is
/// wanted.
fn sample_adaptive<T: Traverse, S: LaneSampler>(
    view: &SceneView<'_, T>,
    adaptive: &Adaptive<'_>,
    photons: Option<&AdaptivePhotons<'_>>,
    keeps_regularized: bool,
    samples: &mut [super::bidirectional_job::TileSample<S>],
) -> Found {
    let images = 1 + usize::from(keeps_regularized);
    let mut found = Found {
        radiance: vec![vec![Vec3::ZERO; samples.len()]; images],
        splats: vec![Vec::new(); images],
    };
    let mut room = Box::new(AdaptiveWorkspace::new());
    for (i, sample) in samples.iter_mut().enumerate() {
        let seen = camera_ray(&view.tables, &mut sample.camera, sample.pixel);
        let numbers = (&mut sample.light, &mut sample.camera);
        adaptive.sample(view, photons, numbers, &seen, &mut room, |contribution| {
            for image in 0..images {
                let value = if image == 0 {
                    contribution.value
                } else if contribution.blur > 0.0 {
                    regularized(contribution.value, contribution.blur)
                } else {
                    continue;
                };
                if !contribution.is_splat() {
                    found.radiance[image][i] += value * seen.weight;
                } else if value.x.max(value.y).max(value.z) > 0.0 {
                    found.splats[image].push(Splat {
                        film: contribution.film,
                        value,
                    });
                }
            }
        });
    }
    found
}

/// Takes one sample, with edits if there are any.
fn follow<T: Traverse, S: LaneSampler>(
    view: &SceneView<'_, T>,
    algorithm: &Bidirectional<'_>,
    followed: Followed<'_>,
    photons: Option<&EditedPhotons<'_>>,
    sample: &mut super::bidirectional_job::TileSample<S>,
    seen: &CameraSample,
    vertices: &mut Vertices,
    observer: &mut impl PathObserver,
) {
    let (light, camera) = (&mut sample.light, &mut sample.camera);
    match followed.edits {
        Some(edits) => retargeted::bidirectional::sample_observed(
            view, algorithm, edits, photons, light, camera, seen, vertices, observer,
        ),
        None => sample_observed(view, algorithm, light, camera, seen, vertices, observer),
    }
}

/// Adds a layer to the film.
fn add_layer<T: Traverse + Sync, S: LaneSampler>(
    view: &SceneView<'_, T>,
    seed: u32,
    layer: u32,
    film: &mut Film,
    filter: &SplatFilter,
    found: &[Found],
    new: &(impl Fn(u32, u32, u32) -> S + Sync),
) {
    let needs_surface = film.aovs().needs_surface();
    let film_has_parts = !film.parts().is_empty();
    let bands = film.bands_mut(ROWS).into_par_iter().zip(found);
    bands.for_each(|(mut band, own)| {
        let (top, width) = (band.y(), band.width());
        let sums: Vec<Vec<[f32; 3]>> = own
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
            if !film_has_parts && let [own] = parts[..] {
                entry.add_regularized(whole, [own.x, own.y]);
            } else {
                entry.add_parts(whole, &parts);
            }
            if needs_surface {
                let (pixel, index) = pixel(view, x, y);
                entry.add_aovs(&surface_sample(view, new(seed, index, layer), pixel));
            }
        }
    });
}
