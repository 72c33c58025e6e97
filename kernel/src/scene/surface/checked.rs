//! The surface at a hit with all indices checked, for callers that must not panic on any hit.
//!
//! [`surface_at`](super::surface_at) looks up a hit's primitive, its shape, vertices and instance. A traverser over other
//! tables than the view's would lead it beyond their ends: to a panic, or to zeros. Here every index is compared with the
//! length of its table first, and an invalid hit is rejected. Walks on manifolds use it; hits of a traverser over the same
//! tables are always valid. Checked: hits of every index against `surface_at`; that the compiled walk calls no panic handler
//! (`benches/README.md`).

use super::instance::transform_to_world;
use super::point::{SurfacePoint, detail};
use super::quadric::quadric_point_with;
use super::triangle::{Corners, is_smooth, triangle_point_of};
use crate::math::affine::{transform_point, transform_vector};
use crate::math::{Ray, vec3};
use crate::scene::features;
use crate::scene::hit::Hit;
use crate::scene::records::NONE;
use crate::scene::view::Tables;
use glam::Vec2;

/// A surface point, or none.
#[derive(Clone, Copy, Debug)]
pub struct CheckedSurface {
    /// As [`super::surface_at`] has it; zeros when `valid` is false.
    pub point: SurfacePoint,
    /// Whether all indices of the hit are within the tables.
    pub valid: bool,
}

/// The surface at an intersection found along `ray`. A miss is refused.
#[inline]
pub fn checked_surface_at(tables: &Tables<'_>, ray: &Ray, hit: &Hit) -> CheckedSurface {
    let mut out = CheckedSurface {
        point: SurfacePoint::ZERO,
        valid: false,
    };
    if !hit.is_hit() {
        return out;
    }
    let triangle_count = tables.triangles.len() as u32;
    let is_placed = tables.has(features::INSTANCES) && hit.instance != 0;
    if tables.has(features::TRIANGLES) && hit.primitive < triangle_count {
        let found = checked_corners(tables, hit.primitive);
        if !found.valid {
            return out;
        }
        out.point = triangle_point_of::<{ detail::CURVATURE }>(
            &found.corners,
            hit.primitive,
            hit.b1,
            hit.b2,
        );
    } else {
        if !tables.has(features::QUADRICS) || hit.primitive < triangle_count {
            return out;
        }
        let quadric = (hit.primitive - triangle_count) as usize;
        if quadric >= tables.quadrics.len() {
            return out;
        }
        let record = &tables.quadrics[quadric];
        if record.shape as usize >= tables.shapes.len() {
            return out;
        }
        let (mut origin, mut direction) = (ray.origin, ray.direction);
        if is_placed {
            if hit.instance as usize >= tables.instances.len() {
                return out;
            }
            let to_group = &tables.instances[hit.instance as usize].to_object;
            origin = transform_point(to_group, origin);
            direction = transform_vector(to_group, direction);
        }
        origin = transform_point(&record.to_object, origin);
        direction = transform_vector(&record.to_object, direction);
        let at = origin + direction * hit.t;
        out.point = quadric_point_with::<{ detail::CURVATURE }>(tables, quadric as u32, at);
    }
    out.valid = true;
    if is_placed {
        out.valid = (hit.instance as usize) < tables.instances.len();
        if out.valid {
            let instance = &tables.instances[hit.instance as usize];
            transform_to_world(instance, &mut out.point, hit.instance);
        }
    }
    out
}

/// The corners of a triangle, or that the tables do not hold them.
#[derive(Clone, Copy)]
struct CheckedCorners {
    corners: Corners,
    valid: bool,
}

#[inline]
fn checked_corners(tables: &Tables<'_>, primitive: u32) -> CheckedCorners {
    let mut out = CheckedCorners {
        corners: Corners::ZERO,
        valid: false,
    };
    if primitive as usize >= tables.triangles.len() {
        return out;
    }
    let triangle = &tables.triangles[primitive as usize];
    if triangle.shape as usize >= tables.shapes.len() {
        return out;
    }
    let shape = tables.shapes[triangle.shape as usize];
    out.corners = Corners {
        shape: triangle.shape,
        material: shape.material,
        emitter: shape.emitter,
        flags: shape.flags,
        normal_offset: shape.normal_offset,
        uv_offset: shape.uv_offset,
        ..Corners::ZERO
    };
    for i in 0..3 {
        let vertex = triangle.vertices[i];
        if vertex as usize >= tables.positions.len() {
            return out;
        }
        out.corners.positions[i] = vec3(tables.positions[vertex as usize]);
        if shape.uv_offset != NONE {
            let at = vertex.wrapping_add(shape.uv_offset) as usize;
            if at >= tables.uvs.len() {
                return out;
            }
            let uv = tables.uvs[at];
            out.corners.uvs[i] = Vec2::new(uv[0], uv[1]);
        }
        if is_smooth(shape.normal_offset, shape.flags) {
            let at = vertex.wrapping_add(shape.normal_offset) as usize;
            if at >= tables.normals.len() {
                return out;
            }
            out.corners.normals[i] = vec3(tables.normals[at]);
        }
    }
    out.valid = true;
    out
}
