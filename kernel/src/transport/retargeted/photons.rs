//! Photons with edits: those that are merged, and camera walks of progressive photon mapping.
//!
//! A photon brings the states of its walk before it arrived. Where a camera walk gathers it, the vertex is read by the camera walk,
//! once for every label that it allows towards where the photon came from, and both sets of states are joined.

use super::bounce::{arrive, labels_of, meet_emitter, scatter, towards};
use crate::bsdf::mode;
use crate::math::{float, vec3};
use crate::path::retarget_states::{EditStates, Edits};
use crate::path::retargeted::Retargeted;
use crate::path::rules::step;
use crate::path::{
    Connector, Contribution, Evaluation, Interaction, PartialWeights, ShadingPoint, Walk,
};
use crate::regularize::mollifier;
use crate::sampler::Sampler;
use crate::scene::camera::CameraSample;
use crate::scene::emitter::{DirectSample, sample_direct_with_point};
use crate::scene::{NONE, SceneView, SurfacePoint, Traverse};
use crate::transport::bidirectional::PathObserver;
use crate::transport::photon::cache::Photon;
use crate::transport::photon::estimate::{KERNEL, for_photons_within, incidence};
use crate::transport::photon::merging::PassPhotons;
use crate::transport::photon::progressive::Progressive;
use crate::transport::photon::tracing::is_found_by_photons_alone;

/// The photons of a pass, and the states of their walks before they arrived.
#[derive(Clone, Copy)]
pub struct EditedPhotons<'a> {
    /// The photons.
    pub photons: PassPhotons<'a>,
    /// By [`crate::transport::photon::cache::Photon::record`].
    pub states: &'a [EditStates],
}

/// A camera walk of [`crate::transport::photon::progressive`] with edits.
pub fn sample_among_photons<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    algorithm: &Progressive<'_>,
    edits: &Edits<'_>,
    photons: &EditedPhotons<'_>,
    sampler: &mut S,
    seen: &CameraSample,
    observer: &mut impl PathObserver,
) {
    let connector = &algorithm.connector;
    let mut states = EditStates::at_sensor(edits);
    let mut walk = Walk::from_sensor(seen);
    let mut site = ShadingPoint::NONE;
    let mut next = if walk.subpath.may_continue(&connector.rules) {
        step::TRACE
    } else {
        step::END
    };
    while next == step::TRACE {
        let hit = view.traverse.closest_hit(&walk.subpath.ray);
        let (depth, direction) = (walk.subpath.depth, walk.subpath.ray.direction);
        next = meet_emitter(
            connector, edits, &states, &mut walk, &hit, &mut site, observer,
        );
        // No strategy has more than one vertex on the light's side.
        walk.arrived = PartialWeights::NONE;
        if next != step::SCATTER {
            continue;
        }
        let incoming = arrive(connector, edits, &states, &walk, &mut site, sampler);
        let retargeted = Retargeted::new(edits, &states, incoming);
        let at = site.interaction(direction).retargeted(&retargeted);
        let bsdf = &site.bsdf;
        let is_rough = bsdf.has_smooth() && bsdf.roughness() >= algorithm.gather_roughness;
        if bsdf.has_smooth() {
            // A walk that ends here does not go on to meet the emitter.
            let mut of_light = *connector;
            of_light.strategies.unweighted |= is_rough;
            let (u_select, u) = (sampler.next_1d(), sampler.next_2d());
            let (light, point) =
                sample_direct_with_point(connector.tables, at.point.position, u_select, u);
            if light.is_some() {
                light_up(
                    &of_light,
                    &walk,
                    &at,
                    &retargeted,
                    (&light, &point),
                    observer,
                );
            }
            let counts = |photon: &Photon| is_rough || is_found_by_photons_alone(photon);
            for_gathered(
                connector,
                photons,
                &walk,
                &at,
                &retargeted,
                |photon, _| if counts(photon) { 1.0 } else { 0.0 },
                |met| observer.emitter_hit(met, NONE),
            );
        }
        if is_rough && !bsdf.has_delta() {
            return;
        }
        let watch = |walk: &Walk, at: &Interaction<'_>| observer.scattered(walk, at);
        (next, states) = scatter(connector, &mut walk, &at, &retargeted, sampler, watch);
        let is_smooth = walk.subpath.depth > depth && walk.weights.d_vcm > 0.0;
        if is_rough && is_smooth {
            return;
        }
    }
}

/// Adds an emitter sample of a vertex, by each label.
pub(super) fn light_up(
    connector: &Connector<'_>,
    walk: &Walk,
    at: &Interaction<'_>,
    retargeted: &Retargeted<'_>,
    (light, point): (&DirectSample, &SurfacePoint),
    observer: &mut impl PathObserver,
) {
    for label in labels_of(retargeted, at.point, light.direction) {
        let retargeted = retargeted.labelled(label);
        let at = at.retargeted(&retargeted);
        let mut lit = connector.next_event_with(walk, &at, light, point);
        if lit.is_some() {
            let after = towards(connector, &at, &retargeted, light.direction);
            lit.value *= after.reach_emitter(retargeted.edits, light.emitter);
        }
        if lit.is_some() {
            observer.add_at(lit, &at);
        }
    }
}

/// Passes on the light of the photons around a vertex, by each label; `weight` says how much of a photon counts that is seen so.
pub(super) fn for_gathered(
    connector: &Connector<'_>,
    photons: &EditedPhotons<'_>,
    walk: &Walk,
    at: &Interaction<'_>,
    retargeted: &Retargeted<'_>,
    weight: impl Fn(&Photon, &Evaluation) -> f32,
    mut add: impl FnMut(Contribution),
) {
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
        for label in labels_of(retargeted, at.point, direction) {
            let retargeted = retargeted.labelled(label);
            let at = at.retargeted(&retargeted);
            let seen = at.evaluate(
                connector.tables,
                &connector.rules,
                mode::RADIANCE,
                direction,
            );
            let weight = weight(photon, &seen);
            if !seen.is_some() || !(weight > 0.0) {
                continue;
            }
            let behind = towards(connector, &at, &retargeted, direction);
            let share = photons.states[photon.record as usize].join(&behind);
            if !(share.max_element() > 0.0) {
                continue;
            }
            let k = mollifier::eval_scaled(KERNEL, 2, float::sqrt(distance2), radius);
            let light = vec3(photon.throughput) * seen.value * (k * weight / cosine);
            add(Contribution {
                value: walk.subpath.throughput * light * share / emitted,
                t: walk.subpath.depth + 2,
                ..Contribution::NONE
            });
        }
    });
}
