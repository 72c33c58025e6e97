//! GGX (Trowbridge-Reitz): `D(m) = 1 / (pi ax ay (x^2/ax^2 + y^2/ay^2 + z^2)^2)`.
//!
//! Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", equation 33, in the anisotropic form
//! of Heitz 2014. The callers in [`super`] clamp `alpha`, check sides, and stretch to unit roughness.

use crate::math::float::{safe_sqrt, sin_cos_2pi, sqr};
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

/// `D(m)` for `m.z > 0`.
#[inline]
pub fn distribution(alpha: Vec2, m: Vec3) -> f32 {
    let e = sqr(m.x / alpha.x) + sqr(m.y / alpha.y) + m.z * m.z;
    1.0 / (PI * alpha.x * alpha.y * e * e)
}

/// Projected area for a cosine and `spread = alpha sin(theta)`: `cos (1 + Lambda)` with Heitz 2014, equation 72,
/// `Lambda = (sqrt(1 + alpha^2 tan^2) - 1) / 2`, multiplied out.
#[inline]
pub fn projected_area(cos: f32, spread: f32) -> f32 {
    0.5 * (cos + safe_sqrt(cos * cos + spread * spread))
}

/// A normal of unit roughness, not normalised, visible from the unit vector `w`, `w.z >= 0`.
///
/// The visible half of the unit hemisphere is mirrored onto the spherical cap around `w`: a uniform point on the cap
/// `z >= -w.z`, plus `w` (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps").
#[inline]
pub fn sample_visible_normal(w: Vec3, u: Vec2) -> Vec3 {
    let (sin_phi, cos_phi) = sin_cos_2pi(u.x);
    let q = 1.0 - u.y;
    let span = 1.0 + w.z;
    // The cap's point has z = q span - w.z; 1 - z^2 is expanded, because z may be close to -1 and to 1.
    let sin_squared = u.y * (q * span * span + w.x * w.x + w.y * w.y);
    let r = safe_sqrt(sin_squared);
    Vec3::new(r * cos_phi + w.x, r * sin_phi + w.y, q * span)
}

/// A slope with density `1 / (pi (1 + s^2)^2)`.
#[inline]
pub fn sample_slope(u: Vec2) -> Vec2 {
    let (sin_phi, cos_phi) = sin_cos_2pi(u.x);
    // The cumulative distribution of s^2 is s^2 / (1 + s^2).
    let q = (1.0 - u.y).max(6e-8);
    let r = safe_sqrt(u.y / q);
    Vec2::new(r * cos_phi, r * sin_phi)
}
