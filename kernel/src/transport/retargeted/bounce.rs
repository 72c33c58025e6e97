//! What a bounce of walks from both ends does with edits: where the walk has come from, how it goes on, and what is known then.

use crate::bsdf::mode;
use crate::path::retarget::MAX_EDITS;
use crate::path::retarget_states::{EditStates, Edits};
use crate::path::retargeted::{IncomingDirection, Retargeted};
use crate::path::rules::step;
use crate::path::walk::LABEL_SHIFT;
use crate::path::{Connector, Interaction, Scattered, ShadingPoint, Walk};
use crate::sampler::Sampler;
use crate::scene::{Hit, SurfacePoint};
use crate::transport::bidirectional::PathObserver;
use crate::transport::photon::tracing::{LightBounce, PhotonStore, PhotonTracer};
use arrayvec::ArrayVec;
use glam::Vec3;

/// Where photons are kept with the states of their walks.
pub trait EditedStore: PhotonStore {
    /// The states before the vertex whose photons come next.
    fn set_states(&mut self, states: &EditStates);
}

/// [`PhotonTracer::light_bounce`] with edits.
pub fn light_bounce<S: Sampler, P: EditedStore>(
    tracer: &PhotonTracer<'_>,
    edits: &Edits<'_>,
    states: &mut EditStates,
    bounce: &mut LightBounce<'_, S, P>,
) -> u32 {
    let connector = &tracer.connector;
    let direction = bounce.walk.subpath.ray.direction;
    let next = bounce.arrive(connector);
    if next != step::SCATTER {
        return next;
    }
    let (walk, sampler, site) = (&mut *bounce.walk, &mut *bounce.sampler, &mut *bounce.site);
    bounce.store.set_states(states);
    tracer.deposit(walk, &site.interaction(direction), bounce.store);
    let incoming = arrive(connector, edits, states, walk, site, sampler);
    let retargeted = Retargeted::new(edits, states, incoming);
    let at = site.interaction(direction).retargeted(&retargeted);
    let (next, after) = scatter(connector, walk, &at, &retargeted, sampler, |_, _| true);
    *states = after;
    next
}

/// Where a camera walk has arrived: hands the selected part of the emission that it meets to the observer; returns what is next, one
/// of [`step`].
pub(super) fn meet_emitter(
    connector: &Connector<'_>,
    edits: &Edits<'_>,
    states: &EditStates,
    walk: &mut Walk,
    hit: &Hit,
    site: &mut ShadingPoint,
    observer: &mut impl PathObserver,
) -> u32 {
    let depth = walk.subpath.depth;
    let (found, next) = connector.arrive(walk, hit, site);
    if found.max_element() > 0.0 {
        let (mut met, emitter) = connector.emitter_hit(found, depth, hit, site);
        met.value *= states.reach_emitter(edits, emitter);
        if met.is_some() {
            observer.emitter_hit(met, emitter);
        }
    }
    next
}

/// What edits do at the vertex where a walk has arrived, once its surface has been looked up.
pub(super) fn arrive<S: Sampler>(
    connector: &Connector<'_>,
    edits: &Edits<'_>,
    states: &EditStates,
    walk: &Walk,
    site: &mut ShadingPoint,
    sampler: &mut S,
) -> IncomingDirection {
    let back = -walk.subpath.ray.direction;
    if walk.mode == mode::RADIANCE && walk.subpath.depth == 0 {
        return IncomingDirection::unedited(back);
    }
    let (point, bsdf) = (&site.point, &site.bsdf);
    let incoming = IncomingDirection::guess(edits, states, point, bsdf, back, || sampler.next_1d());
    if incoming.choice.label != 0 {
        site.look_up(connector.tables, -incoming.back);
    }
    incoming
}

/// Scatters at a vertex; returns what is next, one of [`step`], and the states then. `watch` observes the vertex and returns whether the walk
/// shall go on.
pub(super) fn scatter<S: Sampler>(
    connector: &Connector<'_>,
    walk: &mut Walk,
    at: &Interaction<'_>,
    retargeted: &Retargeted<'_>,
    sampler: &mut S,
    watch: impl FnOnce(&Walk, &Interaction<'_>) -> bool,
) -> (u32, EditStates) {
    let depth = walk.subpath.depth;
    let next = connector.scatter(walk, at, sampler);
    if next != step::TRACE || walk.subpath.depth == depth {
        return (next, *retargeted.states);
    }
    let retargeted = retargeted.labelled(walk.event >> LABEL_SHIFT);
    let at = at.retargeted(&retargeted);
    let after = scattered(connector, walk, &at, &retargeted);
    let goes_on = !after.is_none() && watch(walk, &at);
    (if goes_on { step::TRACE } else { step::END }, after)
}

/// The states behind the vertex that a walk has scattered at, with the label of what it has done there.
fn scattered(
    connector: &Connector<'_>,
    walk: &Walk,
    at: &Interaction<'_>,
    retargeted: &Retargeted<'_>,
) -> EditStates {
    let direction = walk.subpath.ray.direction;
    let wo = at.effective(direction);
    let happened = Scattered::sampled(at.bsdf, connector.tables.data, at.wi, wo, walk.event);
    retargeted.after(at.point, happened, at.point.frame.to_world(wo))
}

/// The states behind a vertex in a path that goes on along a direction.
pub(super) fn towards(
    connector: &Connector<'_>,
    at: &Interaction<'_>,
    retargeted: &Retargeted<'_>,
    direction: Vec3,
) -> EditStates {
    let happened = Scattered::towards(at, connector.tables.data, direction);
    let before = super::path::world(at, direction);
    retargeted.after(at.point, happened, before)
}

/// The labels with which a path may go on along a direction.
pub(super) fn labels_of(
    retargeted: &Retargeted<'_>,
    point: &SurfacePoint,
    direction: Vec3,
) -> ArrayVec<u32, { MAX_EDITS + 1 }> {
    let bits = retargeted.labels(point, direction);
    (0..=MAX_EDITS as u32)
        .filter(|label| bits >> label & 1 != 0)
        .collect()
}
