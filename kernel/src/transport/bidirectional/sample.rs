//! One sample by itself: both walks, ray by ray.

use super::algorithm::{Bidirectional, ConnectedPoints, LightSubpath};
use super::reuse::SharedWalks;
use super::vertex_store::VertexStore;
use crate::path::rules::step;
use crate::path::visibility::contribution_transmittance;
use crate::path::{Contribution, Contributions, Interaction, PathRules, Walk};
use crate::sampler::Sampler;
use crate::scene::camera::CameraSample;
use crate::scene::emitter::emission::EmissionSample;
use crate::scene::{NONE, SceneView, Traverse};
use crate::transport::settings::IntegratorSettings;
use core::cell::RefCell;
use glam::Vec3;

/// An observer of both walks of a sample and of its contributions, which come before their visibility is known.
pub trait PathObserver: Contributions {
    /// A light walk begins.
    fn light_walk_starts(&mut self, start: &EmissionSample);

    /// A walk has scattered at a vertex and is on its next ray; whether it shall go on.
    fn scattered(&mut self, walk: &Walk, at: &Interaction<'_>) -> bool;

    /// The camera walk has met light of an emitter.
    fn emitter_hit(&mut self, contribution: Contribution, emitter: u32);

    /// The camera walk has arrived where photons may be merged with it.
    fn camera_vertex(&mut self, walk: &Walk, at: &Interaction<'_>);
}

/// One sample: `add` takes what each strategy finds, nothing where it lies in shadow, splats and what belongs to the pixel of
/// `seen` ([`Contribution::is_splat`]), the latter without a film position.
pub fn sample<T: Traverse, S: Sampler, V: VertexStore>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    light_sampler: &mut S,
    camera_sampler: &mut S,
    seen: &CameraSample,
    store: &mut V,
    add: impl FnMut(Contribution),
) {
    let rules = settings.rules;
    let mut observer = Unshadowed::new(view, rules, add);
    let algorithm = Bidirectional::new(&view.tables, settings);
    sample_observed(
        view,
        &algorithm,
        light_sampler,
        camera_sampler,
        seen,
        store,
        &mut observer,
    );
}

/// [`sample`] for an observer.
pub fn sample_observed<T: Traverse, S: Sampler, V: VertexStore>(
    view: &SceneView<'_, T>,
    algorithm: &Bidirectional<'_>,
    light_sampler: &mut S,
    camera_sampler: &mut S,
    seen: &CameraSample,
    store: &mut V,
    observer: &mut impl PathObserver,
) {
    let rules = algorithm.connector.rules;
    let connects = algorithm.connector.strategies.heuristic.connects;
    let observer = RefCell::new(observer);
    let mut points = ConnectedPoints::NONE;
    let mut last = NONE;
    // Where nothing is connected, photons are all the light there is.
    let start = if connects {
        algorithm.emit(light_sampler)
    } else {
        EmissionSample::NONE
    };
    if start.is_some() && rules.max_depth > 0 {
        observer.borrow_mut().light_walk_starts(&start);
        let met = algorithm.start(&start, light_sampler);
        if met.is_some() {
            observer.borrow_mut().add(met);
        }
        let mut walk = Walk::from_emitter(&start);
        let mut next = step::TRACE;
        while next == step::TRACE {
            light_sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
            let hit = view.traverse.closest_hit(&walk.subpath.ray);
            let (depth, direction) = (walk.subpath.depth, walk.subpath.ray.direction);
            next = algorithm.light_bounce(
                &mut walk,
                light_sampler,
                &hit,
                &mut points.arrived,
                store,
                &mut last,
                SharedObserver(&observer),
            );
            let has_scattered = next == step::TRACE && walk.subpath.depth > depth;
            let mut observer = observer.borrow_mut();
            if has_scattered && !observer.scattered(&walk, &points.arrived.interaction(direction)) {
                next = step::END;
            }
        }
    }
    if !algorithm.has_camera_walks || rules.max_depth == 0 {
        return;
    }
    let light = LightSubpath {
        store: &*store,
        last,
        start: &start,
        shared: SharedWalks::NONE,
    };
    let mut walk = Walk::from_sensor(seen);
    let mut next = step::TRACE;
    while next == step::TRACE {
        camera_sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
        let hit = view.traverse.closest_hit(&walk.subpath.ray);
        let (depth, direction) = (walk.subpath.depth, walk.subpath.ray.direction);
        let (found, after) = algorithm.camera_bounce_merging(
            &mut walk,
            camera_sampler,
            &hit,
            &mut points,
            &light,
            |walk, at| {
                observer.borrow_mut().camera_vertex(walk, at);
                Vec3::ZERO
            },
            SharedObserver(&observer),
        );
        let mut observer = observer.borrow_mut();
        if found.max_element() > 0.0 {
            let (met, emitter) =
                algorithm
                    .connector
                    .emitter_hit(found, depth, &hit, &points.arrived);
            observer.emitter_hit(met, emitter);
        }
        next = after;
        let has_scattered = next == step::TRACE && walk.subpath.depth > depth;
        if has_scattered && !observer.scattered(&walk, &points.arrived.interaction(direction)) {
            next = step::END;
        }
    }
}

/// An observer that a bounce shares with the walk: it takes contributions while it also follows the walk.
pub struct SharedObserver<'a, 'b, W>(pub &'a RefCell<&'b mut W>);

impl<W: Contributions> Contributions for SharedObserver<'_, '_, W> {
    #[inline]
    fn add(&mut self, contribution: Contribution) {
        self.0.borrow_mut().add(contribution);
    }

    #[inline]
    fn add_at(&mut self, contribution: Contribution, at: &Interaction<'_>) {
        self.0.borrow_mut().add_at(contribution, at);
    }

    #[inline]
    fn add_between(
        &mut self,
        contribution: Contribution,
        light: &Interaction<'_>,
        camera: &Interaction<'_>,
    ) {
        self.0.borrow_mut().add_between(contribution, light, camera);
    }
}

/// Passes on what does not lie in shadow, and observes nothing else.
pub struct Unshadowed<'a, 'b, T: Traverse, F> {
    view: &'a SceneView<'b, T>,
    rules: PathRules,
    add: F,
}

impl<'a, 'b, T: Traverse, F: FnMut(Contribution)> Unshadowed<'a, 'b, T, F> {
    /// By the rules of the algorithm; `add` takes what is left of each contribution.
    pub fn new(view: &'a SceneView<'b, T>, rules: PathRules, add: F) -> Unshadowed<'a, 'b, T, F> {
        Unshadowed { view, rules, add }
    }
}

impl<T: Traverse, F: FnMut(Contribution)> Contributions for Unshadowed<'_, '_, T, F> {
    #[inline]
    fn add(&mut self, mut contribution: Contribution) {
        contribution.value *= contribution_transmittance(self.view, &self.rules, &contribution);
        (self.add)(contribution);
    }
}

impl<T: Traverse, F: FnMut(Contribution)> PathObserver for Unshadowed<'_, '_, T, F> {
    fn light_walk_starts(&mut self, _: &EmissionSample) {}

    fn scattered(&mut self, _: &Walk, _: &Interaction<'_>) -> bool {
        true
    }

    #[inline]
    fn emitter_hit(&mut self, contribution: Contribution, _: u32) {
        (self.add)(contribution);
    }

    fn camera_vertex(&mut self, _: &Walk, _: &Interaction<'_>) {}
}
