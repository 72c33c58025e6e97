//! Uniformly sampled points of emitting shapes, where light walks start.
//!
//! A mesh's triangle is chosen by the table of cumulative areas, then a uniform point on it; disks, cylinders and spheres
//! take a uniform point of the canonical surface, whose area the affine map stretches by `|det A| |A^-T N|`, N the
//! canonical unit normal. The density per world area is `pmf / area` on meshes, `1 / (canonical area * stretch)` elsewhere:
//! constant unless the map squeezes a sphere or a cylinder. For spheres this differs from [`super::area::sample`], which
//! samples the solid angle that the sphere subtends at the illuminated point.
//!
//! Invariants (tests): the density integrates to one over the surface, and [`pdf_position`] at a sampled point is the
//! sampled density.

use super::area::{area_stretch, is_quadric, quadric_pdf_area, triangle_area};
use crate::math::affine::transform_point;
use crate::math::distribution::{cdf_pmf, sample_cdf};
use crate::math::{float, warp};
use crate::scene::surface::detail;
use crate::scene::surface::quadric::quadric_point_with;
use crate::scene::surface::triangle::triangle_point_with;
use crate::scene::{NONE, Quadric, SurfacePoint, Tables, features, quadric_kind};
use core::f32::consts::TAU;
use glam::{Vec2, Vec3};

/// A point of the emitter's shape and its density per area, without the probability of choosing the emitter; zero for no
/// point.
pub fn sample_position(tables: &Tables<'_>, emitter: u32, u: Vec2) -> (SurfacePoint, f32) {
    let record = &tables.emitters[emitter as usize];
    if record.shape == NONE {
        return (SurfacePoint::ZERO, 0.0);
    }
    let point = sample_on_shape(tables, record.shape, record.distribution, u);
    (point, pdf_position(tables, &point))
}

/// A point of a shape, uniform over its canonical surface; `distribution` is the first word in `data` of the cumulative areas of a
/// mesh's triangles.
pub fn sample_on_shape(
    tables: &Tables<'_>,
    index: u32,
    distribution: u32,
    u: Vec2,
) -> SurfacePoint {
    let shape = &tables.shapes[index as usize];
    let is_mesh = tables.has(features::TRIANGLES)
        && (!tables.has(features::QUADRICS) || !is_quadric(tables, index));
    if is_mesh {
        let (triangle, u_x, _) = sample_cdf(tables.data, distribution, shape.primitive_count, u.x);
        let b = warp::square_to_triangle(Vec2::new(u_x, u.y));
        let primitive = shape.first_primitive + triangle;
        triangle_point_with::<{ detail::TANGENTS }>(tables, primitive, b.x, b.y)
    } else {
        let quadric = &tables.quadrics[shape.first_primitive as usize];
        let p = if quadric.kind == quadric_kind::SPHERE {
            warp::square_to_uniform_sphere(u)
        } else if quadric.kind == quadric_kind::DISK {
            warp::square_to_disk(u).extend(0.0)
        } else {
            let (s, c) = float::sin_cos(TAU * u.x);
            Vec3::new(c, s, u.y)
        };
        quadric_point_with::<{ detail::TANGENTS }>(tables, shape.first_primitive, p)
    }
}

/// Density per area with which [`sample_position`] chooses a point of an emitting shape, without the probability of
/// choosing the emitter.
pub fn pdf_position(tables: &Tables<'_>, point: &SurfacePoint) -> f32 {
    if point.emitter == NONE {
        return 0.0;
    }
    let triangle_count = tables.triangles.len() as u32;
    let has_quadrics = tables.has(features::QUADRICS);
    let is_triangle =
        tables.has(features::TRIANGLES) && (!has_quadrics || point.primitive < triangle_count);
    let pdf = if is_triangle {
        let first = tables.shapes[point.shape as usize].first_primitive;
        let area = triangle_area(tables, point.primitive);
        let distribution = tables.emitters[point.emitter as usize].distribution;
        if area > 0.0 {
            cdf_pmf(tables.data, distribution, point.primitive - first) / area
        } else {
            0.0
        }
    } else {
        let quadric = &tables.quadrics[(point.primitive - triangle_count) as usize];
        let p = transform_point(&quadric.to_object, point.position);
        if quadric.kind == quadric_kind::SPHERE {
            sphere_pdf_area(quadric, p)
        } else {
            quadric_pdf_area(quadric, p)
        }
    };
    if float::is_finite(pdf) { pdf } else { 0.0 }
}

/// Density per world area of uniform points of the unit sphere, at the canonical point `p`.
#[inline]
fn sphere_pdf_area(quadric: &Quadric, p: Vec3) -> f32 {
    let length = p.length();
    if !(length > 0.0) {
        return 0.0;
    }
    let stretch = area_stretch(quadric, p / length);
    if stretch > 0.0 {
        warp::UNIFORM_SPHERE_PDF / stretch
    } else {
        0.0
    }
}
