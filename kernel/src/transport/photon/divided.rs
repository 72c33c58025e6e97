//! Photon mapping whose light is divided by path expressions ([`crate::path::expression`]).
//!
//! A light walk leaves its states beside each photon; a camera walk that finds the photon reads the vertex where both meet, and
//! joins them. The walks are those of [`super::progressive`].

use super::adaptive::{AdaptiveRadii, for_gathered};
use super::cache::Photon;
use super::merging::PassPhotons;
use super::progressive::Progressive;
use super::statistics::PhotonPass;
use super::tracing::{LightBounce, PhotonStore, PhotonTracer};
use crate::math::Rgb;
use crate::path::rules::step;
use crate::path::{
    Contribution, PathExpressions, PathStates, Scattered, ShadingPoint, Shares, Walk,
};
use crate::sampler::Sampler;
use crate::scene::camera::CameraSample;
use crate::scene::{SceneView, Traverse};
use crate::transport::bidirectional::{DividedSample, PathObserver, SharedObserver, StateStore};
use core::cell::RefCell;
use glam::Vec3;

/// Where photons are kept with the states of their walks.
pub trait DividedStore: PhotonStore {
    /// The states before the vertex whose photons come next.
    fn set_states(&mut self, states: &PathStates);
}

/// [`PhotonTracer::light_bounce`] of a walk that reads expressions; it ends where nothing that counts can come of it.
pub fn divided_light_bounce<S: Sampler, P: DividedStore>(
    tracer: &PhotonTracer<'_>,
    expressions: &PathExpressions<'_>,
    states: &mut PathStates,
    bounce: &mut LightBounce<'_, S, P>,
) -> u32 {
    let arriving = bounce.walk.subpath;
    bounce.store.set_states(states);
    let next = tracer.light_bounce(bounce);
    let walk = &*bounce.walk;
    if next == step::TRACE && walk.subpath.depth > arriving.depth {
        let at = bounce.site.interaction(arriving.ray.direction);
        let wo = at.effective(walk.subpath.ray.direction);
        let data = tracer.connector.tables.data;
        let scattered = Scattered::sampled(at.bsdf, data, at.wi, wo, walk.event);
        let automaton = &expressions.from_light;
        *states = states.after(expressions, automaton, at.point, &scattered);
        if expressions.only != 0 && states.is_dead() {
            return step::END;
        }
    }
    next
}

/// One camera walk of progressive photon mapping among the photons of a pass, which `divided` has too; that takes what it finds
/// with the shares of the expressions in it. With `adaptive`, radii of its own, it is a walk of [`super::adaptive`] and adds to the
/// statistics there.
pub fn sample_among_photons<T: Traverse, S: Sampler, K: StateStore>(
    view: &SceneView<'_, T>,
    algorithm: &Progressive<'_>,
    of_pass: &PassPhotons<'_>,
    mut adaptive: Option<(AdaptiveRadii, &mut PhotonPass)>,
    sampler: &mut S,
    seen: &CameraSample,
    divided: &mut DividedSample<'_, '_, T, K, impl FnMut(Contribution, &Shares)>,
) {
    let connector = &algorithm.connector;
    let divided = RefCell::new(divided);
    let mut site = ShadingPoint::NONE;
    let mut walk = Walk::from_sensor(seen);
    let mut next = if walk.subpath.may_continue(&connector.rules) {
        step::TRACE
    } else {
        step::END
    };
    while next == step::TRACE {
        let hit = view.traverse.closest_hit(&walk.subpath.ray);
        let (depth, direction) = (walk.subpath.depth, walk.subpath.ray.direction);
        let (found, after) = algorithm.camera_bounce(
            &mut walk,
            sampler,
            &hit,
            &mut site,
            of_pass.emitted,
            |walk, at, only_unfound| {
                let (cache, radius) = (&of_pass.cache, of_pass.radius);
                let add = |photon: &Photon, light: Rgb| {
                    divided.borrow_mut().gather(walk, at, photon, light);
                };
                match &mut adaptive {
                    Some((radii, sums)) => {
                        for_gathered(connector, walk, at, cache, *radii, only_unfound, sums, add);
                    }
                    None => algorithm.for_gathered(walk, at, cache, radius, only_unfound, add),
                }
                Vec3::ZERO
            },
            SharedObserver(&divided),
        );
        let mut divided = divided.borrow_mut();
        if found.max_element() > 0.0 {
            let (met, emitter) = connector.emitter_hit(found, depth, &hit, &site);
            divided.emitter_hit(met, emitter);
        }
        next = after;
        let has_scattered = next == step::TRACE && walk.subpath.depth > depth;
        if has_scattered && !divided.scattered(&walk, &site.interaction(direction)) {
            next = step::END;
        }
    }
}
