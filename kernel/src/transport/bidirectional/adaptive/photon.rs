//! The bounce of a light walk that leaves photons and keeps its vertices.

use super::records::NodeStore;
use crate::path::path_node::PathNode;
use crate::path::rules::step;
use crate::regularize::settings::Regularization;
use crate::sampler::Sampler;
use crate::transport::photon::tracing::{LightBounce, PhotonTracer};

/// [`PhotonTracer::light_bounce`] of a walk that keeps its vertices, the last of them with the index `last`; the weights of
/// `tracer` are those without regularisation.
pub fn photon_bounce<S: Sampler, P: NodeStore>(
    tracer: &PhotonTracer<'_>,
    regularization: &Regularization,
    last: &mut u32,
    bounce: &mut LightBounce<'_, S, P>,
) -> u32 {
    let connector = &tracer.connector;
    let next = bounce.arrive(connector);
    if next != step::SCATTER {
        return next;
    }
    let (walk, store) = (&mut *bounce.walk, &mut *bounce.store);
    let at = bounce.site.interaction(walk.subpath.ray.direction);
    let before = store.node_mut(*last).copied();
    let node = PathNode::new(
        connector,
        regularization,
        walk,
        bounce.hit,
        &at,
        (*last, before.as_ref()),
        0.0,
    );
    let index = store.push_node(&node);
    // As it may be gathered where it is regularised most.
    tracer.deposit(
        walk,
        &at.regularized(regularization.tau, regularization.flags),
        store,
    );
    let depth = walk.subpath.depth;
    let next = connector.scatter(walk, &at, bounce.sampler);
    if next == step::TRACE && walk.subpath.depth > depth {
        if let Some(node) = store.node_mut(index) {
            node.record_scattering(connector.tables, regularization, &at, walk);
        }
        *last = index;
    }
    next
}
