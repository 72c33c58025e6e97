//! What completes the paths of walks from both ends with edits: light samples, connections and photons, each once for every label that
//! its ends allow.

use super::bidirectional::Edited;
use super::bounce::{labels_of, towards};
use crate::bsdf::mode;
use crate::math::{float, vec3};
use crate::path::retargeted::Retargeted;
use crate::path::{Contribution, Interaction, LightEnd, ShadingPoint, Walk};
use crate::regularize::mollifier;
use crate::sampler::Sampler;
use crate::scene::{NONE, Traverse};
use crate::transport::bidirectional::{PathObserver, VertexStore};
use crate::transport::photon::estimate::{KERNEL, for_photons_within, incidence};
use crate::transport::photon::merging::merging_weight;

impl<T: Traverse> Edited<'_, '_, T> {
    /// Next event estimation, by each label.
    pub(super) fn light_up<S: Sampler>(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        own: &Retargeted<'_>,
        sampler: &mut S,
        observer: &mut impl PathObserver,
    ) {
        let connector = &self.algorithm.connector;
        let position = at.point.position;
        let (light, point) = self.algorithm.light_sample(position, &self.start, sampler);
        if !light.is_some() {
            return;
        }
        for label in labels_of(own, at.point, light.direction) {
            let own = Retargeted { label, ..*own };
            let at = at.retargeted(&own);
            let mut lit = connector.next_event_with(walk, &at, &light, &point);
            if lit.is_some() {
                let after = towards(connector, &at, &own, light.direction);
                lit.value *= after.reach_emitter(self.edits, light.emitter);
            }
            if lit.is_some() {
                observer.add_at(lit, &at);
            }
        }
    }

    /// Connections to the vertices of the light walk, by each pair of labels.
    pub(super) fn connect<V: VertexStore>(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        own: &Retargeted<'_>,
        site: &mut ShadingPoint,
        store: &V,
        observer: &mut impl PathObserver,
    ) {
        let connector = &self.algorithm.connector;
        let facing = at.facing();
        let mut index = self.last;
        while index != NONE {
            let vertex = store.get(index);
            let kept = (index - self.light.first) as usize;
            index = vertex.previous;
            if !self.algorithm.may_connect(walk, at, facing, &vertex) {
                continue;
            }
            let direction = (vec3(vertex.position) - at.point.position).normalize();
            let arrived = vertex.look_up(connector.tables, site);
            let incoming = self.light.incoming[kept];
            if incoming.choice.label != 0 {
                site.look_up(connector.tables, -incoming.back);
            }
            let of_light = Retargeted {
                edits: self.edits,
                states: &self.light.states[kept],
                incoming,
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
                        observer.add_between(joined, &light_at, &at);
                    }
                }
            }
        }
    }

    /// Photons around the vertex, by each label.
    pub(super) fn merge(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        own: &Retargeted<'_>,
        observer: &mut impl PathObserver,
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
                observer.emitter_hit(met, NONE);
            }
        });
    }
}
