//! Bidirectional path tracing, light tracing and vertex merging with edits.
//!
//! Both walks guess what edits of the other's flow have done ([`IncomingDirection::guess`]) and let those of their own turn the directions that
//! they sample. A connection is made once for every pair of labels that its two ends allow, each a path of its own with its own
//! densities and weight; the states of the walks say which share of it is selected so. Light walks do not meet lenses (t = 0):
//! what the sensor sees of a vertex is not turned.

use super::bounce::{arrive, meet_emitter, scatter, towards};
use super::photons::EditedPhotons;
use crate::path::retarget_states::{EditStates, Edits};
use crate::path::retargeted::{IncomingDirection, Retargeted};
use crate::path::rules::step;
use crate::path::{Interaction, ShadingPoint, Walk};
use crate::sampler::Sampler;
use crate::scene::camera::CameraSample;
use crate::scene::emitter::emission::EmissionSample;
use crate::scene::{NONE, SceneView, Traverse};
use crate::transport::bidirectional::{Bidirectional, PathObserver, VertexStore};
use arrayvec::ArrayVec;

/// Vertices of a light walk that are connected; it ends where there is no more space.
const MAX_VERTICES: usize = 64;

/// What edits need to know of the vertices of a light walk that are kept, in their order.
pub(super) struct LightVertices {
    /// The index of the first in the store.
    pub first: u32,
    /// The states before each.
    pub states: ArrayVec<EditStates, MAX_VERTICES>,
    /// How the walk has come to each.
    pub incoming: ArrayVec<IncomingDirection, MAX_VERTICES>,
}

/// A sample of both walks with edits.
pub struct EditedSample<'a, 'b, T: Traverse> {
    view: &'a SceneView<'b, T>,
    pub(super) algorithm: Bidirectional<'a>,
    pub(super) edits: &'a Edits<'a>,
    pub(super) photons: Option<&'a EditedPhotons<'a>>,
    pub(super) light: LightVertices,
    /// The index of the light walk's last vertex.
    pub(super) last: u32,
    /// Where the light walk started.
    pub(super) start: EmissionSample,
}

impl<'a, 'b, T: Traverse> EditedSample<'a, 'b, T> {
    /// Before its walks, with photons to merge if there are any.
    pub fn new(
        view: &'a SceneView<'b, T>,
        algorithm: &Bidirectional<'a>,
        edits: &'a Edits<'a>,
        photons: Option<&'a EditedPhotons<'a>>,
    ) -> EditedSample<'a, 'b, T> {
        let mut algorithm = *algorithm;
        algorithm.connector.strategies.meets_lens = false;
        EditedSample {
            view,
            algorithm,
            edits,
            photons,
            light: LightVertices {
                first: NONE,
                states: ArrayVec::new(),
                incoming: ArrayVec::new(),
            },
            last: NONE,
            start: EmissionSample::NONE,
        }
    }
}

impl<T: Traverse> EditedSample<'_, '_, T> {
    /// [`crate::transport::bidirectional::sample_observed`] with edits. The observer is not asked for photons.
    pub fn sample_observed<S: Sampler, V: VertexStore>(
        mut self,
        light_sampler: &mut S,
        camera_sampler: &mut S,
        seen: &CameraSample,
        store: &mut V,
        observer: &mut impl PathObserver,
    ) {
        let connector = &self.algorithm.connector;
        if connector.rules.max_depth == 0 {
            return;
        }
        if connector.strategies.heuristic.connects {
            self.start = self.algorithm.emit(light_sampler);
        }
        if self.start.is_some() {
            self.trace_light(light_sampler, store, observer);
        }
        if self.algorithm.has_camera_walks {
            self.trace_camera(camera_sampler, seen, store, observer);
        }
    }

    fn trace_light<S: Sampler, V: VertexStore>(
        &mut self,
        sampler: &mut S,
        store: &mut V,
        observer: &mut impl PathObserver,
    ) {
        let edits = self.edits;
        let algorithm = self.algorithm;
        let connector = &algorithm.connector;
        observer.light_walk_starts(&self.start);
        let seen = algorithm.start(&self.start, sampler);
        if seen.is_some() {
            observer.add(seen);
        }
        let mut states = EditStates::at_emitter(edits, self.start.emitter);
        let mut walk = Walk::from_emitter(&self.start);
        let mut site = ShadingPoint::NONE;
        let mut next = step::TRACE;
        while next == step::TRACE {
            sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
            let hit = self.view.traverse.closest_hit(&walk.subpath.ray);
            let (depth, direction) = (walk.subpath.depth, walk.subpath.ray.direction);
            (_, next) = connector.arrive(&mut walk, &hit, &mut site);
            if next != step::SCATTER {
                continue;
            }
            let incoming = arrive(connector, edits, &states, &walk, &mut site, sampler);
            // No edit turns what the sensor sees of a surface.
            let seen_directly = Retargeted {
                is_free: true,
                ..Retargeted::new(edits, &states, incoming)
            };
            let at = site.interaction(direction).retargeted(&seen_directly);
            if at.is_connectable() {
                if connector.strategies.light_image {
                    let u_lens = algorithm.lens_numbers(sampler);
                    let beta = walk.subpath.throughput;
                    let mut seen = connector.to_lens(beta, walk.arrived, depth + 1, &at, u_lens);
                    if seen.is_some() {
                        let after = towards(connector, &at, &seen_directly, seen.ray.direction);
                        seen.value *= after.reach_sensor(edits);
                    }
                    if seen.is_some() {
                        observer.add_at(seen, &at);
                    }
                }
                if algorithm.has_camera_walks {
                    let before = self.last;
                    self.last = store.push(&walk.vertex(&hit, &at, self.last));
                    let has_room = self.last != NONE
                        && self.light.states.try_push(states).is_ok()
                        && self.light.incoming.try_push(incoming).is_ok();
                    if !has_room {
                        // What is kept no more is not connected.
                        self.last = before;
                        return;
                    }
                    self.light.first = self.light.first.min(self.last);
                }
            }
            let retargeted = Retargeted::new(edits, &states, incoming);
            let at = site.interaction(direction).retargeted(&retargeted);
            let watch = |walk: &Walk, at: &Interaction<'_>| observer.scattered(walk, at);
            (next, states) = scatter(connector, &mut walk, &at, &retargeted, sampler, watch);
        }
    }

    fn trace_camera<S: Sampler, V: VertexStore>(
        &mut self,
        sampler: &mut S,
        seen: &CameraSample,
        store: &V,
        observer: &mut impl PathObserver,
    ) {
        let edits = self.edits;
        let algorithm = self.algorithm;
        let connector = &algorithm.connector;
        let mut states = EditStates::at_sensor(edits);
        let mut walk = Walk::from_sensor(seen);
        let mut site = ShadingPoint::NONE;
        let mut light_site = ShadingPoint::NONE;
        let mut next = step::TRACE;
        while next == step::TRACE {
            sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
            let hit = self.view.traverse.closest_hit(&walk.subpath.ray);
            let direction = walk.subpath.ray.direction;
            next = meet_emitter(
                connector, edits, &states, &mut walk, &hit, &mut site, observer,
            );
            if next != step::SCATTER {
                continue;
            }
            let incoming = arrive(connector, edits, &states, &walk, &mut site, sampler);
            let retargeted = Retargeted::new(edits, &states, incoming);
            let at = site.interaction(direction).retargeted(&retargeted);
            if at.is_connectable() && connector.strategies.shows_all() {
                self.merge(&walk, &at, &retargeted, observer);
            }
            if at.is_connectable() && connector.strategies.heuristic.connects {
                self.light_up(&walk, &at, &retargeted, sampler, observer);
                self.connect(&walk, &at, &retargeted, &mut light_site, store, observer);
            }
            let watch = |walk: &Walk, at: &Interaction<'_>| observer.scattered(walk, at);
            (next, states) = scatter(connector, &mut walk, &at, &retargeted, sampler, watch);
        }
    }
}
