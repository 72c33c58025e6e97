//! What light is left along a segment: zero behind a surface, the weight of the null lobes through masks.
//!
//! Masked surfaces let a shadow ray pass with the weight of their null lobes, so light samples see through leaves and
//! the multiple importance sampling of a path that runs straight through a mask needs the density of its last real
//! scattering only.

use crate::bsdf::{Bsdf, mode};
use crate::math::{Ray, Rgb};
use crate::scene::emitter::DirectSample;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{SceneView, SurfacePoint, Traverse, material_flag, scene_flag};

/// Most masks that one straight line may pass before it counts as blocked.
pub const MAX_NULL_CROSSINGS: u32 = 64;

/// Transmittance in [0, 1] per channel from `point` to a sampled light.
pub fn transmittance<T: Traverse>(
    view: &SceneView<'_, T>,
    point: &SurfacePoint,
    light: &DirectSample,
) -> Rgb {
    let mut ray = if light.distance < f32::MAX {
        point.segment_to(light.target)
    } else {
        point.spawn(light.direction)
    };
    if view.tables.info.flags & scene_flag::HAS_NULL == 0 {
        return if view.traverse.is_occluded(&ray) {
            Rgb::ZERO
        } else {
            Rgb::ONE
        };
    }
    let mut remaining = Rgb::ONE;
    let mut crossings = 0;
    while crossings < MAX_NULL_CROSSINGS {
        let hit = view.traverse.closest_hit(&ray);
        if !hit.is_hit() {
            return remaining;
        }
        let mask = surface_with::<{ detail::TANGENTS }>(&view.tables, &ray, &hit);
        let material = view.tables.materials[mask.material as usize];
        if material.flags & material_flag::HAS_NULL == 0 {
            return Rgb::ZERO;
        }
        let wi = mask.frame.to_local(-ray.direction);
        let bsdf = Bsdf::at(&view.tables, &mask, wi, mode::RADIANCE);
        remaining *= bsdf.null_transmittance();
        if !(remaining.max_element() > 0.0) {
            return Rgb::ZERO;
        }
        pass_through(&mut ray, &mask);
        if ray.t_max <= 0.0 {
            return remaining;
        }
        crossings += 1;
    }
    Rgb::ZERO
}

/// Moves the ray's origin behind `point` and keeps its end.
#[inline]
pub fn pass_through(ray: &mut Ray, point: &SurfacePoint) {
    let next = point.offset_position(ray.direction);
    if ray.t_max < f32::MAX {
        ray.t_max -= (next - ray.origin).dot(ray.direction);
    }
    ray.t_min = 0.0;
    ray.origin = next;
}
