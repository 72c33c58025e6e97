//! Transmittance along a segment: zero if a surface occludes it, the product of the null lobes' weights through masks.
//!
//! A shadow ray passes a masked surface with the weight of its null lobe. So light samples reach through foliage, and the
//! multiple importance sampling of a path that runs straight through masks needs only the density of the last vertex at
//! which it really scattered.

use super::contribution::Contribution;
use super::rules::PathRules;
use crate::bsdf::null_transmittance;
use crate::math::{Ray, Rgb};
use crate::scene::surface::{detail, surface_with};
use crate::scene::{
    NONE, SceneView, SurfacePoint, Tables, Traverse, features, lobe_kind, material_flag, scene_flag,
};

/// Most masks that one segment may cross before it counts as occluded: more than any scene has in a row. It bounds the time
/// of a ray that makes no progress because its offset is below the resolution of floats at that distance.
pub const MAX_NULL_CROSSINGS: u32 = 1 << 16;

/// Whether the surface's material has a null lobe.
#[inline]
pub fn has_masks(tables: &Tables<'_>, point: &SurfacePoint) -> bool {
    tables.has(features::lobe(lobe_kind::NULL))
        && point.material != NONE
        && tables.materials[point.material as usize].flags & material_flag::HAS_NULL != 0
}

/// Transmittance in [0, 1] per channel along a segment, such as [`Contribution::ray`].
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

/// [`transmittance`] with emitters taken as fully transparent.
pub fn transmittance_past_emitters<T: Traverse>(view: &SceneView<'_, T>, segment: Ray) -> Rgb {
    transmittance_in_steps(view, segment, true)
}

#[inline]
fn has_null<T: Traverse>(view: &SceneView<'_, T>) -> bool {
    let has_masks = view.tables.has(features::lobe(lobe_kind::NULL));
    has_masks && view.tables.info.flags & scene_flag::HAS_NULL != 0
}

/// Finds the surfaces along the segment one after another and multiplies what they transmit.
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

/// The transmittance along a contribution's segment. For splats it ignores emitters that are hidden from the sensor; where a
/// light walk has hit the lens (t = 0) it is one, because the walk's own ray has found that segment unoccluded.
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

/// Moves the ray's origin to the other side of the surface at `point`; the end of the ray stays where it is.
#[inline]
pub fn pass_through(ray: &mut Ray, point: &SurfacePoint) {
    let next = point.offset_position(ray.direction);
    if ray.t_max < f32::MAX {
        ray.t_max -= (next - ray.origin).dot(ray.direction);
    }
    ray.t_min = 0.0;
    ray.origin = next;
}
