//! Mollified directions: the kernels of [`super::mollifier`] on a spherical cap.
//!
//! The thesis mollifies a specular direction by the constant cone `1 / (2 pi (1 - cos epsilon))` and recommends smooth
//! normalised kernels instead (Kaplanyan 2017, section 6.2.2). Lambert's equal-area map takes the cap of half angle
//! epsilon to the unit disk with radius `t = sqrt((1 - cos theta) / (1 - cos epsilon))`, hence
//!
//! `phi(w) = pi K(t) / (2 pi (1 - cos epsilon))`
//!
//! is of mass one exactly, for every disk kernel K and every epsilon; for the constant kernel it is the constant cone.
//! Caps are described by `one_minus_cos` = 1 - cos epsilon in (0, 2], which keeps its digits for narrow cones.
//! Densities per solid angle. Invariants (tests): mass one, samples follow the density (chi-square), the mean direction
//! is the axis.

use super::mollifier;
use crate::math::Frame;
use crate::math::float::{safe_sqrt, sqrt};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};

/// Largest cap: the whole sphere.
pub const WHOLE_SPHERE: f32 = 2.0;
/// Narrowest cap whose directions differ in `f32`.
pub const NARROWEST: f32 = 1e-12;

/// `1 - cos(atan(t))` = t^2 / (q (1 + q)) with q = sqrt(1 + t^2), without cancellation.
#[inline]
pub fn one_minus_cos_of_tangent(t: f32) -> f32 {
    // From here on q^2 would overflow, and the cap is a hemisphere.
    if !(t < 1e15) {
        return 1.0;
    }
    let q = sqrt(1.0 + t * t);
    t * t / (q * (1.0 + q))
}

/// The cap that a disk of radius `radius` fills at `distance` (algorithm 2 of the thesis: epsilon = atan(r / l)); a
/// hemisphere at distance zero.
#[inline]
pub fn one_minus_cos_of_radius(radius: f32, distance: f32) -> f32 {
    if !(distance > 0.0) {
        return 1.0;
    }
    one_minus_cos_of_tangent((radius / distance).min(1e15)).max(NARROWEST)
}

/// The cap on which the constant cone has the value `tau` (Jendersie and Grosch 2019, equation 15 inverted).
#[inline]
pub fn one_minus_cos_of_tau(tau: f32) -> f32 {
    if !(tau > 0.25 * FRAC_1_PI) {
        return WHOLE_SPHERE;
    }
    (0.5 * FRAC_1_PI / tau).max(NARROWEST).min(WHOLE_SPHERE)
}

/// Density of [`sample`] at the unit vector `w`.
#[inline]
pub fn eval(kind: u32, axis: Vec3, w: Vec3, one_minus_cos: f32) -> f32 {
    if !(one_minus_cos > 0.0) {
        return 0.0;
    }
    // 1 - cos theta from the chord: the dot product has no digits left for narrow cones.
    let inside = 0.5 * (w - axis).length_squared();
    if inside >= one_minus_cos {
        return 0.0;
    }
    0.5 * mollifier::eval(kind, 2, sqrt(inside / one_minus_cos)) / one_minus_cos
}

/// A direction of the cap around the unit vector `axis`.
#[inline]
pub fn sample(kind: u32, axis: Vec3, one_minus_cos: f32, u: Vec2) -> Vec3 {
    let p = mollifier::sample_2d(kind, u);
    let cap = one_minus_cos.max(0.0).min(WHOLE_SPHERE);
    let h = p.length_squared() * cap;
    // The disk point is at sqrt(h / cap), the direction's sine is sqrt(h (2 - h)).
    let scale = safe_sqrt(cap * (2.0 - h));
    let local = Vec3::new(p.x * scale, p.y * scale, 1.0 - h);
    Frame::from_normal(axis).to_world(local)
}
