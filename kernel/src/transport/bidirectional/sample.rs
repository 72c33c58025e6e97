//! One sample by itself: both walks, ray by ray.

use super::algorithm::{Bidirectional, ConnectedPoints, LightSubpath, VertexStore};
use crate::path::rules::step;
use crate::path::visibility::contribution_transmittance;
use crate::path::{Contribution, Walk};
use crate::sampler::Sampler;
use crate::scene::camera::CameraSample;
use crate::scene::{NONE, SceneView, Traverse};
use crate::transport::settings::IntegratorSettings;

/// One sample: `add` takes what each strategy finds, nothing where it lies in shadow, splats and what belongs to the pixel of
/// `seen` ([`Contribution::is_splat`]), the latter without a film position.
pub fn sample<T: Traverse, S: Sampler, V: VertexStore>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    light_sampler: &mut S,
    camera_sampler: &mut S,
    seen: &CameraSample,
    store: &mut V,
    mut add: impl FnMut(Contribution),
) {
    let algorithm = Bidirectional::new(&view.tables, settings);
    let rules = settings.rules;
    // Not one closure over `add`, which what a camera walk meets itself needs as well.
    let unshadowed = |mut contribution: Contribution| {
        contribution.value *= contribution_transmittance(view, &rules, &contribution);
        contribution
    };
    let mut points = ConnectedPoints::NONE;
    let mut last = NONE;
    let start = algorithm.emit(light_sampler);
    if start.is_some() && rules.max_depth > 0 {
        let own = algorithm.start(&start, light_sampler);
        if own.is_some() {
            add(unshadowed(own));
        }
        let mut walk = Walk::from_emitter(&start);
        let mut next = step::TRACE;
        while next == step::TRACE {
            light_sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
            let hit = view.traverse.closest_hit(&walk.subpath.ray);
            next = algorithm.light_bounce(
                &mut walk,
                light_sampler,
                &hit,
                &mut points.own,
                store,
                &mut last,
                |contribution| add(unshadowed(contribution)),
            );
        }
    }
    if !algorithm.has_camera_walks || rules.max_depth == 0 {
        return;
    }
    let light = LightSubpath {
        store: &*store,
        last,
        start: &start,
    };
    let mut walk = Walk::from_sensor(seen);
    let mut next = step::TRACE;
    while next == step::TRACE {
        camera_sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
        let hit = view.traverse.closest_hit(&walk.subpath.ray);
        let t = walk.subpath.depth + 2;
        let (found, after) = algorithm.camera_bounce(
            &mut walk,
            camera_sampler,
            &hit,
            &mut points,
            &light,
            |contribution| add(unshadowed(contribution)),
        );
        add(Contribution {
            value: found,
            t,
            ..Contribution::NONE
        });
        next = after;
    }
}
