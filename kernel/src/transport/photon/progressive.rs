//! Progressive photon mapping in its probabilistic form (Knaus and Zwicker 2011), and stochastic progressive photon mapping
//! (Hachisuka and Jensen 2009), which is the same with a new camera walk per pass.
//!
//! A pass traces M light walks, keeps where they arrive, and estimates each pixel from the photons within r_i of where a
//! camera walk arrives,
//!
//! ```text
//! I_i = sum_p T f(wc, wl_p) |cos_s wl_p| / |cos_g wl_p| Phi_p K(|x_p - x| / r_i) / (M r_i^2),
//! r_i = r_1 i^((alpha - 1) / 2)   ([`super::schedule`])
//! ```
//!
//! with T the camera walk's throughput, Phi the photon's, and K the kernel of Epanechnikov ([`super::estimate`]), which
//! has the least error of all. The image is the mean over the passes. A pass depends on nothing but its index, so passes may be
//! taken in any order and by anyone.
//!
//! What makes a path is decided by its vertices, so that nothing counts twice:
//! - a camera walk goes on where all of the surface is discrete or less rough than a threshold; there, direct light and
//!   emission that is met are weighted against each other, as in path tracing;
//! - at the first rough vertex it gathers: photons that were scattered before give indirect light, next event estimation
//!   alone gives direct light, and the walk goes on with discrete lobes only;
//! - a glossy vertex where the walk goes on also gathers the photons that came through discrete events alone from an emitter
//!   that no ray meets: nothing else finds their paths.
//!
//! Invariants (tests): the mean goes to that of path tracing as the radius shrinks; merging alone of vertex connection and
//! merging agrees.

use super::cache::{Photon, PhotonCache};
use super::estimate::{KERNEL, for_photons_within, scattered};
use super::nearest::USUAL_NEAREST;
use super::schedule;
use super::tracing::{PhotonTracer, is_found_by_photons_alone};
use crate::math::{Rgb, float, vec3};
use crate::path::rules::step;
use crate::path::{
    Connector, Contributions, Heuristic, Interaction, PartialWeights, PhotonDensity, ShadingPoint,
    Strategies, Walk,
};
use crate::regularize::mollifier;
use crate::regularize::settings::Regularization;
use crate::sampler::Sampler;
use crate::scene::{Hit, NONE, Tables};
use crate::transport::settings::{IntegratorSettings, integrator_kind};
use glam::Vec3;

/// The first radius where none is given, in shares of the scene's radius, one per pixel of the film's longer side.
const PIXELS_OF_RADIUS: f32 = 5.0;

/// Light walks of a pass where none are given: Mitsuba 0.6's number.
const LIGHT_WALKS: u32 = 250_000;

/// Light walks of a pass: as many as the settings say, else Mitsuba 0.6's number, and for vertex merging one per pixel of the
/// crop window, because its camera walks, one per pixel too, find light by themselves.
pub fn light_walks(tables: &Tables<'_>, settings: &IntegratorSettings) -> u32 {
    let given = settings.photon.photon_count;
    if given > 0 {
        return given;
    }
    if settings.kind == integrator_kind::VERTEX_MERGING {
        let [width, height] = tables.camera.crop_size;
        return width.saturating_mul(height).max(1);
    }
    LIGHT_WALKS
}

/// The radius of the first pass: that of the settings, or as many pixels of the film as Mitsuba 0.6 takes, the scene's
/// radius spread over the film.
pub fn first_radius(tables: &Tables<'_>, settings: &IntegratorSettings) -> f32 {
    let given = settings.photon.initial_radius;
    if given > 0.0 {
        return given;
    }
    let [width, height] = tables.camera.film_size;
    PIXELS_OF_RADIUS * tables.info.radius / width.max(height).max(1) as f32
}

/// The radius of the pass with an index, counted from zero.
pub fn pass_radius(tables: &Tables<'_>, settings: &IntegratorSettings, pass: u32) -> f32 {
    radius_after(first_radius(tables, settings), settings, pass)
}

/// The radius of the pass with an index, counted from zero, where that of the first is `first`.
pub fn radius_after(first: f32, settings: &IntegratorSettings, pass: u32) -> f32 {
    schedule::radius(first, pass.saturating_add(1), settings.photon.alpha)
}

/// The photon of a pilot pass whose distance is the first radius of a pixel, or says how large that of adaptive photon mapping
/// may be; zero where one radius is for all pixels.
pub fn nearest_of_pixels(settings: &IntegratorSettings) -> u32 {
    let parameters = &settings.photon;
    match settings.kind {
        integrator_kind::ADAPTIVE_PHOTONS => USUAL_NEAREST,
        integrator_kind::PROGRESSIVE_PHOTONS if !(parameters.initial_radius > 0.0) => {
            parameters.nearest
        }
        _ => 0,
    }
}

/// The algorithm over a scene.
#[derive(Clone, Copy)]
pub struct Progressive<'a> {
    /// What paths have in common: emission that is met, and next event estimation.
    pub connector: Connector<'a>,
    /// Roughness from which surfaces gather.
    pub gather_roughness: f32,
}

impl<'a> Progressive<'a> {
    /// As the settings ask for.
    pub fn new(tables: &'a Tables<'a>, settings: &IntegratorSettings) -> Progressive<'a> {
        Progressive {
            connector: Connector {
                tables,
                rules: settings.rules,
                strategies: Strategies {
                    heuristic: Heuristic::BALANCE,
                    light_image: false,
                    sample_direct: true,
                    only_s: NONE,
                    only_t: NONE,
                    unweighted: false,
                    meets_lens: true,
                },
                photons: PhotonDensity::unknown(tables),
                regularization: Regularization::NONE,
            },
            gather_roughness: settings.photon.gather_roughness,
        }
    }

    /// What leaves the photons that [`Progressive::camera_bounce`] gathers.
    pub fn tracer(&self) -> PhotonTracer<'a> {
        PhotonTracer {
            connector: self.connector,
            least_roughness: self.gather_roughness,
            keeps_direct: false,
        }
    }

    /// One bounce of a camera walk among the photons of a pass of `emitted` light walks. `gather` sums those around a vertex, of
    /// those alone that nothing else finds where it is told so, as [`Progressive::gather`] does; `add` takes what may be shadowed;
    /// what the walk found itself, and what it gathered, is returned with what is next, [`step::TRACE`] or [`step::END`].
    pub fn camera_bounce<S: Sampler>(
        &self,
        walk: &mut Walk,
        sampler: &mut S,
        hit: &Hit,
        site: &mut ShadingPoint,
        emitted: u32,
        mut gather: impl FnMut(&Walk, &Interaction<'_>, bool) -> Rgb,
        mut add: impl Contributions,
    ) -> (Rgb, u32) {
        let connector = &self.connector;
        let (mut found, next) = connector.arrive(walk, hit, site);
        // No strategy has more than one vertex on the light's side.
        walk.arrived = PartialWeights::NONE;
        if next != step::SCATTER {
            return (found, next);
        }
        let (bsdf, at) = (&site.bsdf, site.interaction(walk.subpath.ray.direction));
        let is_rough = bsdf.has_smooth() && bsdf.roughness() >= self.gather_roughness;
        if bsdf.has_smooth() {
            let u_select = sampler.next_1d();
            let u = sampler.next_2d();
            let lit = if is_rough {
                // The walk does not go on to meet the emitter.
                let mut alone = *connector;
                alone.strategies.unweighted = true;
                alone.next_event(walk, &at, u_select, u)
            } else {
                connector.next_event(walk, &at, u_select, u)
            };
            if lit.is_some() {
                add.add_at(lit, &at);
            }
            let sum = gather(walk, &at, !is_rough);
            found += walk.subpath.throughput * sum / emitted.max(1) as f32;
        }
        if is_rough && !bsdf.has_delta() {
            return (found, step::END);
        }
        let depth = walk.subpath.depth;
        let h = connector.strategies.heuristic;
        let next = walk.scatter(connector.tables, &connector.rules, h, sampler, &at);
        let is_smooth = walk.subpath.depth > depth && walk.weights.d_vcm > 0.0;
        if is_rough && is_smooth {
            return (found, step::END);
        }
        (found, next)
    }

    /// Sum over the photons around a vertex: those alone that nothing else finds, if asked for.
    pub fn gather(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        cache: &PhotonCache<'_>,
        radius: f32,
        only_unfound: bool,
    ) -> Rgb {
        let mut sum = Vec3::ZERO;
        self.for_gathered(walk, at, cache, radius, only_unfound, |_, value| {
            sum += value;
        });
        sum
    }

    /// Passes on the photons that [`Progressive::gather`] sums, each with its light.
    #[inline]
    pub fn for_gathered(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        cache: &PhotonCache<'_>,
        radius: f32,
        only_unfound: bool,
        mut add: impl FnMut(&Photon, Rgb),
    ) {
        let connector = &self.connector;
        for_photons_within(cache, at.point.position, radius, |index, distance2| {
            let photon = &cache.photons[index as usize];
            let edges = photon
                .depth
                .saturating_add(walk.subpath.depth)
                .saturating_add(1);
            if !connector.allows_edges(edges) || only_unfound && !is_found_by_photons_alone(photon)
            {
                return;
            }
            let value = scattered(connector, at, photon);
            if value.max_element() > 0.0 {
                let distance = float::sqrt(distance2);
                let k = mollifier::eval_scaled(KERNEL, 2, distance, radius);
                add(photon, vec3(photon.throughput) * value * k);
            }
        });
    }
}
