//! What cameras return: rays with their film positions, and projections of points with their importance.

use crate::math::Ray;
use glam::{Vec2, Vec3};

/// A ray that a pixel's value is estimated with.
#[derive(Clone, Copy, Debug)]
pub struct CameraSample {
    /// The ray; `t_min` and `t_max` are the clipping planes.
    pub ray: Ray,
    /// Factor of the radiance in the pixel's mean; negative in a filter's negative lobes.
    pub weight: f32,
    /// Film position in pixels of the whole film.
    pub film: Vec2,
    /// Cosine at the surface of an irradiance meter; one for cameras.
    pub cosine: f32,
}

impl CameraSample {
    /// A ray of weight one through nowhere in particular.
    #[inline]
    pub fn along(ray: &Ray) -> CameraSample {
        CameraSample {
            ray: *ray,
            weight: 1.0,
            film: Vec2::ZERO,
            cosine: 1.0,
        }
    }
}

/// The projection of a point in space onto the film.
#[derive(Clone, Copy, Debug)]
pub struct FilmPosition {
    /// Film position in pixels of the whole film.
    pub film: Vec2,
    /// Whether the point is between the clipping planes and its film position in the crop window.
    pub is_valid: bool,
    /// Importance per perpendicular area at the point; zero when not valid.
    pub importance: f32,
    /// Unit direction from the point to the lens.
    pub direction: Vec3,
    /// Distance from the point to the lens point (to the plane z = 0 for parallel rays).
    pub distance: f32,
    /// The part of that distance beyond the near clipping plane: surfaces nearer to the lens are invisible and occlude nothing.
    pub unclipped: f32,
    /// What the sensor measures per mean radiance of its rays: pi for an irradiance meter, one for cameras.
    pub response: f32,
}

impl FilmPosition {
    /// Not seen.
    pub const NONE: FilmPosition = FilmPosition {
        film: Vec2::ZERO,
        is_valid: false,
        importance: 0.0,
        direction: Vec3::Z,
        distance: 0.0,
        unclipped: 0.0,
        response: 1.0,
    };
}
