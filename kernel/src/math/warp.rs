//! Maps from the unit square to the domains that light transport samples, each with its density.
//!
//! Domain: `u` in [0, 1)^2. Directions are unit vectors in the local frame, z up; densities are per solid angle in
//! steradian, or per area where the name says so. Every map is area preserving up to its density, so that a
//! well-distributed point set stays well distributed. Invariant (tests): each density integrates to one and is the
//! density of its map; each map stays inside its domain for the corners of the square.

use super::float;
use super::select::select;
use core::f32::consts::{FRAC_1_PI, FRAC_PI_4};
use glam::{Vec2, Vec3};

/// Uniform point of the unit disk by the concentric map (Shirley and Chiu 1997, "A Low Distortion Map Between Disk
/// and Square"). Density per area 1 / pi.
#[inline]
pub fn square_to_disk(u: Vec2) -> Vec2 {
    let x = 2.0 * u.x - 1.0;
    let y = 2.0 * u.y - 1.0;
    if x == 0.0 && y == 0.0 {
        return Vec2::ZERO;
    }
    // The radius runs along the longer axis, the angle is the ratio of the shorter to the longer times pi / 4.
    let is_wide = x * x > y * y;
    let (long, short) = (select(is_wide, x, y), select(is_wide, y, x));
    let (s, c) = float::sin_cos_octant(FRAC_PI_4 * (short / long));
    let (along, across) = (long * c, long * s);
    Vec2::new(
        select(is_wide, along, across),
        select(is_wide, across, along),
    )
}

/// Density per area of [`square_to_disk`].
pub const DISK_PDF_AREA: f32 = FRAC_1_PI;

/// Cosine-weighted direction of the upper hemisphere: the unit disk lifted to the sphere (Malley).
#[inline]
pub fn square_to_cosine_hemisphere(u: Vec2) -> Vec3 {
    let p = square_to_disk(u);
    // A point on the rim would have z = 0 and no density: the smallest z keeps weights finite.
    let z = float::safe_sqrt(1.0 - p.length_squared());
    Vec3::new(p.x, p.y, if z > 1e-6 { z } else { 1e-6 })
}

/// Density of [`square_to_cosine_hemisphere`]: cos theta / pi above the plane, zero below.
#[inline]
pub fn cosine_hemisphere_pdf(cos_theta: f32) -> f32 {
    if cos_theta > 0.0 {
        cos_theta * FRAC_1_PI
    } else {
        0.0
    }
}

/// Unit vector at height `z` in [-1, 1] with the azimuth `2 pi phi`.
#[inline]
fn at_height(z: f32, sin_theta: f32, phi: f32) -> Vec3 {
    let (s, c) = float::sin_cos_2pi(phi);
    Vec3::new(c * sin_theta, s * sin_theta, z)
}

/// Uniform direction of the sphere.
#[inline]
pub fn square_to_uniform_sphere(u: Vec2) -> Vec3 {
    let z = 1.0 - 2.0 * u.x;
    // 1 - z^2 in the form that does not cancel near the poles.
    at_height(z, 2.0 * float::safe_sqrt(u.x * (1.0 - u.x)), u.y)
}

/// Density of [`square_to_uniform_sphere`].
pub const UNIFORM_SPHERE_PDF: f32 = 0.25 * FRAC_1_PI;

/// Uniform direction of the upper hemisphere.
#[inline]
pub fn square_to_uniform_hemisphere(u: Vec2) -> Vec3 {
    let z = 1.0 - u.x;
    at_height(z, float::safe_sqrt(u.x * (2.0 - u.x)), u.y)
}

/// Density of [`square_to_uniform_hemisphere`] above the plane.
pub const UNIFORM_HEMISPHERE_PDF: f32 = 0.5 * FRAC_1_PI;

/// Uniform direction of the cone around +z whose half angle has the cosine `1 - one_minus_cos`.
///
/// The complement of the cosine is the parameter because it keeps its precision for narrow cones, where the cosine
/// rounds to one: `one_minus_cos = sin^2 / (1 + cos)`.
#[inline]
pub fn square_to_uniform_cone(u: Vec2, one_minus_cos: f32) -> Vec3 {
    let h = u.x * one_minus_cos;
    at_height(1.0 - h, float::safe_sqrt(h * (2.0 - h)), u.y)
}

/// Density of [`square_to_uniform_cone`] inside the cone; zero for an empty cone.
#[inline]
pub fn uniform_cone_pdf(one_minus_cos: f32) -> f32 {
    if one_minus_cos > 0.0 {
        0.5 * FRAC_1_PI / one_minus_cos
    } else {
        0.0
    }
}

/// Uniform barycentric weights of a triangle's second and third vertex, both >= 0 with a sum <= 1.
///
/// Continuous and of low distortion: the square is folded along its diagonal (Heitz 2019, "A Low-Distortion Map
/// Between Triangle and Square").
#[inline]
pub fn square_to_triangle(u: Vec2) -> Vec2 {
    let is_high = u.y > u.x;
    let b = 0.5 * select(is_high, u.x, u.y);
    let rest = select(is_high, u.y, u.x) - b;
    Vec2::new(select(is_high, b, rest), select(is_high, rest, b))
}
