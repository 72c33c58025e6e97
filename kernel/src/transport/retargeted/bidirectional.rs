//! Bidirectional path tracing, light tracing and vertex merging with edits.
//!
//! Both walks guess what edits of the other's flow have done ([`Arrival::guess`]) and let those of their own turn the directions that
//! they sample. A connection is made once for every pair of labels that its two ends allow, each a path of its own with its own
//! densities and weight; the states of the walks say which share of it is selected so. Light walks do not meet lenses (t = 0):
//! what the sensor sees of a vertex is not turned.

use crate::bsdf::mode;
use crate::math::{float, vec3};
use crate::path::retarget::MAX_EDITS;
use crate::path::retarget_states::{EditStates, Edits};
use crate::path::retargeted::{Arrival, Retargeted};
use crate::path::rules::step;
use crate::path::walk::LABEL_SHIFT;
use crate::path::{Connector, Contribution, Interaction, LightEnd, Scattered, ShadingPoint, Walk};
use crate::regularize::mollifier;
use crate::sampler::Sampler;
use crate::scene::camera::CameraSample;
use crate::scene::emitter::emission::EmissionSample;
use crate::scene::emitter::sample_direct_with_point;
use crate::scene::{Hit, NONE, SceneView, SurfacePoint, Traverse, camera};
use crate::transport::bidirectional::{Bidirectional, VertexStore, Watcher};
use crate::transport::photon::estimate::{KERNEL, for_photons_within, incidence};
use crate::transport::photon::merging::{PassPhotons, merging_weight};
use crate::transport::photon::tracing::{PhotonStore, PhotonTracer};
use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};

/// Vertices of a light walk that are connected; it ends where there is no more room.
const MAX_VERTICES: usize = 64;

/// What edits need to know of the vertices of a light walk that are kept, in their order.
struct LightVertices {
    /// The index of the first in the store.
    first: u32,
    states: ArrayVec<EditStates, MAX_VERTICES>,
    arrivals: ArrayVec<Arrival, MAX_VERTICES>,
}

/// The photons of a pass, and the states of their walks before they arrived.
#[derive(Clone, Copy)]
pub struct EditedPhotons<'a> {
    /// The photons.
    pub photons: PassPhotons<'a>,
    /// By [`crate::transport::photon::cache::Photon::beside`].
    pub states: &'a [EditStates],
}

/// The sample of both walks of [`crate::transport::bidirectional::sample_watched`] with edits, and photons to merge if there are
/// any. The watcher is not asked for photons.
pub fn sample_watched<T: Traverse, S: Sampler, V: VertexStore>(
    view: &SceneView<'_, T>,
    algorithm: &Bidirectional<'_>,
    edits: &Edits<'_>,
    photons: Option<&EditedPhotons<'_>>,
    light_sampler: &mut S,
    camera_sampler: &mut S,
    seen: &CameraSample,
    store: &mut V,
    watcher: &mut impl Watcher,
) {
    let mut edited = Edited {
        view,
        algorithm: *algorithm,
        edits,
        photons,
        light: LightVertices {
            first: NONE,
            states: ArrayVec::new(),
            arrivals: ArrayVec::new(),
        },
        last: NONE,
        start: EmissionSample::NONE,
    };
    edited.algorithm.connector.strategies.meets_lens = false;
    let connector = &edited.algorithm.connector;
    if connector.rules.max_depth == 0 {
        return;
    }
    if connector.strategies.heuristic.connects {
        edited.start = algorithm.emit(light_sampler);
    }
    if edited.start.is_some() {
        edited.trace_light(light_sampler, store, watcher);
    }
    if algorithm.has_camera_walks {
        edited.trace_camera(camera_sampler, seen, store, watcher);
    }
}

/// Where photons are kept with the states of their walks.
pub trait EditedStore: PhotonStore {
    /// The states before the vertex whose photons come next.
    fn set_states(&mut self, states: &EditStates);
}

/// [`PhotonTracer::light_bounce`] with edits.
pub fn light_bounce<S: Sampler, P: EditedStore>(
    tracer: &PhotonTracer<'_>,
    edits: &Edits<'_>,
    walk: &mut Walk,
    states: &mut EditStates,
    sampler: &mut S,
    hit: &Hit,
    site: &mut ShadingPoint,
    store: &mut P,
) -> u32 {
    let connector = &tracer.connector;
    let (depth, direction) = (walk.subpath.depth, walk.subpath.ray.direction);
    let (_, next) = connector.arrive(walk, hit, site);
    if next != step::SCATTER {
        return next;
    }
    store.set_states(states);
    tracer.leave(walk, &site.interaction(direction), store);
    let arrival = arrive(connector, edits, states, walk, site, sampler);
    let own = Retargeted {
        edits,
        states,
        arrival,
        label: 0,
        is_free: false,
    };
    let at = site.interaction(direction).retargeted(&own);
    let h = connector.heuristic_at(at.point.position);
    let next = walk.scatter(connector.tables, &connector.rules, h, sampler, &at);
    if next == step::TRACE && walk.subpath.depth > depth {
        let after = scattered(connector, walk, &at, &own);
        if after.is_none() {
            return step::END;
        }
        *states = after;
    }
    next
}

struct Edited<'a, 'b, T: Traverse> {
    view: &'a SceneView<'b, T>,
    algorithm: Bidirectional<'a>,
    edits: &'a Edits<'a>,
    photons: Option<&'a EditedPhotons<'a>>,
    light: LightVertices,
    last: u32,
    start: EmissionSample,
}

/// What edits do at the vertex where a walk has arrived, once its surface has been looked up.
fn arrive<S: Sampler>(
    connector: &Connector<'_>,
    edits: &Edits<'_>,
    states: &EditStates,
    walk: &Walk,
    site: &mut ShadingPoint,
    sampler: &mut S,
) -> Arrival {
    let back = -walk.subpath.ray.direction;
    if walk.mode == mode::RADIANCE && walk.subpath.depth == 0 {
        return Arrival::straight(back);
    }
    let (point, bsdf) = (&site.point, &site.bsdf);
    let arrival = Arrival::guess(edits, states, point, bsdf, back, || sampler.next_1d());
    if arrival.choice.label != 0 {
        site.look_up(connector.tables, -arrival.back);
    }
    arrival
}

/// The states behind the vertex that a walk has scattered at.
fn scattered(
    connector: &Connector<'_>,
    walk: &Walk,
    at: &Interaction<'_>,
    own: &Retargeted<'_>,
) -> EditStates {
    let own = Retargeted {
        label: walk.event >> LABEL_SHIFT,
        ..*own
    };
    let at = at.retargeted(&own);
    let direction = walk.subpath.ray.direction;
    let wo = at.effective(direction);
    let happened = Scattered::sampled(at.bsdf, connector.tables.data, at.wi, wo, walk.event);
    own.after(at.point, happened, at.point.frame.to_world(wo))
}

/// The states behind a vertex in a path that goes on along a direction.
fn towards(
    connector: &Connector<'_>,
    at: &Interaction<'_>,
    own: &Retargeted<'_>,
    direction: Vec3,
) -> EditStates {
    let happened = Scattered::towards(at, connector.tables.data, direction);
    let before = super::path::world(at, direction);
    own.after(at.point, happened, before)
}

impl<T: Traverse> Edited<'_, '_, T> {
    fn trace_light<S: Sampler, V: VertexStore>(
        &mut self,
        sampler: &mut S,
        store: &mut V,
        watcher: &mut impl Watcher,
    ) {
        let edits = self.edits;
        let algorithm = self.algorithm;
        let connector = &algorithm.connector;
        watcher.begins(&self.start);
        let own = algorithm.start(&self.start, sampler);
        if own.is_some() {
            watcher.add(own);
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
            let arrival = arrive(connector, edits, &states, &walk, &mut site, sampler);
            let own = Retargeted {
                edits,
                states: &states,
                arrival,
                label: 0,
                is_free: true,
            };
            let at = site.interaction(direction).retargeted(&own);
            if at.is_connectable() {
                if connector.strategies.light_image {
                    let u_lens = if camera::has_lens_points(&connector.tables.camera) {
                        sampler.next_2d()
                    } else {
                        Vec2::ZERO
                    };
                    let beta = walk.subpath.throughput;
                    let mut seen = connector.to_lens(beta, walk.arrived, depth + 1, &at, u_lens);
                    if seen.is_some() {
                        let after = towards(connector, &at, &own, seen.ray.direction);
                        seen.value *= after.reach_sensor(edits);
                    }
                    if seen.is_some() {
                        watcher.add_at(seen, &at);
                    }
                }
                if algorithm.has_camera_walks {
                    let before = self.last;
                    self.last = store.push(&walk.vertex(&hit, &at, self.last));
                    let has_room = self.last != NONE
                        && self.light.states.try_push(states).is_ok()
                        && self.light.arrivals.try_push(arrival).is_ok();
                    if !has_room {
                        // What is kept no more is not connected.
                        self.last = before;
                        return;
                    }
                    self.light.first = self.light.first.min(self.last);
                }
            }
            let own = Retargeted {
                is_free: false,
                ..own
            };
            let at = site.interaction(direction).retargeted(&own);
            let h = connector.heuristic_at(at.point.position);
            next = walk.scatter(connector.tables, &connector.rules, h, sampler, &at);
            if next == step::TRACE && walk.subpath.depth > depth {
                let labelled = Retargeted {
                    label: walk.event >> LABEL_SHIFT,
                    ..own
                };
                let after = scattered(connector, &walk, &at, &own);
                if after.is_none() || !watcher.scattered(&walk, &at.retargeted(&labelled)) {
                    return;
                }
                states = after;
            }
        }
    }

    fn trace_camera<S: Sampler, V: VertexStore>(
        &mut self,
        sampler: &mut S,
        seen: &CameraSample,
        store: &V,
        watcher: &mut impl Watcher,
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
            let (depth, direction) = (walk.subpath.depth, walk.subpath.ray.direction);
            let (found, after) = connector.arrive(&mut walk, &hit, &mut site);
            next = after;
            if found.max_element() > 0.0 {
                let emitter = if hit.is_hit() {
                    site.point.emitter
                } else {
                    connector.tables.info.environment
                };
                let met = Contribution {
                    value: found * states.reach_emitter(edits, emitter),
                    t: depth + 2,
                    ..Contribution::NONE
                };
                if met.is_some() {
                    watcher.met(met, emitter);
                }
            }
            if next != step::SCATTER {
                continue;
            }
            let arrival = arrive(connector, edits, &states, &walk, &mut site, sampler);
            let own = Retargeted {
                edits,
                states: &states,
                arrival,
                label: 0,
                is_free: false,
            };
            let at = site.interaction(direction).retargeted(&own);
            if at.is_connectable() && connector.strategies.shows_all() {
                self.merge(&walk, &at, &own, watcher);
            }
            if at.is_connectable() && connector.strategies.heuristic.connects {
                self.light_up(&walk, &at, &own, sampler, watcher);
                self.connect(&walk, &at, &own, &mut light_site, store, watcher);
            }
            let h = connector.heuristic_at(at.point.position);
            next = walk.scatter(connector.tables, &connector.rules, h, sampler, &at);
            if next == step::TRACE && walk.subpath.depth > depth {
                let labelled = Retargeted {
                    label: walk.event >> LABEL_SHIFT,
                    ..own
                };
                let after = scattered(connector, &walk, &at, &own);
                if after.is_none() || !watcher.scattered(&walk, &at.retargeted(&labelled)) {
                    return;
                }
                states = after;
            }
        }
    }

    /// Next event estimation, by each label.
    fn light_up<S: Sampler>(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        own: &Retargeted<'_>,
        sampler: &mut S,
        watcher: &mut impl Watcher,
    ) {
        let connector = &self.algorithm.connector;
        let position = at.point.position;
        let (light, point) = if connector.strategies.sample_direct {
            let u_select = sampler.next_1d();
            let u = sampler.next_2d();
            sample_direct_with_point(connector.tables, position, u_select, u)
        } else {
            (
                connector.start_sample(position, &self.start),
                self.start.point,
            )
        };
        if !light.is_some() {
            return;
        }
        let labels = own.labels(at.point, light.direction);
        for label in (0..=MAX_EDITS as u32).filter(|label| labels >> label & 1 != 0) {
            let own = Retargeted { label, ..*own };
            let at = at.retargeted(&own);
            let mut lit = connector.lit(walk, &at, &light, &point);
            if lit.is_some() {
                let after = towards(connector, &at, &own, light.direction);
                lit.value *= after.reach_emitter(self.edits, light.emitter);
            }
            if lit.is_some() {
                watcher.add_at(lit, &at);
            }
        }
    }

    /// Connections to the vertices of the light walk, by each pair of labels.
    fn connect<V: VertexStore>(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        own: &Retargeted<'_>,
        site: &mut ShadingPoint,
        store: &V,
        watcher: &mut impl Watcher,
    ) {
        let connector = &self.algorithm.connector;
        let facing = at.facing();
        let mut index = self.last;
        while index != NONE {
            let vertex = store.get(index);
            let kept = (index - self.light.first) as usize;
            index = vertex.previous;
            let edges = vertex.depth.saturating_add(walk.subpath.depth);
            if !connector.allows_edges(edges.saturating_add(2)) {
                continue;
            }
            let between = vec3(vertex.position) - at.point.position;
            if facing.dot(between) < 0.0 || vec3(vertex.facing).dot(between) > 0.0 {
                continue;
            }
            let direction = between.normalize();
            let arrived = vertex.look_up(connector.tables, site);
            let arrival = self.light.arrivals[kept];
            if arrival.choice.label != 0 {
                site.look_up(connector.tables, -arrival.back);
            }
            let of_light = Retargeted {
                edits: self.edits,
                states: &self.light.states[kept],
                arrival,
                label: 0,
                is_free: false,
            };
            let ends = labels_of(&of_light, &site.point, -direction);
            for a in ends {
                let of_light = Retargeted {
                    label: a,
                    ..of_light
                };
                let light_at = site.interaction(arrived).retargeted(&of_light);
                let end = LightEnd::new(&vertex, light_at);
                for b in labels_of(own, at.point, direction) {
                    let own = Retargeted { label: b, ..*own };
                    let at = at.retargeted(&own);
                    let mut joined = connector.inner(&end, walk, &at);
                    if !joined.is_some() {
                        continue;
                    }
                    let before = towards(connector, &light_at, &of_light, -direction);
                    let behind = towards(connector, &at, &own, direction);
                    joined.value *= before.join(&behind);
                    if joined.is_some() {
                        watcher.add_between(joined, &light_at, &at);
                    }
                }
            }
        }
    }

    /// Photons around the vertex, by each label.
    fn merge(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        own: &Retargeted<'_>,
        watcher: &mut impl Watcher,
    ) {
        let Some(photons) = self.photons else {
            return;
        };
        let connector = &self.algorithm.connector;
        let cache = &photons.photons.cache;
        let radius = photons.photons.radius;
        let emitted = photons.photons.emitted.max(1) as f32;
        for_photons_within(cache, at.point.position, radius, |index, distance2| {
            let photon = &cache.photons[index as usize];
            let edges = photon.depth.saturating_add(walk.subpath.depth);
            let cosine = incidence(at, photon);
            if !connector.allows_edges(edges.saturating_add(1)) || !(cosine > 0.0) {
                return;
            }
            let direction = -vec3(photon.direction);
            for label in labels_of(own, at.point, direction) {
                let own = Retargeted { label, ..*own };
                let at = at.retargeted(&own);
                let seen = at.evaluate(
                    connector.tables,
                    &connector.rules,
                    mode::RADIANCE,
                    direction,
                );
                if !seen.is_some() {
                    continue;
                }
                let behind = towards(connector, &at, &own, direction);
                let share = photons.states[photon.beside as usize].join(&behind);
                if !(share.max_element() > 0.0) {
                    continue;
                }
                let weight = merging_weight(
                    connector,
                    photon.weights(),
                    walk,
                    seen.pdf,
                    seen.pdf_reverse,
                    at.point.position,
                );
                let k = mollifier::eval_scaled(KERNEL, 2, float::sqrt(distance2), radius);
                let light = vec3(photon.throughput) * seen.value * (k * weight / cosine);
                let met = Contribution {
                    value: walk.subpath.throughput * light * share / emitted,
                    t: walk.subpath.depth + 2,
                    ..Contribution::NONE
                };
                watcher.met(met, NONE);
            }
        });
    }
}

/// The labels with which a path may go on along a direction.
fn labels_of(
    own: &Retargeted<'_>,
    point: &SurfacePoint,
    direction: Vec3,
) -> ArrayVec<u32, { MAX_EDITS + 1 }> {
    let bits = own.labels(point, direction);
    (0..=MAX_EDITS as u32)
        .filter(|label| bits >> label & 1 != 0)
        .collect()
}
