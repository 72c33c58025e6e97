//! What light is left along a segment: zero behind a surface, the weight of the null lobes through masks.
//!
//! Masked surfaces let a shadow ray pass with the weight of their null lobes, so light samples see through leaves and
//! the multiple importance sampling of a path that runs straight through a mask needs the density of its last real
//! scattering only.

use super::connection::Contribution;
use super::rules::PathRules;
use crate::bsdf::null_transmittance;
use crate::math::{Ray, Rgb};
use crate::scene::surface::{detail, surface_with};
use crate::scene::{
    NONE, SceneView, SurfacePoint, Tables, Traverse, features, lobe_kind, material_flag, scene_flag,
};

/// Most masks that one straight line may pass before it counts as blocked: more than any scene has in a row. It only bounds
/// the time of a line that cannot leave a place where numbers are too coarse to move it on.
pub const MAX_NULL_CROSSINGS: u32 = 1 << 16;

/// Whether some light passes straight through the surface.
#[inline]
pub fn has_masks(tables: &Tables<'_>, point: &SurfacePoint) -> bool {
    tables.has(features::lobe(lobe_kind::NULL))
        && point.material != NONE
        && tables.materials[point.material as usize].flags & material_flag::HAS_NULL != 0
}

/// Transmittance in [0, 1] per channel along a segment, as that of [`super::connection::Connection`].
pub fn transmittance<T: Traverse>(view: &SceneView<'_, T>, segment: Ray) -> Rgb {
    if !has_null(view) {
        return if view.traverse.is_occluded(&segment) {
            Rgb::ZERO
        } else {
            Rgb::ONE
        };
    }
    transmittance_in_steps(view, segment, false)
}

/// [`transmittance`] as if emitters were not there.
pub fn transmittance_past_emitters<T: Traverse>(view: &SceneView<'_, T>, segment: Ray) -> Rgb {
    transmittance_in_steps(view, segment, true)
}

#[inline]
fn has_null<T: Traverse>(view: &SceneView<'_, T>) -> bool {
    let has_masks = view.tables.has(features::lobe(lobe_kind::NULL));
    has_masks && view.tables.info.flags & scene_flag::HAS_NULL != 0
}

/// Surface by surface.
fn transmittance_in_steps<T: Traverse>(
    view: &SceneView<'_, T>,
    segment: Ray,
    past_emitters: bool,
) -> Rgb {
    let mut ray = segment;
    let mut remaining = Rgb::ONE;
    let mut crossings = 0;
    while crossings < MAX_NULL_CROSSINGS {
        let hit = view.traverse.closest_hit(&ray);
        if !hit.is_hit() {
            return remaining;
        }
        let mask = surface_with::<{ detail::NORMALS }>(&view.tables, &ray, &hit);
        if !(past_emitters && mask.emitter != NONE) {
            if !has_masks(&view.tables, &mask) {
                return Rgb::ZERO;
            }
            remaining *= null_transmittance(&view.tables, &mask);
        }
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

/// What is left of a contribution: the transmittance along its segment, which for splats passes emitters where the sensor
/// does not see them, and is one where a walk has met the lens itself.
pub fn contribution_transmittance<T: Traverse>(
    view: &SceneView<'_, T>,
    rules: &PathRules,
    contribution: &Contribution,
) -> Rgb {
    if contribution.t == 0 {
        return Rgb::ONE;
    }
    if contribution.t > 1 || rules.hide_emitters == 0 {
        return transmittance(view, contribution.ray);
    }
    transmittance_past_emitters(view, contribution.ray)
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
