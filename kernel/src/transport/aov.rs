//! Surface features of a camera sample (arbitrary output variables): albedo, normal, depth, position and texture coordinates
//! of the first surface.
//!
//! A mask is passed at random with the probability of its null lobe; mirrors and glass are not followed. A ray that leaves
//! the scene returns zeros with `hit` false.

use super::pixel::camera_ray;
use crate::bsdf::{Bsdf, mode};
use crate::math::{Ray, Rgb, luminance};
use crate::path::visibility::{MAX_NULL_CROSSINGS, pass_through};
use crate::sampler::Sampler;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{SceneView, Traverse};
use glam::{Vec2, Vec3};

/// Features of the first surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceFeatures {
    /// Directional albedo of the material towards the sensor, approximate for rough models.
    pub albedo: Rgb,
    /// Shading normal in world space.
    pub normal: Vec3,
    /// Distance from the ray's origin.
    pub depth: f32,
    /// World position.
    pub position: Vec3,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Whether there is a surface.
    pub hit: bool,
}

impl SurfaceFeatures {
    /// The ray left the scene.
    pub const MISS: SurfaceFeatures = SurfaceFeatures {
        albedo: Vec3::ZERO,
        normal: Vec3::ZERO,
        depth: 0.0,
        position: Vec3::ZERO,
        uv: Vec2::ZERO,
        hit: false,
    };
}

/// Features along the sensor ray that [`super::sample_pixel`] traces for the same sampler state, and that sample's
/// reconstruction weight.
pub fn sample_pixel<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    sampler: &mut S,
    pixel: [u32; 2],
) -> (SurfaceFeatures, f32) {
    let sample = camera_ray(&view.tables, sampler, pixel);
    (features(view, sampler, &sample.ray), sample.weight)
}

/// Features of the first surface along `ray`.
pub fn features<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    sampler: &mut S,
    ray: &Ray,
) -> SurfaceFeatures {
    let origin = ray.origin;
    let mut ray = *ray;
    let mut crossings = 0;
    while crossings <= MAX_NULL_CROSSINGS {
        crossings += 1;
        let hit = view.traverse.closest_hit(&ray);
        if !hit.is_hit() {
            break;
        }
        let point = surface_with::<{ detail::TANGENTS }>(&view.tables, &ray, &hit);
        let wi = point.frame.to_local(-ray.direction);
        let bsdf = Bsdf::at(&view.tables, &point, wi, mode::RADIANCE);
        let pass = luminance(bsdf.null_transmittance());
        if pass > 0.0 && sampler.next_1d() < pass {
            pass_through(&mut ray, &point);
            continue;
        }
        return SurfaceFeatures {
            // The lobes carry the opacity, which the random choice above has already applied.
            albedo: bsdf.albedo(view.tables.data, wi) / (1.0 - pass).max(1e-6),
            normal: point.frame.n,
            depth: (point.position - origin).length(),
            position: point.position,
            uv: point.uv,
            hit: true,
        };
    }
    SurfaceFeatures::MISS
}
