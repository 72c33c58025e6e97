//! Emission of shapes, on the side of their normal.
//!
//! - Meshes: a triangle by the table of cumulative areas, then a uniform point on it; density per area `pmf / area`.
//! - Disks and cylinders: a uniform point of the canonical surface; the affine map stretches its area by
//!   `|det A| |A^-T N|`, N the canonical unit normal, which is constant unless the map squeezes a cylinder.
//! - Spheres: a direction of the cone that the sphere subtends (`super::sphere`); density per solid angle.
//!
//! Densities per area become densities per solid angle by `d^2 / |cos|` with the geometric normal. Whether a point
//! emits towards the viewer is decided by its shading normal, as in Mitsuba. Points whose density would not be finite
//! (seen edge on, or at no distance) are no samples.
//!
//! Invariants (tests): the density integrates to one; [`pdf_direct`] at the sampled point is the sampled density.

use super::direct_sample::DirectSample;
use super::sphere::{sample_cone, sphere_pdf};
use crate::math::affine::{determinant, transform_normal, transform_point};
use crate::math::distribution::{cdf_pmf, sample_cdf};
use crate::math::{Rgb, field, float, vec3, warp};
use crate::scene::surface::detail;
use crate::scene::surface::quadric::{quadric_point_with, sphere_point_with};
use crate::scene::surface::triangle::{area, corners, triangle_point_of};
use crate::scene::texture::eval_rgb;
use crate::scene::{NONE, Quadric, SurfacePoint, Tables, features, quadric_kind};
use core::f32::consts::{FRAC_1_PI, TAU};
use glam::{Vec2, Vec3};

/// Radiance that a surface point emits towards `direction_to_viewer`; zero for points that emit nothing there.
pub fn area_radiance(tables: &Tables<'_>, point: &SurfacePoint, direction_to_viewer: Vec3) -> Rgb {
    if !tables.has(features::AREA_LIGHTS)
        || point.emitter == NONE
        || !(point.frame.n.dot(direction_to_viewer) > 0.0)
    {
        return Vec3::ZERO;
    }
    let emitter = &tables.emitters[point.emitter as usize];
    eval_rgb(tables, &emitter.radiance, point)
}

/// The density per solid angle at `reference` with which [`super::sample_direct`] chooses the point `light` of an area
/// light, the choice of the emitter included; zero for points that it cannot choose.
pub fn pdf_direct(tables: &Tables<'_>, reference: Vec3, light: &SurfacePoint) -> f32 {
    if !tables.has(features::AREA_LIGHTS) || light.emitter == NONE {
        return 0.0;
    }
    let emitter = &tables.emitters[light.emitter as usize];
    let triangle_count = tables.triangles.len() as u32;
    let has_quadrics = tables.has(features::QUADRICS);
    let is_triangle =
        tables.has(features::TRIANGLES) && (!has_quadrics || light.primitive < triangle_count);
    let pdf = if is_triangle {
        let first = tables.shapes[light.shape as usize].first_primitive;
        let area = triangle_area(tables, light.primitive);
        if !(area > 0.0) {
            return 0.0;
        }
        let pmf = cdf_pmf(tables.data, emitter.distribution, light.primitive - first);
        per_solid_angle(reference, light, pmf / area)
    } else {
        let quadric = &tables.quadrics[(light.primitive - triangle_count) as usize];
        if quadric.kind == quadric_kind::SPHERE {
            sphere_pdf(quadric, reference, light.position)
        } else {
            let p = transform_point(&quadric.to_object, light.position);
            per_solid_angle(reference, light, quadric_pdf_area(quadric, p))
        }
    };
    pdf * emitter.selection_pdf
}

/// Samples a point of a shape; `pdf` does not hold the probability of choosing the emitter.
pub fn sample(tables: &Tables<'_>, emitter: u32, reference: Vec3, u: Vec2) -> DirectSample {
    sample_with_point(tables, emitter, reference, u).0
}

/// [`sample`], and the sampled surface point, which is undefined without a sample.
#[inline]
pub fn sample_with_point(
    tables: &Tables<'_>,
    emitter: u32,
    reference: Vec3,
    u: Vec2,
) -> (DirectSample, SurfacePoint) {
    let record = &tables.emitters[emitter as usize];
    if record.shape == NONE {
        return (DirectSample::NONE, SurfacePoint::ZERO);
    }
    let shape = &tables.shapes[record.shape as usize];
    let is_mesh = tables.has(features::TRIANGLES)
        && (!tables.has(features::QUADRICS) || !is_quadric(tables, record.shape));
    let (mut sample, point) = if is_mesh {
        let (triangle, u_x, pmf) =
            sample_cdf(tables.data, record.distribution, shape.primitive_count, u.x);
        let primitive = shape.first_primitive + triangle;
        on_triangle(tables, primitive, pmf, reference, Vec2::new(u_x, u.y))
    } else {
        let index = shape.first_primitive;
        let quadric = &tables.quadrics[index as usize];
        if quadric.kind == quadric_kind::SPHERE {
            on_sphere(tables, index, reference, u)
        } else {
            let p = if quadric.kind == quadric_kind::DISK {
                warp::square_to_disk(u).extend(0.0)
            } else {
                let (s, c) = float::sin_cos(TAU * u.x);
                Vec3::new(c, s, u.y)
            };
            let point = quadric_point_with::<{ detail::NORMALS }>(tables, index, p);
            let pdf_area = quadric_pdf_area(quadric, p);
            (towards(reference, &point, pdf_area), point)
        }
    };
    if !(sample.pdf > 0.0) {
        return (DirectSample::NONE, point);
    }
    // Once for all shapes, because shader compilers copy the texture lookup to every call.
    sample.target = point.offset_position(-sample.direction);
    sample.radiance = area_radiance(tables, &point, -sample.direction);
    sample.emitter = emitter;
    (sample, point)
}

/// A point of a triangle that has been chosen with the probability `pmf`, without its radiance.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn on_triangle(
    tables: &Tables<'_>,
    primitive: u32,
    pmf: f32,
    reference: Vec3,
    u: Vec2,
) -> (DirectSample, SurfacePoint) {
    let corners = corners(tables, primitive);
    let area = area(corners.positions);
    let b = warp::square_to_triangle(u);
    let point = triangle_point_of::<{ detail::NORMALS }>(&corners, primitive, b.x, b.y);
    let sample = if area > 0.0 {
        towards(reference, &point, pmf / area)
    } else {
        DirectSample::NONE
    };
    (sample, point)
}

/// A point of a sphere by its index among the quadrics, without its radiance.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn on_sphere(
    tables: &Tables<'_>,
    index: u32,
    reference: Vec3,
    u: Vec2,
) -> (DirectSample, SurfacePoint) {
    let (to_world, to_object) = (
        field(tables.quadrics, index, |q| q.to_world),
        field(tables.quadrics, index, |q| q.to_object),
    );
    let cone = sample_cone(&to_world, &to_object, reference, u);
    let point = sphere_point_with::<{ detail::NORMALS }>(tables, index, cone.point);
    let sample = DirectSample {
        direction: cone.direction,
        distance: cone.distance,
        pdf: cone.pdf,
        ..DirectSample::NONE
    };
    (sample, point)
}

/// Whether a shape is analytic: quadrics and meshes count their primitives apart, and only one of the two tables holds
/// the shape at its first primitive.
#[inline]
pub(super) fn is_quadric(tables: &Tables<'_>, shape: u32) -> bool {
    let first = tables.shapes[shape as usize].first_primitive;
    first < tables.quadrics.len() as u32 && tables.quadrics[first as usize].shape == shape
}

/// Direction, distance and density of a point with a density per area; no sample where that is not finite.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn towards(reference: Vec3, point: &SurfacePoint, pdf_area: f32) -> DirectSample {
    let pdf = per_solid_angle(reference, point, pdf_area);
    if !(pdf > 0.0) {
        return DirectSample::NONE;
    }
    let to_light = point.position - reference;
    let distance = to_light.length();
    DirectSample {
        direction: to_light * (1.0 / distance),
        distance,
        pdf,
        ..DirectSample::NONE
    }
}

/// A density per area at `point` as a density per solid angle at `reference`; zero where that is not finite.
#[inline]
fn per_solid_angle(reference: Vec3, point: &SurfacePoint, pdf_area: f32) -> f32 {
    let d = point.position - reference;
    let distance2 = d.length_squared();
    let distance = float::sqrt(distance2);
    // |cos| times the distance.
    let projected = float::abs(point.geometric_normal.dot(d));
    if !(projected > 1e-7 * distance) {
        return 0.0;
    }
    let pdf = pdf_area * distance2 * (distance / projected);
    if float::is_finite(pdf) { pdf } else { 0.0 }
}

/// Area of a triangle.
#[inline]
pub(super) fn triangle_area(tables: &Tables<'_>, primitive: u32) -> f32 {
    let [i0, i1, i2] = tables.triangles[primitive as usize].vertices;
    area([
        vec3(tables.positions[i0 as usize]),
        vec3(tables.positions[i1 as usize]),
        vec3(tables.positions[i2 as usize]),
    ])
}

/// Density per world area of uniform points of a canonical disk or cylinder, at the canonical point `p`.
#[inline]
pub(super) fn quadric_pdf_area(quadric: &Quadric, p: Vec3) -> f32 {
    let (normal, canonical_pdf) = if quadric.kind == quadric_kind::DISK {
        (Vec3::Z, FRAC_1_PI)
    } else {
        let radius = float::sqrt(p.x * p.x + p.y * p.y);
        if !(radius > 0.0) {
            return 0.0;
        }
        (Vec3::new(p.x / radius, p.y / radius, 0.0), 1.0 / TAU)
    };
    let stretch = area_stretch(quadric, normal);
    if stretch > 0.0 {
        canonical_pdf / stretch
    } else {
        0.0
    }
}

/// World area over canonical area where the canonical unit normal is `normal`.
#[inline]
pub(super) fn area_stretch(quadric: &Quadric, normal: Vec3) -> f32 {
    float::abs(determinant(&quadric.to_world))
        * transform_normal(&quadric.to_object, normal).length()
}

/// Fills the sampling table of a shape, `out` having one word per primitive of the shape; returns the shape's area.
///
/// Runs on the host only: it visits the whole mesh and sums in `f64`.
#[cfg(not(target_arch = "spirv"))]
pub fn fill_shape_areas(tables: &Tables<'_>, shape: u32, out: &mut [f32]) -> f32 {
    let first = tables.shapes[shape as usize].first_primitive;
    for (i, area) in out.iter_mut().enumerate() {
        *area = if is_quadric(tables, shape) {
            quadric_area(&tables.quadrics[first as usize])
        } else {
            triangle_area(tables, first + i as u32)
        };
    }
    crate::math::distribution::fill_cdf(out) as f32
}

/// Area of a quadric in its group's space: exact for disks, round spheres and round cylinders, by quadrature otherwise.
///
/// Runs on the host only, once per light: it sums in `f64`.
#[cfg(not(target_arch = "spirv"))]
fn quadric_area(quadric: &Quadric) -> f32 {
    let pi = core::f64::consts::PI;
    if quadric.kind == quadric_kind::DISK {
        return (pi * f64::from(area_stretch(quadric, Vec3::Z))) as f32;
    }
    const N: u32 = 64;
    let mut mean = 0.0;
    for i in 0..N {
        for j in 0..N {
            let (s, c) = float::sin_cos(TAU * (i as f32 + 0.5) / N as f32);
            let z = if quadric.kind == quadric_kind::SPHERE {
                2.0 * (j as f32 + 0.5) / N as f32 - 1.0
            } else {
                0.0
            };
            let r = float::safe_sqrt(1.0 - z * z);
            mean += f64::from(area_stretch(quadric, Vec3::new(c * r, s * r, z)));
        }
    }
    mean /= f64::from(N * N);
    let canonical = if quadric.kind == quadric_kind::SPHERE {
        4.0 * pi
    } else {
        2.0 * pi
    };
    (canonical * mean) as f32
}

/// See [`super::power`]: the emitter's `area` must be set.
#[cfg(not(target_arch = "spirv"))]
pub(super) fn power(tables: &Tables<'_>, emitter: &crate::scene::Emitter) -> f64 {
    use crate::math::luminance;
    use crate::scene::surface::surface_at_primitive;
    if emitter.shape == NONE {
        return 0.0;
    }
    // A texture counts by the mean over points spread evenly over the shape's area.
    const N: u32 = 16;
    let mut mean = 0.0;
    let shape = &tables.shapes[emitter.shape as usize];
    for i in 0..N {
        for j in 0..N {
            let u = Vec2::new((i as f32 + 0.5) / N as f32, (j as f32 + 0.5) / N as f32);
            let point = if !is_quadric(tables, emitter.shape) {
                let (triangle, x, _) = sample_cdf(
                    tables.data,
                    emitter.distribution,
                    shape.primitive_count,
                    u.x,
                );
                let b = warp::square_to_triangle(Vec2::new(x, u.y));
                surface_at_primitive(tables, shape.first_primitive + triangle, b.x, b.y)
            } else {
                let primitive = tables.triangles.len() as u32 + shape.first_primitive;
                surface_at_primitive(tables, primitive, u.x, u.y)
            };
            let radiance = luminance(eval_rgb(tables, &emitter.radiance, &point));
            mean += f64::from(radiance) / f64::from(N * N);
        }
    }
    core::f64::consts::PI * f64::from(emitter.area) * mean
}
