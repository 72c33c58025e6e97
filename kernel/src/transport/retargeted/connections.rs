//! What completes the paths of walks from both ends with edits: light samples, connections and photons, each once for every label that
//! its ends allow.

use super::bidirectional::EditedSample;
use super::bounce::{labels_of, towards};
use super::photons::{for_gathered, light_up};
use crate::math::vec3;
use crate::path::retargeted::Retargeted;
use crate::path::{Interaction, LightEnd, ShadingPoint, Walk};
use crate::sampler::Sampler;
use crate::scene::{NONE, Traverse};
use crate::transport::bidirectional::{PathObserver, VertexStore};
use crate::transport::photon::merging::merging_weight;

impl<T: Traverse> EditedSample<'_, '_, T> {
    /// Next event estimation, by each label.
    pub(super) fn light_up<S: Sampler>(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        retargeted: &Retargeted<'_>,
        sampler: &mut S,
        observer: &mut impl PathObserver,
    ) {
        let connector = &self.algorithm.connector;
        let position = at.point.position;
        let (light, point) = self.algorithm.light_sample(position, &self.start, sampler);
        if !light.is_some() {
            return;
        }
        light_up(connector, walk, at, retargeted, (&light, &point), observer);
    }

    /// Connections to the vertices of the light walk, by each pair of labels.
    pub(super) fn connect<V: VertexStore>(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        retargeted: &Retargeted<'_>,
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
            let of_light = Retargeted::new(self.edits, &self.light.states[kept], incoming);
            let ends = labels_of(&of_light, &site.point, -direction);
            for a in ends {
                let of_light = of_light.labelled(a);
                let light_at = site.interaction(arrived).retargeted(&of_light);
                let end = LightEnd::new(&vertex, light_at);
                for b in labels_of(retargeted, at.point, direction) {
                    let retargeted = retargeted.labelled(b);
                    let at = at.retargeted(&retargeted);
                    let mut joined = connector.inner(&end, walk, &at);
                    if !joined.is_some() {
                        continue;
                    }
                    let before = towards(connector, &light_at, &of_light, -direction);
                    let behind = towards(connector, &at, &retargeted, direction);
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
        retargeted: &Retargeted<'_>,
        observer: &mut impl PathObserver,
    ) {
        let Some(photons) = self.photons else {
            return;
        };
        let connector = &self.algorithm.connector;
        for_gathered(
            connector,
            photons,
            walk,
            at,
            retargeted,
            |photon, seen| {
                merging_weight(
                    connector,
                    photon.weights(),
                    walk,
                    seen.pdf,
                    seen.pdf_reverse,
                    at.point.position,
                )
            },
            |met| observer.emitter_hit(met, NONE),
        );
    }
}
