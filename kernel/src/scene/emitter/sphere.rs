//! Sampling the solid angle of a sphere: directions of the cone that the unit sphere subtends in object space, and their
//! density per world solid angle.
//!
//! From outside, the cone of half angle theta with sin(theta) = 1 / d, d the distance from the centre; from inside, all
//! directions. The affine map to the world changes solid angle by d(object) / d(world) = 1 / (|det A| |A^-1 w|^3) in the unit
//! world direction w, which makes the density exact for ellipsoids as well.
//!
//! Invariant (tests): the density integrates to one over the visible part of the sphere, and [`sphere_pdf`] of a sampled
//! point is its sampled density.

use crate::math::affine::{determinant, transform_point, transform_vector};
use crate::math::{Frame, float, warp};
use crate::scene::Quadric;
use glam::{Vec2, Vec3};

/// 1 - cos(theta) of the cone that the unit sphere subtends at a squared distance from its centre; 2, for all directions,
/// from inside.
#[inline]
fn sphere_cone(distance2: f32) -> f32 {
    if !(distance2 > 1.0) {
        return 2.0;
    }
    let sin2 = 1.0 / distance2;
    // cos = sqrt(1 - sin^2), written to keep its precision close to the sphere.
    let cos = float::sqrt((distance2 - 1.0) / distance2);
    sin2 / (1.0 + cos)
}

/// Density per world solid angle at `reference` of the direction to the point `position` of a sphere.
#[inline]
pub(super) fn sphere_pdf(quadric: &Quadric, reference: Vec3, position: Vec3) -> f32 {
    let origin = transform_point(&quadric.to_object, reference);
    let p = transform_point(&quadric.to_object, position);
    let distance2 = origin.length_squared();
    // From outside only the near side is sampled.
    if distance2 > 1.0 && !(p.dot(origin - p) > 0.0) {
        return 0.0;
    }
    let to_light = position - reference;
    let length = to_light.length();
    if !(length > 0.0) {
        return 0.0;
    }
    let d = transform_vector(&quadric.to_object, to_light / length);
    let pdf = warp::uniform_cone_pdf(sphere_cone(distance2))
        * object_per_world_solid_angle(&quadric.to_world, d.length());
    if float::is_finite(pdf) { pdf } else { 0.0 }
}

/// d(object solid angle) / d(world solid angle) in a unit world direction whose image in object space has the length
/// `image_length`.
#[inline]
fn object_per_world_solid_angle(to_world: &[f32; 12], image_length: f32) -> f32 {
    1.0 / (float::abs(determinant(to_world)) * image_length * image_length * image_length)
}

/// A sampled direction towards a sphere.
pub(super) struct SphereSample {
    /// Where it meets the unit sphere of object space.
    pub point: Vec3,
    /// Unit direction in world space.
    pub direction: Vec3,
    /// Distance to the sphere along it, in world space.
    pub distance: f32,
    /// Density per world solid angle; zero for no sample.
    pub pdf: f32,
}

impl SphereSample {
    const NONE: SphereSample = SphereSample {
        point: Vec3::Z,
        direction: Vec3::Z,
        distance: 0.0,
        pdf: 0.0,
    };
}

/// Samples a direction of the cone towards a sphere, uniform in object space.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(super) fn sample_cone(
    to_world: &[f32; 12],
    to_object: &[f32; 12],
    reference: Vec3,
    u: Vec2,
) -> SphereSample {
    let origin = transform_point(to_object, reference);
    let distance2 = origin.length_squared();
    let distance = float::sqrt(distance2);
    // Frame with z towards the centre: the reference point is (0, 0, -distance).
    let frame = if distance > 1e-12 {
        Frame::from_normal(origin * (-1.0 / distance))
    } else {
        Frame::LOCAL
    };
    let one_minus_cos = sphere_cone(distance2);
    let d = warp::square_to_uniform_cone(u, one_minus_cos);
    let sin2 = d.x * d.x + d.y * d.y;
    let half_chord = float::safe_sqrt(1.0 - distance2 * sin2);
    let is_outside = distance2 > 1.0;
    let t = if is_outside {
        distance * d.z - half_chord
    } else {
        distance * d.z + half_chord
    };
    let (x, y) = (t * d.x, t * d.y);
    let z = if is_outside {
        // t cos - distance, without the cancellation that it has far from the sphere.
        -float::safe_sqrt(1.0 - x * x - y * y)
    } else {
        t * d.z - distance
    };
    let world = transform_vector(to_world, frame.to_world(d));
    let length = world.length();
    if !(length > 0.0) || !(t > 0.0) {
        return SphereSample::NONE;
    }
    let pdf = warp::uniform_cone_pdf(one_minus_cos)
        * object_per_world_solid_angle(to_world, 1.0 / length);
    if !(pdf > 0.0) || !float::is_finite(pdf) {
        return SphereSample::NONE;
    }
    SphereSample {
        point: frame.to_world(Vec3::new(x, y, z)),
        direction: world / length,
        distance: length * t,
        pdf,
    }
}
