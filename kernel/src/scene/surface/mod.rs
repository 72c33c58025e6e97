//! The differential geometry of a point on a surface.
//!
//! The position is computed again from the surface's own parameters, never from the ray, so that its error is a few
//! roundings of the surface's coordinates (Pharr, Jakob, Humphreys 2023, section 6.8). The orientation conventions are those
//! of Mitsuba 3: neither the geometric nor the shading normal is turned towards the other.
//!
//! | file | content |
//! |---|---|
//! | [`point`] | [`SurfacePoint`], and rays that leave it |
//! | [`triangle`], [`quadric`] | position, normals and derivatives from the parameters of a primitive |
//! | `normal`, `instance` | normalisation with derivatives; transformation by an instance |
//! | [`checked`] | the same look-up for hits that may lie outside the tables |

pub mod checked;
mod instance;
mod normal;
pub mod point;
pub mod quadric;
pub mod triangle;

pub use point::{SurfacePoint, detail};

use super::features;
use super::hit::Hit;
use super::view::Tables;
use crate::math::Ray;
use crate::math::affine::{transform_point, transform_vector};
use instance::transform_to_world;
use quadric::{quadric_point, quadric_point_with};
use triangle::triangle_point_with;

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
            transform_to_world(instance, &mut p, hit.instance);
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
        transform_to_world(instance, &mut p, hit.instance);
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
