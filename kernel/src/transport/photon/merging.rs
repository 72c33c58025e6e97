//! Vertex merging: photons within a radius, each weighted against all other strategies that can make its path.
//!
//! Georgiev et al. 2012, "Light Transport Simulation with Vertex Connection and Merging"; weights as in
//! [`crate::path::weight`], with what a pilot pass knows of densities ([`crate::path::photon_density`]). With connections it is their algorithm, without it is bidirectional photon mapping (Vorba 2011).
//! Radii shrink as in [`super::progressive`], and the estimate at a vertex is the same ([`super::estimate`]), so that merging
//! without weights is photon mapping. The photons are those of light walks of their own, any number of them, and not of the
//! walks that are connected: the weights know their number.
//! Invariants (tests): weights of all strategies of a path sum to one; with the radius at zero this is bidirectional path
//! tracing.

use super::cache::{Photon, PhotonCache};
use super::estimate::{KERNEL, for_photons_within, incidence};
use super::tracing::PhotonTracer;
use crate::bsdf::mode;
use crate::math::{Rgb, float, vec3};
use crate::path::weight::weight;
use crate::path::{Connector, Interaction, PhotonDensity, Walk};
use crate::regularize::mollifier;
use core::f32::consts::PI;
use glam::Vec3;

/// The photons of a pass, and how they are merged.
#[derive(Clone, Copy)]
pub struct PassPhotons<'a> {
    /// The photons.
    pub cache: PhotonCache<'a>,
    /// Radius within which they are merged.
    pub radius: f32,
    /// Light walks that left them.
    pub emitted: u32,
    /// What the weights know of how many are found.
    pub density: PhotonDensity<'a>,
}

/// eta of the weights, for a radius and a number of light walks.
#[inline]
pub fn merging_share(radius: f32, emitted: u32) -> f32 {
    PI * radius * radius * emitted as f32
}

/// What leaves photons to be merged, with the weights of `connector`.
pub fn merging_tracer<'a>(connector: &Connector<'a>) -> PhotonTracer<'a> {
    PhotonTracer {
        connector: *connector,
        least_roughness: 0.0,
        keeps_direct: true,
    }
}

/// The weight of merging a photon with a camera walk: `pdf` is the density per solid angle with which the camera walk would
/// go on to where the photon came from, `pdf_reverse` that of the photon to where the camera walk came from, at `position`.
#[inline]
pub fn merging_weight(
    connector: &Connector<'_>,
    photon: crate::path::PartialWeights,
    walk: &Walk,
    pdf: f32,
    pdf_reverse: f32,
    position: Vec3,
) -> f32 {
    if connector.strategies.unweighted {
        return 1.0;
    }
    let h = connector.heuristic_at(position);
    weight(
        photon.shorter_over_merged(h, pdf),
        walk.arrived.shorter_over_merged(h, pdf_reverse),
    )
}

/// Light of the photons around the vertex where a camera walk has arrived.
pub fn merge(
    connector: &Connector<'_>,
    photons: &PassPhotons<'_>,
    walk: &Walk,
    at: &Interaction<'_>,
) -> Rgb {
    let mut sum = Vec3::ZERO;
    for_merged(connector, photons, walk, at, |_, value| sum += value);
    walk.subpath.throughput * sum / photons.emitted.max(1) as f32
}

/// Passes on the photons that are merged with the vertex where a camera walk has arrived, each with its light there: not yet
/// times the walk's throughput, nor divided by the number of light walks.
#[inline]
pub fn for_merged(
    connector: &Connector<'_>,
    photons: &PassPhotons<'_>,
    walk: &Walk,
    at: &Interaction<'_>,
    mut add: impl FnMut(&Photon, Rgb),
) {
    let tables = connector.tables;
    let cache = &photons.cache;
    for_photons_within(
        cache,
        at.point.position,
        photons.radius,
        |index, distance2| {
            let photon = &cache.photons[index as usize];
            let edges = photon
                .depth
                .saturating_add(walk.subpath.depth)
                .saturating_add(1);
            if !connector.allows_edges(edges) {
                return;
            }
            let cosine = incidence(at, photon);
            if !(cosine > 0.0) {
                return;
            }
            let direction = -vec3(photon.direction);
            let seen = at.evaluate(tables, &connector.rules, mode::RADIANCE, direction);
            if !seen.is_some() {
                return;
            }
            let weights = photon.weights();
            let weight = merging_weight(
                connector,
                weights,
                walk,
                seen.pdf,
                seen.pdf_reverse,
                at.point.position,
            );
            let k = mollifier::eval_scaled(KERNEL, 2, float::sqrt(distance2), photons.radius);
            let value = vec3(photon.throughput) * seen.value * (k * weight / cosine);
            add(photon, value);
        },
    );
}
