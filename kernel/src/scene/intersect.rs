//! Rays against single primitives, and rays that leave surfaces.
//!
//! **Triangles**: Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection". Vertices are translated to the
//! ray's origin and sheared until the ray is an axis; the signs of three 2D edge functions decide. A shared edge gives
//! both its triangles the same two products, and rounding is monotonic, so the sign is right or the value is zero. A zero
//! is computed again from differences of the vertices (where Woop et al. go to double precision), with opposite results
//! for the two triangles; what is still zero counts as inside on both sides. Hence no ray passes between two triangles that
//! share their vertices' positions, and no small triangle is hit from afar. Both sides of a triangle are hit. The distance
//! comes from the triangle's plane, t = n.(p0 - o) / n.d, clamped to the range of the vertices along the ray: on
//! axis-parallel planes it is exact however far the triangle reaches. (A compiler that fuses the products of an edge
//! function into one rounding takes the guarantee away, not the accuracy.)
//!
//! **Quadrics**: in object space, where the surface is canonical and t keeps its world meaning. The sphere follows
//! Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection" (Ray Tracing Gems, chapter 7): the
//! discriminant is 1 - |f - (f.d/d.d) d|^2, which does not cancel for far origins, and roots are c/q and q/a, which do
//! not cancel for near ones.
//!
//! **Leaving a surface**: [`offset_origin`] for a bare position; a [`super::SurfacePoint`] has a bound of its own error and
//! spawns rays with a smaller offset.

use super::records::quadric_kind;
use crate::math::float::{abs, safe_sqrt, sqrt};
use crate::math::{Ray, select};
use glam::Vec3;

/// A ray prepared for triangles.
#[derive(Clone, Copy, Debug)]
pub struct ShearedRay {
    /// The ray's origin.
    pub origin: Vec3,
    /// The ray's direction.
    pub direction: Vec3,
    /// Axis along which the direction is longest; `x` of the sheared space is the next axis, `y` the one after.
    pub axis: u32,
    /// Shear of x and y per unit of z, and the scale 1/d_z of z.
    pub shear: Vec3,
}

/// Components in the cyclic order that puts `axis` last.
#[inline]
fn permute(v: Vec3, axis: u32) -> Vec3 {
    let (is_x, is_y) = (axis == 0, axis == 1);
    Vec3::new(
        select(is_x, v.y, select(is_y, v.z, v.x)),
        select(is_x, v.z, select(is_y, v.x, v.y)),
        select(is_x, v.x, select(is_y, v.y, v.z)),
    )
}

impl ShearedRay {
    /// Prepares a ray; its direction is not zero.
    #[inline]
    pub fn new(origin: Vec3, direction: Vec3) -> ShearedRay {
        let a = direction.abs();
        let is_x = (a.x >= a.y) & (a.x >= a.z);
        let axis = select(is_x, 0, select(a.y >= a.z, 1, 2));
        let d = permute(direction, axis);
        ShearedRay {
            origin,
            direction,
            axis,
            shear: Vec3::new(d.x / d.z, d.y / d.z, 1.0 / d.z),
        }
    }
}

/// The intersection of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleHit {
    /// Ray parameter; [`f32::MAX`] for a miss.
    pub t: f32,
    /// Barycentric weight of the second vertex.
    pub b1: f32,
    /// Barycentric weight of the third vertex.
    pub b2: f32,
}

impl TriangleHit {
    /// No intersection.
    pub const MISS: TriangleHit = TriangleHit {
        t: f32::MAX,
        b1: 0.0,
        b2: 0.0,
    };
}

/// The intersection with `t_min < t < t_max`. Degenerate triangles and NaN vertices are missed.
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn intersect_triangle(
    ray: &ShearedRay,
    p0: Vec3,
    p1: Vec3,
    p2: Vec3,
    t_min: f32,
    t_max: f32,
) -> TriangleHit {
    let a = permute(p0 - ray.origin, ray.axis);
    let b = permute(p1 - ray.origin, ray.axis);
    let c = permute(p2 - ray.origin, ray.axis);
    let (ax, ay) = (a.x - ray.shear.x * a.z, a.y - ray.shear.y * a.z);
    let (bx, by) = (b.x - ray.shear.x * b.z, b.y - ray.shear.y * b.z);
    let (cx, cy) = (c.x - ray.shear.x * c.z, c.y - ray.shear.y * c.z);
    let mut u = cx * by - cy * bx;
    let mut v = ax * cy - ay * cx;
    let mut w = bx * ay - by * ax;
    if u == 0.0 || v == 0.0 || w == 0.0 {
        u = nonzero_edge(u, cx, cy, bx, by);
        v = nonzero_edge(v, ax, ay, cx, cy);
        w = nonzero_edge(w, bx, by, ax, ay);
    }
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return TriangleHit::MISS;
    }
    // A NaN passes the signs and ends here, and so do degenerate triangles.
    let determinant = u + v + w;
    let is_solid = abs(determinant) > 0.0 && abs(determinant) < f32::MAX;
    if !is_solid {
        return TriangleHit::MISS;
    }
    let z = Vec3::new(a.z, b.z, c.z) * ray.shear.z;
    let t = plane_distance(ray.origin, ray.direction, p0, p1, p2, z);
    if t > t_min && t < t_max {
        let scale = 1.0 / determinant;
        TriangleHit {
            t,
            b1: v * scale,
            b2: w * scale,
        }
    } else {
        TriangleHit::MISS
    }
}

/// An edge function; where rounding makes it zero, c x b = (c + b) x (b - c) / 2 instead, which preserves the difference of
/// nearby vertices. The other triangle at the edge exchanges b and c, which negates every term exactly.
#[inline]
fn nonzero_edge(edge: f32, cx: f32, cy: f32, bx: f32, by: f32) -> f32 {
    if edge == 0.0 {
        0.5 * ((cx + bx) * (by - cy) - (cy + by) * (bx - cx))
    } else {
        edge
    }
}

/// The ray parameter at which a ray that passes through the triangle intersects its plane; `z` are the parameters of the
/// vertices along the ray's main axis, between which it must lie (slivers have no accurate plane).
#[inline]
pub fn plane_distance(origin: Vec3, direction: Vec3, p0: Vec3, p1: Vec3, p2: Vec3, z: Vec3) -> f32 {
    let n = (p1 - p0).cross(p2 - p0);
    let t = n.dot(p0 - origin) / n.dot(direction);
    // A NaN from 0/0 is replaced by the bounds as well.
    t.max(z.x.min(z.y).min(z.z)).min(z.x.max(z.y).max(z.z))
}

/// The nearest ray parameter in `(t_min, t_max)` on a canonical quadric, [`f32::MAX`] for a miss. The origin and the
/// direction are in object space, the direction of any length but zero.
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn intersect_quadric(kind: u32, origin: Vec3, direction: Vec3, t_min: f32, t_max: f32) -> f32 {
    if kind == quadric_kind::SPHERE {
        intersect_sphere(origin, direction, t_min, t_max)
    } else if kind == quadric_kind::DISK {
        intersect_disk(origin, direction, t_min, t_max)
    } else {
        intersect_cylinder(origin, direction, t_min, t_max)
    }
}

/// Unit sphere at the origin.
#[inline]
fn intersect_sphere(origin: Vec3, direction: Vec3, t_min: f32, t_max: f32) -> f32 {
    let a = direction.length_squared();
    let b = -origin.dot(direction);
    let closest = origin + direction * (b / a);
    let (near, far) = roots(
        a,
        b,
        origin.length_squared() - 1.0,
        1.0 - closest.length_squared(),
    );
    if near > t_min && near < t_max {
        near
    } else if far > t_min && far < t_max {
        far
    } else {
        f32::MAX
    }
}

/// Unit disk in z = 0.
#[inline]
fn intersect_disk(origin: Vec3, direction: Vec3, t_min: f32, t_max: f32) -> f32 {
    let t = -origin.z / direction.z;
    let x = origin.x + t * direction.x;
    let y = origin.y + t * direction.y;
    if t > t_min && t < t_max && x * x + y * y <= 1.0 {
        t
    } else {
        f32::MAX
    }
}

/// Open unit cylinder around z from 0 to 1.
#[inline]
fn intersect_cylinder(origin: Vec3, direction: Vec3, t_min: f32, t_max: f32) -> f32 {
    let (o, d) = (origin.truncate(), direction.truncate());
    let a = d.length_squared();
    let b = -o.dot(d);
    let closest = o + d * (b / a);
    let (near, far) = roots(
        a,
        b,
        o.length_squared() - 1.0,
        1.0 - closest.length_squared(),
    );
    let z = origin.z + near * direction.z;
    if near > t_min && near < t_max && z >= 0.0 && z <= 1.0 {
        return near;
    }
    let z = origin.z + far * direction.z;
    if far > t_min && far < t_max && z >= 0.0 && z <= 1.0 {
        far
    } else {
        f32::MAX
    }
}

/// Roots of a t^2 - 2 b t + c in increasing order, with `discriminant` = (b^2 - a c) / a. Both are [`f32::MAX`] without
/// a real root, and for a = 0 (a ray along a cylinder), where the discriminant is a NaN.
#[inline]
fn roots(a: f32, b: f32, c: f32, discriminant: f32) -> (f32, f32) {
    if discriminant >= 0.0 && a > 0.0 {
        let s = safe_sqrt(a * discriminant);
        let q = if b < 0.0 { b - s } else { b + s };
        let t0 = if q == 0.0 { 0.0 } else { c / q };
        let t1 = q / a;
        (t0.min(t1), t0.max(t1))
    } else {
        (f32::MAX, f32::MAX)
    }
}

/// Half the distance of 1 from the next float: the relative error of one rounding.
pub const ROUNDING: f32 = 5.960_464_5e-8;

/// Relative distance by which [`offset_origin`] leaves a surface.
pub const ORIGIN_OFFSET: f32 = 1.0 / 65_536.0;

/// Relative length that [`segment`] leaves off at its end.
pub const SEGMENT_TOLERANCE: f32 = 1.0e-4;

/// An origin for rays that leave `position` on the side of `direction`.
///
/// It lies off the surface by `2^-16 (max |position| + 2^-5)` along the geometric normal: 256 roundings of the
/// position's largest coordinate, which covers the error of positions on triangles and quadrics up to about a hundred
/// times as large as their distance from the world's origin, yet only 15 micrometres per metre. A surface point's
/// [`super::SurfacePoint::spawn`] uses its own bound and has neither limit.
#[inline]
pub fn offset_origin(position: Vec3, geometric_normal: Vec3, direction: Vec3) -> Vec3 {
    let p = position.abs();
    let size = p.x.max(p.y).max(p.z) + 1.0 / 32.0;
    offset_by(position, geometric_normal, direction, ORIGIN_OFFSET * size)
}

/// `position` moved by `distance` along the normal, to the side of `direction`.
#[inline]
pub fn offset_by(position: Vec3, geometric_normal: Vec3, direction: Vec3, distance: f32) -> Vec3 {
    let side = if geometric_normal.dot(direction) < 0.0 {
        -distance
    } else {
        distance
    };
    position + geometric_normal * side
}

/// The shadow ray from `from` towards `to`, which ends a little before it. A point on a surface is first offset to the side of
/// the other point. If `from` equals `to`, nothing can occlude the ray: `t_max` is zero.
#[inline]
pub fn segment(from: Vec3, to: Vec3) -> Ray {
    let d = to - from;
    let length = sqrt(d.length_squared());
    let direction = if length > 0.0 { d / length } else { Vec3::Z };
    Ray {
        origin: from,
        direction,
        t_min: 0.0,
        t_max: length * (1.0 - SEGMENT_TOLERANCE),
    }
}

/// Whether a ray can be traced: finite origin, finite direction that is not zero, and an interval.
#[inline]
pub fn is_traceable(ray: &Ray) -> bool {
    let o = abs(ray.origin.x) + abs(ray.origin.y) + abs(ray.origin.z);
    let d = abs(ray.direction.x) + abs(ray.direction.y) + abs(ray.direction.z);
    o < f32::MAX && d > 0.0 && d < f32::MAX && ray.t_min < ray.t_max
}
