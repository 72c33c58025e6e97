//! The differential geometry of a point on a surface.
//!
//! The position is computed again from the surface's own parameters, never from the ray, so that its error is a few
//! roundings of the surface's coordinates (Pharr, Jakob, Humphreys 2023, section 6.8): `position_error` bounds how far it
//! lies off the true surface along the geometric normal, and [`SurfacePoint::spawn`] leaves by that bound. Instances map
//! positions and tangents by the map and normals by its inverse transpose, so a mirrored instance keeps its outside
//! outside; the orientation conventions are those of Mitsuba 3 (neither normal is turned towards the other).

use super::features;
use super::intersect::{ROUNDING, offset_by, segment};
use super::quadric::{quadric_point, quadric_point_with};
use super::records::{Instance, NONE};
use super::traverse::Hit;
use super::triangle::triangle_point_with;
use super::view::Tables;
use crate::math::affine::{
    transform_magnitude, transform_normal, transform_point, transform_vector, translation,
};
use crate::math::float::{is_finite, sqrt};
use crate::math::{Frame, Ray};
use glam::{Vec2, Vec3};

/// A point on a surface with its first-order surroundings, in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position.
    pub position: Vec3,
    /// Bound on the distance of `position` from the true surface and of intersections near it, along the geometric
    /// normal.
    pub position_error: f32,
    /// Unit geometric normal, on the side of the shape's outside (after FLIP_NORMALS).
    pub geometric_normal: Vec3,
    /// Shading frame: n is the unit shading normal, s along dp/du where that is not degenerate.
    pub frame: Frame,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Barycentric weights of the second and third vertex (triangles).
    pub barycentric: Vec2,
    /// Position derivative in u.
    pub dp_du: Vec3,
    /// Position derivative in v.
    pub dp_dv: Vec3,
    /// Shading normal derivative in u.
    pub dn_du: Vec3,
    /// Shading normal derivative in v.
    pub dn_dv: Vec3,
    /// Index into the shapes.
    pub shape: u32,
    /// Primitive, as in [`super::Hit`].
    pub primitive: u32,
    /// Instance, as in [`super::Hit`].
    pub instance: u32,
    /// Material of the shape.
    pub material: u32,
    /// Emitter of the shape, or [`super::NONE`].
    pub emitter: u32,
}

impl SurfacePoint {
    /// Nothing.
    pub const ZERO: SurfacePoint = SurfacePoint {
        position: Vec3::ZERO,
        position_error: 0.0,
        geometric_normal: Vec3::ZERO,
        frame: Frame {
            s: Vec3::ZERO,
            t: Vec3::ZERO,
            n: Vec3::ZERO,
        },
        uv: Vec2::ZERO,
        barycentric: Vec2::ZERO,
        dp_du: Vec3::ZERO,
        dp_dv: Vec3::ZERO,
        dn_du: Vec3::ZERO,
        dn_dv: Vec3::ZERO,
        shape: 0,
        primitive: 0,
        instance: 0,
        material: 0,
        emitter: NONE,
    };

    /// The position moved off the surface, to the side of `direction`, far enough that a ray from there does not meet
    /// the surface around the point again.
    #[inline]
    pub fn offset_position(&self, direction: Vec3) -> Vec3 {
        offset_by(
            self.position,
            self.geometric_normal,
            direction,
            self.position_error,
        )
    }

    /// The ray that leaves the surface in the unit `direction`.
    #[inline]
    pub fn spawn(&self, direction: Vec3) -> Ray {
        Ray::new(self.offset_position(direction), direction)
    }

    /// The segment to a point that is on no surface, for visibility.
    #[inline]
    pub fn segment_to(&self, target: Vec3) -> Ray {
        segment(self.offset_position(target - self.position), target)
    }

    /// The segment to a point on another surface, for visibility.
    #[inline]
    pub fn segment_to_surface(&self, other: &SurfacePoint) -> Ray {
        let d = other.position - self.position;
        segment(self.offset_position(d), other.offset_position(-d))
    }
}

/// How much of a [`SurfacePoint`] is computed; what is left out is zero.
pub mod detail {
    /// Position, its error, the normals and the texture coordinates: what light sampling reads.
    pub const NORMALS: u32 = 0;
    /// Also the tangents of frame and position: what scattering reads.
    pub const TANGENTS: u32 = 1;
    /// Also the derivatives of the normal.
    pub const CURVATURE: u32 = 2;
}

/// The surface at an intersection found along `ray`. Only for hits ([`Hit::is_hit`]).
#[inline]
pub fn surface_at(tables: &Tables<'_>, ray: &Ray, hit: &Hit) -> SurfacePoint {
    surface_with::<{ detail::CURVATURE }>(tables, ray, hit)
}

/// [`surface_at`] with one of the degrees of [`detail`].
#[inline]
pub fn surface_with<const DETAIL: u32>(tables: &Tables<'_>, ray: &Ray, hit: &Hit) -> SurfacePoint {
    let triangle_count = tables.triangles.len() as u32;
    let has_quadrics = tables.has(features::QUADRICS);
    if tables.has(features::TRIANGLES) && (!has_quadrics || hit.primitive < triangle_count) {
        let mut p = triangle_point_with::<DETAIL>(tables, hit.primitive, hit.b1, hit.b2);
        if tables.has(features::INSTANCES) && hit.instance != 0 {
            let instance = &tables.instances[hit.instance as usize];
            place(instance, &mut p, hit.instance);
        }
        return p;
    }
    let quadric = hit.primitive - triangle_count;
    let to_object = &tables.quadrics[quadric as usize].to_object;
    let (mut origin, mut direction) = (ray.origin, ray.direction);
    if tables.has(features::INSTANCES) && hit.instance != 0 {
        let to_group = &tables.instances[hit.instance as usize].to_object;
        origin = transform_point(to_group, origin);
        direction = transform_vector(to_group, direction);
    }
    origin = transform_point(to_object, origin);
    direction = transform_vector(to_object, direction);
    let mut p = quadric_point_with::<DETAIL>(tables, quadric, origin + direction * hit.t);
    if tables.has(features::INSTANCES) && hit.instance != 0 {
        let instance = &tables.instances[hit.instance as usize];
        place(instance, &mut p, hit.instance);
    }
    p
}

/// The surface at parameters of a primitive in the world: barycentric weights `a`, `b` of a triangle's second and third
/// vertex, or canonical parameters (u, v) in [0, 1]^2 of a quadric.
#[inline]
pub fn surface_at_primitive(tables: &Tables<'_>, primitive: u32, a: f32, b: f32) -> SurfacePoint {
    let triangle_count = tables.triangles.len() as u32;
    if primitive < triangle_count {
        triangle_point_with::<{ detail::CURVATURE }>(tables, primitive, a, b)
    } else {
        quadric_point(tables, primitive - triangle_count, a, b)
    }
}

/// Moves a point in its group's space to the world by its instance.
pub(super) fn place(record: &Instance, p: &mut SurfacePoint, instance: u32) {
    let (to_world, to_object) = (&record.to_world, &record.to_object);
    let (in_group, normal_in_group) = (p.position, p.geometric_normal);
    p.instance = instance;
    p.position = transform_point(to_world, in_group);
    let geometric = NormalMap::new(
        transform_normal(to_object, normal_in_group),
        normal_in_group,
    );
    p.geometric_normal = geometric.n;
    p.dp_du = transform_vector(to_world, p.dp_du);
    p.dp_dv = transform_vector(to_world, p.dp_dv);
    let n = transform_normal(to_object, p.frame.n);
    let normal = NormalMap::new(n, p.geometric_normal);
    p.dn_du = normal.derivative(transform_normal(to_object, p.dn_du));
    p.dn_dv = normal.derivative(transform_normal(to_object, p.dn_dv));
    let tangent = if p.dp_du.length_squared() > 0.0 {
        p.dp_du
    } else {
        transform_vector(to_world, p.frame.s)
    };
    p.frame = Frame::from_normal_tangent(normal.n, tangent);
    // The error in the group and that of mapping a ray's origin into it, as long as the map makes them along the normal,
    // and the rounding of the position here.
    let outside = transform_magnitude(to_world, in_group) + translation(to_world).abs();
    let inside = transform_magnitude(to_object, p.position) + translation(to_object).abs();
    let mapped = 8.0 * ROUNDING * inside.dot(normal_in_group.abs());
    p.position_error = (p.position_error + mapped) * geometric.inverse_length
        + 8.0 * ROUNDING * outside.dot(p.geometric_normal.abs());
}

/// Normalisation N -> n = N / |N| and what it does to derivatives.
#[derive(Clone, Copy)]
pub(super) struct NormalMap {
    /// The unit vector.
    pub n: Vec3,
    /// 1 / |N|, zero where the fallback was taken.
    pub inverse_length: f32,
}

impl NormalMap {
    /// Normalises `v`, or takes the unit `fallback` with zero derivatives when `v` is zero or not finite.
    #[inline]
    pub fn new(v: Vec3, fallback: Vec3) -> NormalMap {
        let l2 = v.length_squared();
        if l2 > 1e-30 && l2 < f32::MAX {
            let inverse_length = 1.0 / sqrt(l2);
            NormalMap {
                n: v * inverse_length,
                inverse_length,
            }
        } else {
            NormalMap {
                n: fallback,
                inverse_length: 0.0,
            }
        }
    }

    /// dn = (dN - n (n . dN)) / |N|.
    #[inline]
    pub fn derivative(&self, dv: Vec3) -> Vec3 {
        let d = (dv - self.n * self.n.dot(dv)) * self.inverse_length;
        if is_finite(d.x) && is_finite(d.y) && is_finite(d.z) {
            d
        } else {
            Vec3::ZERO
        }
    }
}

/// `v` normalised, or the unit `fallback` when `v` is zero or not finite.
#[inline]
pub(super) fn unit_or(v: Vec3, fallback: Vec3) -> Vec3 {
    NormalMap::new(v, fallback).n
}
