//! What light is left along a segment: zero behind a surface, the weight of the null lobes through masks.
//!
//! Masked surfaces let a shadow ray pass with the weight of their null lobes, so light samples see through leaves and
//! the multiple importance sampling of a path that runs straight through a mask needs the density of its last real
//! scattering only.

use crate::bsdf::{Bsdf, mode};
use crate::math::{Ray, Rgb};
use crate::scene::intersect::offset_origin;
use crate::scene::surface::surface_at;
use crate::scene::{SceneView, Traverse, material_flag, scene_flag};
use glam::Vec3;

/// Most masks that one straight segment may pass before it counts as blocked.
pub const MAX_NULL_CROSSINGS: u32 = 64;

/// Part of the unit segment's end that a shadow ray leaves out, so that it does not meet the light itself.
const END_TOLERANCE: f32 = 1e-4;

/// Transmittance in [0, 1] per channel from `origin` (already offset from its surface) over `distance` along the unit
/// `direction`; an infinite light has a distance of [`f32::MAX`].
pub fn transmittance<T: Traverse>(
    view: &SceneView<'_, T>,
    origin: Vec3,
    direction: Vec3,
    distance: f32,
) -> Rgb {
    let mut ray = Ray::new(origin, direction);
    if distance < f32::MAX {
        ray.t_max = distance * (1.0 - END_TOLERANCE);
    }
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
        let point = surface_at(&view.tables, &ray, &hit);
        let material = view.tables.materials[point.material as usize];
        if material.flags & material_flag::HAS_NULL == 0 {
            return Rgb::ZERO;
        }
        let wi = point.frame.to_local(-direction);
        let bsdf = Bsdf::at(&view.tables, &point, wi, mode::RADIANCE);
        remaining *= bsdf.null_transmittance();
        if remaining.max_element() <= 0.0 {
            return Rgb::ZERO;
        }
        let next = offset_origin(point.position, point.geometric_normal, direction);
        let advanced = (next - ray.origin).dot(direction);
        if ray.t_max < f32::MAX {
            ray.t_max -= advanced;
        }
        if ray.t_max <= 0.0 {
            return remaining;
        }
        ray.origin = next;
        crossings += 1;
    }
    Rgb::ZERO
}
