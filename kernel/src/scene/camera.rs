//! Cameras: from a film position to a ray, and from a point in space to its film position and importance.
//!
//! Local frame: the camera looks along +z, +y is up in the image and +x is left (the frame of Mitsuba's `lookat`). The
//! film spans the rectangle |x| <= `tan_half_width`, |y| <= `tan_half_height` in the plane z = 1 for perspective kinds,
//! in the plane z = 0 for the orthographic one. Film positions are in pixels of the whole film, from its upper left
//! corner, whatever the crop window.
//!
//! Importance is the sensor's response per perpendicular area at a point of the scene: a surface element dA around y
//! with cosine c towards the lens point adds `radiance * c * importance * dA` to the mean over the whole film
//! (independently of the crop window). So the integral of `c * importance` over any surface that fills the view is one.
//! In terms of the usual W_e per area and solid angle at the lens: `importance = W_e cos_lens / (d^2 pdf_lens)`; for the
//! pinhole W_e = 1 / (A cos^4), A the film's area in the plane z = 1 (Veach 1997, section 8.3.2).
//!
//! The panoramic camera has its own film ([`super::spherical_camera`]), and so has the meter of irradiance, whose lens is a shape
//! ([`super::irradiance_meter`]).
//!
//! Invariants (tests): [`sample_ray`] and [`film_position`] are inverse to each other; the importance integrates to
//! one; rays agree with an independent renderer.

pub use super::field_of_view::{fov_axis, half_extents};
pub use super::film_position::{CameraSample, FilmPosition};

#[cfg(not(target_arch = "spirv"))]
use super::irradiance_meter;
use super::records::*;
use super::spherical_camera;
use super::view::Tables;
use crate::math::affine::{transform_point, transform_vector};
use crate::math::{Ray, filter, float, warp};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};

/// The local position in the film's plane of a film position in pixels.
#[inline]
fn film_to_local(camera: &Camera, film: Vec2) -> Vec2 {
    let x = film.x / camera.film_size[0] as f32 + camera.principal_point_offset[0];
    let y = film.y / camera.film_size[1] as f32 + camera.principal_point_offset[1];
    Vec2::new(
        (1.0 - 2.0 * x) * camera.tan_half_width,
        (1.0 - 2.0 * y) * camera.tan_half_height,
    )
}

/// Inverse of [`film_to_local`].
#[inline]
fn local_to_film(camera: &Camera, p: Vec2) -> Vec2 {
    let x = 0.5 - 0.5 * p.x / camera.tan_half_width - camera.principal_point_offset[0];
    let y = 0.5 - 0.5 * p.y / camera.tan_half_height - camera.principal_point_offset[1];
    Vec2::new(
        x * camera.film_size[0] as f32,
        y * camera.film_size[1] as f32,
    )
}

/// The lens point in the local plane z = 0; the origin for a pinhole.
#[inline]
fn lens_point(camera: &Camera, u_lens: Vec2) -> Vec2 {
    if camera.kind == camera_kind::THIN_LENS {
        warp::square_to_disk(u_lens) * camera.aperture_radius
    } else {
        Vec2::ZERO
    }
}

/// The ray of a camera through a film position in pixels of the whole film and a lens point.
#[inline]
pub fn ray_through(camera: &Camera, film: Vec2, u_lens: Vec2) -> Ray {
    if camera.kind == camera_kind::SPHERICAL {
        spherical_camera::ray(camera, film)
    } else {
        projective_ray(camera, film, u_lens)
    }
}

/// [`ray_through`] of perspective and orthographic cameras.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn projective_ray(camera: &Camera, film: Vec2, u_lens: Vec2) -> Ray {
    let p = film_to_local(camera, film);
    let (near, far) = (camera.clip[0], camera.clip[1]);
    if camera.kind == camera_kind::ORTHOGRAPHIC {
        let axis = transform_vector(&camera.to_world, Vec3::Z);
        let scale = axis.length();
        let t_min = near * scale;
        return Ray {
            origin: transform_point(&camera.to_world, p.extend(0.0)),
            direction: axis / scale,
            t_min,
            // The near plane moves with a scale of the frame, the depth behind it does not: as in Mitsuba.
            t_max: t_min + (far - near),
        };
    }
    let lens = lens_point(camera, u_lens);
    let local = if camera.kind == camera_kind::THIN_LENS {
        // Through the point in focus; scaled to unit z for the clipping planes below.
        let focus = if camera.focus_distance > 1e-12 {
            camera.focus_distance
        } else {
            1e-12
        };
        (p - lens / focus).extend(1.0)
    } else {
        p.extend(1.0)
    };
    let direction = transform_vector(&camera.to_world, local);
    // The world length of one unit of z along this ray.
    let length = direction.length();
    Ray {
        origin: transform_point(&camera.to_world, lens.extend(0.0)),
        direction: direction / length,
        t_min: near * length,
        t_max: far * length,
    }
}

/// A ray for the pixel (absolute, crop offset included), its film position drawn from the reconstruction filter by
/// `u_film`, its lens point by `u_lens`.
pub fn sample_ray(
    tables: &Tables<'_>,
    pixel: [u32; 2],
    u_film: Vec2,
    u_lens: Vec2,
) -> CameraSample {
    let (x, weight_x) = sample_axis::<0>(tables, pixel[0], u_film.x);
    let (y, weight_y) = sample_axis::<1>(tables, pixel[1], u_film.y);
    let mut sample = sample_through(tables, Vec2::new(x, y), u_lens);
    sample.weight *= weight_x * weight_y;
    sample
}

/// A ray through a film position in pixels of the whole film, without the filter.
#[inline]
pub fn sample_through(tables: &Tables<'_>, film: Vec2, u_lens: Vec2) -> CameraSample {
    let camera = &tables.camera;
    #[cfg(not(target_arch = "spirv"))]
    if camera.kind == camera_kind::IRRADIANCE_METER {
        let (ray, cosine) = irradiance_meter::ray(tables, film, u_lens);
        return CameraSample {
            ray,
            weight: irradiance_meter::RESPONSE,
            film,
            cosine,
        };
    }
    CameraSample {
        ray: ray_through(camera, film, u_lens),
        weight: 1.0,
        film,
        cosine: 1.0,
    }
}

/// A film coordinate for a pixel and its weight: the filter around the pixel's centre, cut at the crop window.
#[inline]
fn sample_axis<const AXIS: usize>(tables: &Tables<'_>, pixel: u32, u: f32) -> (f32, f32) {
    let support = Support::new::<AXIS>(&tables.camera, pixel);
    if support.is_empty() {
        return support.outside();
    }
    let (lo, hi) = (support.lo, support.hi);
    let (offset, weight) = filter::sample(
        &tables.camera.reconstruction_filter(),
        tables.data,
        lo,
        hi,
        u,
    );
    (support.center + offset, weight)
}

/// What the film's window leaves of a filter's support, along an axis.
#[derive(Clone, Copy)]
pub struct Support {
    /// The pixel's centre.
    pub center: f32,
    /// From the centre to the lower end.
    pub lo: f32,
    /// From the centre to the upper end.
    pub hi: f32,
}

impl Support {
    /// Around the centre of a pixel by its coordinate (absolute, crop offset included) along axis 0 or 1.
    #[inline]
    pub fn new<const AXIS: usize>(camera: &Camera, pixel: u32) -> Support {
        let radius = filter::radius(camera.filter, camera.filter_parameters);
        let (offset, size) = (camera.crop_offset[AXIS], camera.crop_size[AXIS]);
        let center = pixel as f32 + 0.5;
        let to_start = offset as f32 - center;
        let to_end = (offset + size) as f32 - center;
        Support {
            center,
            lo: if to_start > -radius {
                to_start
            } else {
                -radius
            },
            hi: if to_end < radius { to_end } else { radius },
        }
    }

    /// Whether nothing is left, for a pixel outside the window.
    #[inline]
    pub fn is_empty(&self) -> bool {
        !(self.hi > self.lo)
    }

    /// Coordinate and weight for such a pixel.
    #[inline]
    pub fn outside(&self) -> (f32, f32) {
        (self.center, 0.0)
    }
}

/// The film position of `point` through the lens point of `u_lens`, and its importance.
pub fn film_position(tables: &Tables<'_>, point: Vec3, u_lens: Vec2) -> FilmPosition {
    #[cfg(not(target_arch = "spirv"))]
    if tables.camera.kind == camera_kind::IRRADIANCE_METER {
        let result = irradiance_meter::project(tables, point, u_lens);
        return within_window(&tables.camera, result);
    }
    film_position_through(tables, point, lens_point(&tables.camera, u_lens))
}

/// [`film_position`] through a lens point in the local plane z = 0.
pub fn film_position_through(tables: &Tables<'_>, point: Vec3, lens: Vec2) -> FilmPosition {
    let camera = &tables.camera;
    let local = transform_point(&camera.to_camera, point);
    let mut result = FilmPosition::NONE;
    if camera.kind == camera_kind::SPHERICAL {
        return spherical_position(camera, point);
    }
    let area = 4.0 * camera.tan_half_width * camera.tan_half_height;
    if !(local.z > 0.0) || !(area > 0.0) {
        return result;
    }
    if camera.kind == camera_kind::ORTHOGRAPHIC {
        let axis = transform_vector(&camera.to_world, Vec3::Z);
        let scale = axis.length();
        result.direction = axis * (-1.0 / scale);
        result.distance = local.z * scale;
        result.film = local_to_film(camera, local.truncate());
        let depth = result.distance - camera.clip[0] * scale;
        result.unclipped = depth;
        result.is_valid = depth > 0.0 && depth < camera.clip[1] - camera.clip[0];
    } else {
        let to_lens = transform_point(&camera.to_world, lens.extend(0.0)) - point;
        let distance = to_lens.length();
        result.direction = to_lens / distance;
        result.distance = distance;
        result.film = local_to_film(camera, pinhole_slope(camera, local, lens));
        result.unclipped = distance * (1.0 - camera.clip[0] / local.z);
        result.is_valid = local.z > camera.clip[0] && local.z < camera.clip[1];
    }
    result.importance = importance(camera, local.z, result.distance);
    within_window(camera, result)
}

/// [`film_position`] of a panoramic camera.
fn spherical_position(camera: &Camera, point: Vec3) -> FilmPosition {
    let seen = spherical_camera::project(camera, point);
    let distance = seen.to_camera.length();
    let result = FilmPosition {
        film: seen.film,
        is_valid: distance > camera.clip[0] && distance < camera.clip[1],
        importance: seen.pdf / (distance * distance),
        direction: seen.to_camera / distance,
        distance,
        unclipped: distance - camera.clip[0],
        ..FilmPosition::NONE
    };
    within_window(camera, result)
}

/// Not seen where it is outside of the crop window, or where the importance is infinite.
#[inline]
fn within_window(camera: &Camera, mut result: FilmPosition) -> FilmPosition {
    let x0 = camera.crop_offset[0] as f32;
    let y0 = camera.crop_offset[1] as f32;
    let in_window = result.film.x >= x0
        && result.film.y >= y0
        && result.film.x < x0 + camera.crop_size[0] as f32
        && result.film.y < y0 + camera.crop_size[1] as f32;
    result.is_valid = result.is_valid && in_window && float::is_finite(result.importance);
    if !result.is_valid {
        result.importance = 0.0;
    }
    result
}

/// Where the pinhole's ray through the film position of a local point, seen from a lens point, intersects the plane z = 1.
#[inline]
fn pinhole_slope(camera: &Camera, local: Vec3, lens: Vec2) -> Vec2 {
    let slope = (local.truncate() - lens) / local.z;
    if camera.kind == camera_kind::THIN_LENS && camera.focus_distance > 1e-12 {
        slope + lens / camera.focus_distance
    } else {
        slope
    }
}

/// Importance per perpendicular area at a point of depth `z` that is `distance` away from the lens point.
#[inline]
fn importance(camera: &Camera, z: f32, distance: f32) -> f32 {
    let area = 4.0 * camera.tan_half_width * camera.tan_half_height;
    if camera.kind == camera_kind::ORTHOGRAPHIC {
        // The film's area across the rays, in world units.
        let x = transform_vector(&camera.to_world, Vec3::X);
        let y = transform_vector(&camera.to_world, Vec3::Y);
        let axis = transform_vector(&camera.to_world, Vec3::Z);
        return 1.0 / (area * float::abs(x.cross(y).dot(axis)) / axis.length());
    }
    // d(film plane) / d(plane z = const) = 1 / z^2, and d(plane) = d(perpendicular area) / cos with cos = z / d.
    distance / (area * z * z * z)
}

/// Pixels of the whole film per pixel of the crop window: densities of rays through the window per density over the film.
#[inline]
pub fn pixels_per_window_pixel(camera: &Camera) -> f32 {
    let film = camera.film_size[0] as f32 * camera.film_size[1] as f32;
    film / (camera.crop_size[0] as f32 * camera.crop_size[1] as f32)
}

/// Density per perpendicular area with which rays from the lens point, one per pixel of the window and evenly over its
/// area, arrive at `point`, `distance` away; zero behind the camera. Clipping planes and the window's rim are ignored.
pub fn pdf_perpendicular_area(tables: &Tables<'_>, point: Vec3, distance: f32) -> f32 {
    let camera = &tables.camera;
    let importance = if camera.kind == camera_kind::SPHERICAL {
        spherical_camera::project(camera, point).pdf / (distance * distance)
    } else {
        let z = transform_point(&camera.to_camera, point).z;
        if !(z > 0.0) {
            return 0.0;
        }
        importance(camera, z, distance)
    };
    let pdf = importance * pixels_per_window_pixel(camera);
    if float::is_finite(pdf) { pdf } else { 0.0 }
}

/// Whether numbers choose the point of the lens.
#[inline]
pub fn has_lens_points(camera: &Camera) -> bool {
    camera.kind == camera_kind::THIN_LENS || camera.kind == camera_kind::IRRADIANCE_METER
}

/// Density per area of the points of a lens; zero where the lens is a point or rays are parallel.
#[inline]
pub fn pdf_lens_area(camera: &Camera) -> f32 {
    let r = camera.aperture_radius;
    if camera.kind == camera_kind::THIN_LENS && r > 0.0 {
        FRAC_1_PI / (r * r)
    } else {
        0.0
    }
}

/// Unit direction in which the camera looks: the normal of its lens.
#[inline]
pub fn optical_axis(camera: &Camera) -> Vec3 {
    transform_vector(&camera.to_world, Vec3::Z).normalize()
}

/// The intersection of a ray with the lens, from its front.
#[derive(Clone, Copy, Debug)]
pub struct LensHit {
    /// The lens point in the local plane z = 0.
    pub lens: Vec2,
    /// Ray parameter.
    pub t: f32,
    /// Whether the ray hits the lens.
    pub is_hit: bool,
}

/// The intersection of a light ray with a lens of finite aperture.
pub fn intersect_lens(camera: &Camera, ray: &Ray) -> LensHit {
    let miss = LensHit {
        lens: Vec2::ZERO,
        t: 0.0,
        is_hit: false,
    };
    if camera.kind != camera_kind::THIN_LENS || !(camera.aperture_radius > 0.0) {
        return miss;
    }
    let origin = transform_point(&camera.to_camera, ray.origin);
    let direction = transform_vector(&camera.to_camera, ray.direction);
    if !(origin.z > 0.0) || !(direction.z < 0.0) {
        return miss;
    }
    let t = origin.z / -direction.z;
    let lens = origin.truncate() + direction.truncate() * t;
    LensHit {
        lens,
        t,
        is_hit: lens.length_squared() < float::sqr(camera.aperture_radius) && t < ray.t_max,
    }
}
