//! A sensor that is a surface: the mean irradiance on a shape, from its front side.
//!
//! E = 1 / A int_A int L cos d omega dA. Rays start at points that are even over the shape, in directions that are distributed by
//! the cosine, so that E is pi times the mean radiance of the rays: that factor is the sensor's response. The film is spread over the
//! shape: its positions, as fractions of the film, are the numbers that choose the point, so that a pixel of many measures a part
//! of the shape, on a parallelogram a rectangle of its texture coordinates (as in Mitsuba 0.6 and 3). Invariants (tests): rays and
//! film positions are inverse to each other; the importance integrates to one over surfaces that surround the meter.
//!
//! Not for shaders: they would need the shapes' sampling in every camera ray, for a film of one pixel.

use super::emitter::position::sample_on_shape;
use super::film_position::FilmPosition;
use super::surface::triangle::triangle_point_with;
use super::surface::{SurfacePoint, detail};
use super::view::Tables;
use crate::math::{Frame, Ray, vec3, warp};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};

/// Irradiance per mean radiance of rays that are distributed by the cosine.
pub const RESPONSE: f32 = core::f32::consts::PI;

/// Largest number below one.
const LARGEST_NUMBER: f32 = 1.0 - 0.5 * f32::EPSILON;

/// Largest difference of the diagonals' middles of a parallelogram, of its diagonal.
const ROUNDING: f32 = 1e-5;

/// The point of the shape that two numbers choose.
fn point(tables: &Tables<'_>, u: Vec2) -> SurfacePoint {
    let shape = &tables.shapes[tables.camera.shape as usize];
    let first = shape.first_primitive;
    if shape.primitive_count == 2 && is_parallelogram(tables, first) {
        // Triangles 0 1 2 and 0 2 3 of the corners (0, 0), (1, 0), (1, 1), (0, 1).
        return if u.x >= u.y {
            triangle_point_with::<{ detail::NORMALS }>(tables, first, u.x - u.y, u.y)
        } else {
            triangle_point_with::<{ detail::NORMALS }>(tables, first + 1, u.x, u.y - u.x)
        };
    }
    sample_on_shape(tables, tables.camera.shape, tables.camera.shape_areas, u)
}

/// Whether two triangles are the halves of a parallelogram, in the order of a rectangle's.
fn is_parallelogram(tables: &Tables<'_>, first: u32) -> bool {
    let [a, b] = [first, first + 1].map(|i| tables.triangles[i as usize].vertices);
    if a[0] != b[0] || a[2] != b[1] {
        return false;
    }
    let corner = |i: u32| vec3(tables.positions[i as usize]);
    let (one, other) = (corner(a[2]) - corner(a[0]), corner(b[2]) - corner(a[1]));
    let apart = corner(a[0]) + corner(a[2]) - corner(a[1]) - corner(b[2]);
    apart.length() <= ROUNDING * (one.length() + other.length())
}

/// The ray through a film position in pixels of the whole film, in the direction that `u_direction` chooses, with its cosine.
pub fn ray(tables: &Tables<'_>, film: Vec2, u_direction: Vec2) -> (Ray, f32) {
    let camera = &tables.camera;
    let u = Vec2::new(
        film.x / camera.film_size[0] as f32,
        film.y / camera.film_size[1] as f32,
    );
    let point = point(tables, u.max(Vec2::ZERO).min(Vec2::splat(LARGEST_NUMBER)));
    let local = warp::square_to_cosine_hemisphere(u_direction);
    let direction = Frame::from_normal(point.geometric_normal)
        .to_world(local)
        .normalize();
    let cosine = point.geometric_normal.dot(direction).max(0.0);
    (point.spawn(direction), cosine)
}

/// Density per perpendicular area with which rays arrive `distance` away, that left the meter at a cosine.
#[inline]
pub fn pdf_perpendicular_area(cosine: f32, distance: f32) -> f32 {
    cosine * FRAC_1_PI / (distance * distance)
}

/// The projection of a point in space onto the point of the meter that `u` chooses, whatever the crop window.
pub fn project(tables: &Tables<'_>, position: Vec3, u: Vec2) -> FilmPosition {
    let camera = &tables.camera;
    let lens = point(tables, u);
    let from_lens = position - lens.position;
    let to_lens = lens.offset_position(from_lens) - position;
    let distance = to_lens.length();
    let direction = to_lens / distance;
    let cosine = -direction.dot(lens.geometric_normal);
    if !(cosine > 0.0) || !(distance > 0.0) {
        return FilmPosition::NONE;
    }
    FilmPosition {
        film: Vec2::new(
            u.x * camera.film_size[0] as f32,
            u.y * camera.film_size[1] as f32,
        ),
        is_valid: true,
        importance: pdf_perpendicular_area(cosine, distance),
        direction,
        distance,
        unclipped: distance,
        response: RESPONSE,
    }
}
