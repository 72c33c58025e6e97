//! The panoramic camera: all directions from one point, on a film of longitude and latitude.
//!
//! With film positions x, y as fractions of the film from its upper left corner, phi = 2 pi x and theta = pi y, the local direction is
//! (sin phi sin theta, cos theta, -cos phi sin theta): the middle of the film looks along +z, its upper edge along +y (the
//! `spherical` sensor of Mitsuba 0.6). Directions have the density 1 / (2 pi^2 sin theta) per solid angle for even film positions,
//! and W_e is that density. Clipping planes are distances from the point. Invariants (tests): as of all cameras.

use super::records::Camera;
use crate::math::affine::{transform_point, transform_vector, translation};
use crate::math::{Ray, float};
use core::f32::consts::{FRAC_1_PI, PI, TAU};
use glam::{Vec2, Vec3};

/// The ray through a film position in pixels of the whole film.
pub fn ray(camera: &Camera, film: Vec2) -> Ray {
    let (sin_phi, cos_phi) = float::sin_cos(TAU * (film.x / camera.film_size[0] as f32));
    let (sin_theta, cos_theta) = float::sin_cos(PI * (film.y / camera.film_size[1] as f32));
    let local = Vec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta);
    Ray {
        origin: translation(&camera.to_world),
        direction: transform_vector(&camera.to_world, local).normalize(),
        t_min: camera.clip[0],
        t_max: camera.clip[1],
    }
}

/// Where a point is seen.
#[derive(Clone, Copy, Debug)]
pub struct SphericalProjection {
    /// Film position in pixels of the whole film.
    pub film: Vec2,
    /// Density of the direction per solid angle for even film positions; infinite at the poles.
    pub pdf: f32,
    /// From the point to the camera, not normalised.
    pub to_camera: Vec3,
}

/// The projection of a point.
pub fn project(camera: &Camera, point: Vec3) -> SphericalProjection {
    let local = transform_point(&camera.to_camera, point);
    let across = float::sqrt(local.x * local.x + local.z * local.z);
    let turn = float::atan2(local.x, -local.z) * (0.5 * FRAC_1_PI);
    let x = if turn < 0.0 { turn + 1.0 } else { turn };
    let y = float::atan2(across, local.y) * FRAC_1_PI;
    SphericalProjection {
        film: Vec2::new(
            x * camera.film_size[0] as f32,
            y * camera.film_size[1] as f32,
        ),
        pdf: 0.5 * FRAC_1_PI * FRAC_1_PI * local.length() / across,
        to_camera: translation(&camera.to_world) - point,
    }
}
