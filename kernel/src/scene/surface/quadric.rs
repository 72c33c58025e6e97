//! Differential geometry of spheres, disks and cylinders under any affine map.
//!
//! A canonical surface p(u, v) with canonical normal N(u, v) goes to A p + c with normal n = A^-T N / |A^-T N|, so
//! dp/du = A dp/du and dn/du = (M - n (n . M)) / |A^-T N| with M = A^-T dN/du: the exact curvature of the ellipsoid or of
//! the elliptic cylinder, not only of round ones. Parameters are those of Mitsuba 3:
//! - sphere p = (sin t cos f, sin t sin f, cos t), f = 2 pi u, t = pi v, N = p;
//! - disk p = (u cos f, u sin f, 0), f = 2 pi v, N = (0, 0, 1);
//! - cylinder p = (cos f, sin f, v), f = 2 pi u, N = (cos f, sin f, 0).
//!
//! The shading frame's s follows dp/du, at the poles of a sphere its limit along the meridian u = 0.
//! Checked: every derivative against central differences in f64.

use super::normal::NormalMap;
use super::point::{SurfacePoint, detail};
use crate::math::affine::{
    transform_magnitude, transform_normal, transform_point, transform_vector, translation,
};
use crate::math::float::{atan2, sin_cos_2pi, sqrt};
use crate::math::{Frame, field};
use crate::scene::intersect::ROUNDING;
use crate::scene::records::{quadric_kind, shape_flag};
use crate::scene::view::Tables;
use core::f32::consts::{FRAC_1_PI, PI, TAU};
use glam::{Vec2, Vec3};

/// A point on a canonical quadric with the derivatives of its position and of its normal.
#[derive(Clone, Copy)]
struct Canonical {
    position: Vec3,
    uv: Vec2,
    normal: Vec3,
    dp_du: Vec3,
    dp_dv: Vec3,
    dn_du: Vec3,
    dn_dv: Vec3,
    /// Along dp/du, not zero where that is.
    tangent: Vec3,
}

/// The point at canonical parameters, in the space of the quadric's group.
#[inline]
pub fn quadric_point(tables: &Tables<'_>, quadric: u32, u: f32, v: f32) -> SurfacePoint {
    let kind = field(tables.quadrics, quadric, |q| q.kind);
    let canonical = if kind == quadric_kind::SPHERE {
        let (sin_phi, cos_phi) = sin_cos_2pi(u);
        let (sin_theta, cos_theta) = sin_cos_2pi(0.5 * v);
        sphere(cos_phi, sin_phi, sin_theta, cos_theta, Vec2::new(u, v))
    } else if kind == quadric_kind::DISK {
        let (sin_phi, cos_phi) = sin_cos_2pi(v);
        disk(cos_phi, sin_phi, Vec2::new(u, v))
    } else {
        let (sin_phi, cos_phi) = sin_cos_2pi(u);
        cylinder(cos_phi, sin_phi, Vec2::new(u, v))
    };
    to_group::<{ detail::CURVATURE }>(tables, quadric, canonical)
}

/// The point of the quadric next to `p`, which is given in the quadric's object space and lies near the surface.
#[inline]
pub fn quadric_point_at(tables: &Tables<'_>, quadric: u32, p: Vec3) -> SurfacePoint {
    quadric_point_with::<{ detail::CURVATURE }>(tables, quadric, p)
}

/// [`quadric_point_at`] with one of the degrees of [`detail`].
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn quadric_point_with<const DETAIL: u32>(
    tables: &Tables<'_>,
    quadric: u32,
    p: Vec3,
) -> SurfacePoint {
    let kind = field(tables.quadrics, quadric, |q| q.kind);
    if kind == quadric_kind::SPHERE {
        return sphere_point_with::<DETAIL>(tables, quadric, p);
    }
    let (rho, cos_phi, sin_phi) = polar(p);
    let azimuth = azimuth(cos_phi, sin_phi);
    let canonical = if kind == quadric_kind::DISK {
        disk(cos_phi, sin_phi, Vec2::new(rho.min(1.0), azimuth))
    } else {
        cylinder(cos_phi, sin_phi, Vec2::new(azimuth, p.z.max(0.0).min(1.0)))
    };
    to_group::<DETAIL>(tables, quadric, canonical)
}

/// [`quadric_point_with`] of a quadric that is a sphere.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sphere_point_with<const DETAIL: u32>(
    tables: &Tables<'_>,
    quadric: u32,
    p: Vec3,
) -> SurfacePoint {
    let (rho, cos_phi, sin_phi) = polar(p);
    let length = sqrt(rho * rho + p.z * p.z);
    let (sin_theta, cos_theta) = if length > 0.0 {
        (rho / length, p.z / length)
    } else {
        (0.0, 1.0)
    };
    let uv = Vec2::new(
        azimuth(cos_phi, sin_phi),
        atan2(sin_theta, cos_theta) * FRAC_1_PI,
    );
    let canonical = sphere(cos_phi, sin_phi, sin_theta, cos_theta, uv);
    to_group::<DETAIL>(tables, quadric, canonical)
}

/// Distance from the z axis, cosine and sine of the azimuth.
#[inline]
fn polar(p: Vec3) -> (f32, f32, f32) {
    let rho = sqrt(p.x * p.x + p.y * p.y);
    if rho > 0.0 {
        (rho, p.x / rho, p.y / rho)
    } else {
        (rho, 1.0, 0.0)
    }
}

/// The azimuth over 2 pi, in [0, 1].
#[inline]
fn azimuth(cos_phi: f32, sin_phi: f32) -> f32 {
    let a = atan2(sin_phi, cos_phi) * (0.5 * FRAC_1_PI);
    if a < 0.0 { a + 1.0 } else { a }
}

#[inline]
fn sphere(cos_phi: f32, sin_phi: f32, sin_theta: f32, cos_theta: f32, uv: Vec2) -> Canonical {
    let p = Vec3::new(sin_theta * cos_phi, sin_theta * sin_phi, cos_theta);
    let du = Vec3::new(-p.y, p.x, 0.0) * TAU;
    let dv = Vec3::new(cos_theta * cos_phi, cos_theta * sin_phi, -sin_theta) * PI;
    Canonical {
        position: p,
        uv,
        normal: p,
        dp_du: du,
        dp_dv: dv,
        dn_du: du,
        dn_dv: dv,
        tangent: Vec3::new(-sin_phi, cos_phi, 0.0),
    }
}

#[inline]
fn disk(cos_phi: f32, sin_phi: f32, uv: Vec2) -> Canonical {
    let radial = Vec3::new(cos_phi, sin_phi, 0.0);
    Canonical {
        position: radial * uv.x,
        uv,
        normal: Vec3::Z,
        dp_du: radial,
        dp_dv: Vec3::new(-sin_phi, cos_phi, 0.0) * (TAU * uv.x),
        dn_du: Vec3::ZERO,
        dn_dv: Vec3::ZERO,
        tangent: radial,
    }
}

#[inline]
fn cylinder(cos_phi: f32, sin_phi: f32, uv: Vec2) -> Canonical {
    let tangent = Vec3::new(-sin_phi, cos_phi, 0.0);
    Canonical {
        position: Vec3::new(cos_phi, sin_phi, uv.y),
        uv,
        normal: Vec3::new(cos_phi, sin_phi, 0.0),
        dp_du: tangent * TAU,
        dp_dv: Vec3::Z,
        dn_du: tangent * TAU,
        dn_dv: Vec3::ZERO,
        tangent,
    }
}

/// The canonical point under the quadric's affine map.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn to_group<const DETAIL: u32>(tables: &Tables<'_>, quadric: u32, c: Canonical) -> SurfacePoint {
    let shape = field(tables.quadrics, quadric, |q| q.shape);
    let (to_world, to_object) = (
        &field(tables.quadrics, quadric, |q| q.to_world),
        &field(tables.quadrics, quadric, |q| q.to_object),
    );
    let sign = if field(tables.shapes, shape, |s| s.flags) & shape_flag::FLIP_NORMALS != 0 {
        -1.0
    } else {
        1.0
    };
    let normal = NormalMap::new(transform_normal(to_object, c.normal) * sign, Vec3::Z);
    let position = transform_point(to_world, c.position);
    // Rounding of the position in the group's space, along the normal; and rounding in object space, of the map of a ray's
    // origin and of the solution itself (some units of the surface's size one), which is 1 / |A^-T N| as long outside.
    let outside = transform_magnitude(to_world, c.position) + translation(to_world).abs();
    let inside = transform_magnitude(to_object, position) + translation(to_object).abs();
    let position_error = 8.0
        * ROUNDING
        * (outside.dot(normal.n.abs())
            + (inside.dot(c.normal.abs()) + 2.0) * normal.inverse_length.abs());
    let mut frame = Frame {
        s: Vec3::ZERO,
        t: Vec3::ZERO,
        n: normal.n,
    };
    let (mut dp_du, mut dp_dv) = (Vec3::ZERO, Vec3::ZERO);
    let (mut dn_du, mut dn_dv) = (Vec3::ZERO, Vec3::ZERO);
    if DETAIL >= detail::TANGENTS {
        frame = Frame::from_normal_tangent(normal.n, transform_vector(to_world, c.tangent));
        dp_du = transform_vector(to_world, c.dp_du);
        dp_dv = transform_vector(to_world, c.dp_dv);
    }
    if DETAIL >= detail::CURVATURE {
        dn_du = normal.derivative(transform_normal(to_object, c.dn_du) * sign);
        dn_dv = normal.derivative(transform_normal(to_object, c.dn_dv) * sign);
    }
    SurfacePoint {
        position,
        position_error,
        geometric_normal: normal.n,
        frame,
        uv: c.uv,
        barycentric: Vec2::ZERO,
        dp_du,
        dp_dv,
        dn_du,
        dn_dv,
        shape,
        primitive: (tables.triangles.len() as u32).wrapping_add(quadric),
        instance: 0,
        material: field(tables.shapes, shape, |s| s.material),
        emitter: field(tables.shapes, shape, |s| s.emitter),
    }
}
