//! Adaptive progressive photon mapping: a radius for each pixel, from the statistics of its photons.
//!
//! Kaplanyan and Dachsbacher 2013 (Kaplanyan 2017, section 5.4, algorithm 1). Paths are those of [`super::progressive`]; what
//! differs is the estimate at a vertex: Perlin's kernel, whose second differences exist, and the radius of the pixel, which
//! balances the error of bias and variance ([`super::statistics`]). psi is the luminance of what a photon adds to the pixel,
//! kernel aside.
//!
//! Of the readings of equation 5.18 for the radius of the Laplacian, the literal one takes the deviation of a Laplacian for a
//! length; what measured best is [`PhotonStatistics::curvature_bandwidth`], with the Laplacian's own noise taken out of its
//! square (relative squared error after 64 passes of 65536 photons on a torus in glass under a point light: 0.107 literally,
//! 0.032 without the noise, 0.022 to 0.024 with the normal fit; 0.030 for radii by schedule from five pixels on).
//! A pass depends on all passes before it, so passes cannot be shared among runs.

use super::cache::{Photon, PhotonCache};
use super::estimate::{for_photons_within, scattered};
use super::nearest::USUAL_NEAREST;
use super::progressive::light_walks;
use super::statistics::{PhotonPass, PhotonStatistics, Variance};
use super::tracing::is_found_by_photons_alone;
use crate::math::{Rgb, float, luminance, vec3};
use crate::path::{Connector, Interaction, Walk};
use crate::scene::Tables;
use crate::transport::settings::IntegratorSettings;
use glam::{Vec2, Vec3};

/// Radii of a pixel in a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AdaptiveRadii {
    /// r_N, of the estimate.
    pub radius: f32,
    /// r'_N, of the Laplacian.
    pub derivative: f32,
}

/// Most photons of a pass that a pixel gathers on average: what they cost stays below what tracing them does.
const MOST_GATHERED: f32 = 128.0;

/// The radii of the next pass, from the statistics of all before it, each of `emitted` light walks. Both start with the largest
/// that is allowed: by the settings, and by `nearest_distance`, within which
/// [`USUAL_NEAREST`] photons of a pass lie.
pub fn next_radii(
    tables: &Tables<'_>,
    settings: &IntegratorSettings,
    statistics: &PhotonStatistics,
    nearest_distance: f32,
) -> AdaptiveRadii {
    let cap = nearest_distance * float::sqrt(MOST_GATHERED / USUAL_NEAREST as f32);
    let radii = unbounded_radii(tables, settings, statistics);
    // The Laplacian reaches twice as far as its radius.
    AdaptiveRadii {
        radius: radii.radius.min(cap),
        derivative: radii.derivative.min(0.5 * cap),
    }
}

/// [`next_radii`] without regard to how many photons there are.
fn unbounded_radii(
    tables: &Tables<'_>,
    settings: &IntegratorSettings,
    statistics: &PhotonStatistics,
) -> AdaptiveRadii {
    let scene = tables.info.radius;
    let parameters = &settings.photon;
    let largest = parameters.largest_radius * scene;
    let least = (parameters.least_radius * scene).min(largest);
    if !(statistics.passes > 0.0) {
        return AdaptiveRadii {
            radius: largest,
            derivative: largest,
        };
    }
    let emitted = light_walks(tables, settings) as f32;
    AdaptiveRadii {
        radius: statistics.bandwidth(Variance::KERNEL, emitted, least, largest),
        derivative: statistics.curvature_bandwidth(least, largest),
    }
}

/// Sum over the photons around a vertex, and their share of the pixel's statistics in `sums`; of those alone that nothing else
/// finds, if asked for.
pub fn gather(
    connector: &Connector<'_>,
    walk: &Walk,
    at: &Interaction<'_>,
    cache: &PhotonCache<'_>,
    radii: AdaptiveRadii,
    only_unfound: bool,
    sums: &mut PhotonPass,
) -> Rgb {
    let mut sum = Vec3::ZERO;
    for_gathered(
        connector,
        walk,
        at,
        cache,
        radii,
        only_unfound,
        sums,
        |_, value| sum += value,
    );
    sum
}

/// Passes on the photons that [`gather`] sums, each with its light.
#[inline]
pub fn for_gathered(
    connector: &Connector<'_>,
    walk: &Walk,
    at: &Interaction<'_>,
    cache: &PhotonCache<'_>,
    radii: AdaptiveRadii,
    only_unfound: bool,
    sums: &mut PhotonPass,
    mut add: impl FnMut(&Photon, Rgb),
) {
    let reach = radii.radius.max(2.0 * radii.derivative);
    let frame = at.point.frame;
    let center = at.point.position;
    for_photons_within(cache, center, reach, |index, distance2| {
        let photon = &cache.photons[index as usize];
        let edges = photon
            .depth
            .saturating_add(walk.subpath.depth)
            .saturating_add(1);
        if !connector.allows_edges(edges) || only_unfound && !is_found_by_photons_alone(photon) {
            return;
        }
        let value = vec3(photon.throughput) * scattered(connector, at, photon);
        if !(value.max_element() > 0.0) {
            return;
        }
        let between = cache.position(index) - center;
        // As far as in space, in the direction on the surface.
        let along = Vec2::new(between.dot(frame.s), between.dot(frame.t));
        let length = float::sqrt(along.length_squared());
        let distance = float::sqrt(distance2);
        let offset = if length > 0.0 {
            along * (distance / length)
        } else {
            Vec2::new(distance, 0.0)
        };
        let psi = luminance(walk.subpath.throughput * value);
        let kernel = sums.add(offset, psi, radii.radius, radii.derivative);
        if kernel > 0.0 {
            add(photon, value * kernel);
        }
    });
}
