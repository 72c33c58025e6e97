//! Ambient occlusion: the cosine-weighted part of the hemisphere that is free of geometry up to a distance.
//!
//! A(x) = 1/pi int V(x, w, d) cos dw over the hemisphere of the shading normal on the viewer's side (Zhukov et al. 1998).
//! With cosine-weighted sampling the estimator is the fraction of unoccluded rays. A point without occluders has the value 1,
//! a closed corner tends to 0; camera rays that leave the scene have the value 0, so that silhouettes are visible.

use super::settings::IntegratorSettings;
use crate::math::warp::square_to_cosine_hemisphere;
use crate::math::{Ray, Rgb};
use crate::sampler::Sampler;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{SceneView, Traverse};

/// Accessibility of the point seen along `ray`, in every channel.
pub fn radiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: &mut S,
    ray: &Ray,
) -> Rgb {
    let hit = view.traverse.closest_hit(ray);
    if !hit.is_hit() || settings.occlusion.samples == 0 {
        return Rgb::ZERO;
    }
    let point = surface_with::<{ detail::TANGENTS }>(&view.tables, ray, &hit);
    let side = if point.frame.n.dot(ray.direction) > 0.0 {
        -1.0
    } else {
        1.0
    };
    let mut open = 0.0;
    for _ in 0..settings.occlusion.samples {
        let local = square_to_cosine_hemisphere(sampler.next_2d());
        let direction = point.frame.to_world(local * side);
        // A shading normal may point a ray into its own surface; that part of the hemisphere is closed.
        if point.geometric_normal.dot(direction) * point.geometric_normal.dot(ray.direction) >= 0.0
        {
            continue;
        }
        let mut probe = point.spawn(direction);
        probe.t_max = settings.occlusion.distance * view.tables.info.radius;
        if !view.traverse.is_occluded(&probe) {
            open += 1.0;
        }
    }
    Rgb::splat(open / settings.occlusion.samples as f32)
}
