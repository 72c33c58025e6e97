//! The density estimate at a vertex: photons within a radius, and what the surface scatters of them.
//!
//! A photon of flux Phi at the distance d adds Phi f(wc, wl) |cos_s wl| / |cos_g wl| K(d / r) / r^2 to the radiance along wc,
//! K the kernel of Epanechnikov, which has the least error of all at the best radius. Cosines are those of the surface that
//! gathers. Photons are counted only where the geometric normals agree within [`LEAST_COSINE`]: others lie around a corner.

use super::cache::{Photon, PhotonCache, PhotonQuery};
use crate::math::{Rgb, float, vec3};
use crate::path::{Connector, Interaction};
use crate::regularize::mollifier;
use glam::Vec3;

/// The kernel of the density estimate.
pub const KERNEL: u32 = mollifier::PARABOLIC;

/// Least cosine between the normals of a photon and of the surface that gathers it.
pub const LEAST_COSINE: f32 = 0.7;

/// Least cosine of incidence: photons along the surface would be divided by nothing.
const LEAST_INCIDENCE: f32 = 1e-4;

/// Calls `visit` with the index and the squared distance of each photon closer than `radius`.
#[inline]
pub fn for_photons_within(
    cache: &PhotonCache<'_>,
    center: Vec3,
    radius: f32,
    mut visit: impl FnMut(u32, f32),
) {
    let mut query = PhotonQuery::new(cache, center, radius);
    let radius2 = radius * radius;
    while query.advance(cache) {
        for index in query.start..query.end {
            let distance2 = (cache.position(index) - center).length_squared();
            if distance2 < radius2 {
                visit(index, distance2);
            }
        }
    }
}

/// Cosine by which the flux of a photon becomes irradiance of the surface that gathers it, zero where it lies on another.
#[inline]
pub fn incidence(at: &Interaction<'_>, photon: &Photon) -> f32 {
    let normal = at.point.geometric_normal;
    let normals = float::abs(normal.dot(vec3(photon.normal)));
    let cosine = float::abs(normal.dot(vec3(photon.direction)));
    if normals < LEAST_COSINE || !(cosine > LEAST_INCIDENCE) {
        return 0.0;
    }
    cosine
}

/// What a surface scatters of a photon's flux per area: f |cos_s| / |cos_g|; zero where the photon lies on another surface.
#[inline]
pub fn scattered(connector: &Connector<'_>, at: &Interaction<'_>, photon: &Photon) -> Rgb {
    let cosine = incidence(at, photon);
    if !(cosine > 0.0) {
        return Vec3::ZERO;
    }
    let towards_light = -vec3(photon.direction);
    let wo = at.point.frame.to_local(towards_light);
    if !connector.rules.allows(at.point, towards_light, wo.z) {
        return Vec3::ZERO;
    }
    at.bsdf.eval_cosine(connector.tables.data, at.wi, wo) / cosine
}
