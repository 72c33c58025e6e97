//! A sample whose contributions are divided by path expressions ([`crate::path::expression`]).
//!
//! The light walk leaves the states before each of its vertices, the camera walk has those before its own: what is connected
//! reads the two ends of the connection and joins both.

use super::sample::PathObserver;
use crate::bsdf::mode;
use crate::math::{Rgb, vec3};
use crate::path::visibility::contribution_transmittance;
use crate::path::{
    Connector, Contribution, Contributions, Interaction, PathExpressions, PathStates, Scattered,
    Shares, Walk,
};
use crate::scene::emitter::emission::EmissionSample;
use crate::scene::{SceneView, Traverse};
use crate::transport::photon::cache::Photon;
use crate::transport::photon::merging::{PassPhotons, for_merged};

/// Where the states before the vertices of a light walk are kept, from the first vertex on.
pub trait StateStore {
    /// Forgets all.
    fn clear(&mut self);
    /// Keeps those before the next vertex.
    fn push(&mut self, states: &PathStates);
    /// Those before a vertex.
    fn get(&self, index: usize) -> PathStates;
}

/// The photons of a pass, and the states of their walks before they arrived.
#[derive(Clone, Copy)]
pub struct DividedPhotons<'a> {
    /// The photons.
    pub photons: PassPhotons<'a>,
    /// By [`Photon::record`].
    pub states: &'a [PathStates],
}

/// Divides the contributions of a sample, and hands them on where they do not lie in shadow.
pub struct DividedSample<'a, 'b, T: Traverse, K, F> {
    view: &'a SceneView<'b, T>,
    connector: Connector<'a>,
    expressions: PathExpressions<'a>,
    photons: Option<DividedPhotons<'a>>,
    light: &'a mut K,
    camera: PathStates,
    add: F,
}

impl<'a, 'b, T: Traverse, K: StateStore, F: FnMut(Contribution, &Shares)>
    DividedSample<'a, 'b, T, K, F>
{
    /// Before the walks of a sample; `light` is storage for the states of the light walk. `add` takes each contribution with the
    /// shares of the expressions in it; where nothing counts but paths of the first, only those.
    pub fn new(
        view: &'a SceneView<'b, T>,
        connector: &Connector<'a>,
        expressions: PathExpressions<'a>,
        photons: Option<DividedPhotons<'a>>,
        light: &'a mut K,
        add: F,
    ) -> DividedSample<'a, 'b, T, K, F> {
        light.clear();
        DividedSample {
            view,
            connector: *connector,
            photons,
            camera: PathStates::at_sensor(&expressions),
            expressions,
            light,
            add,
        }
    }

    /// States behind a vertex that the light walk has reached in a path with `s` vertices from the light.
    fn behind_light_vertex(
        &self,
        contribution: &Contribution,
        at: &Interaction<'_>,
        is_towards: bool,
    ) -> PathStates {
        let direction = contribution.ray.direction;
        let direction = if is_towards { direction } else { -direction };
        let scattered = Scattered::towards(at, self.view.tables.data, direction);
        let before = self.light.get(contribution.s as usize - 2);
        let automaton = &self.expressions.from_light;
        before.after(&self.expressions, automaton, at.point, &scattered)
    }

    fn behind_camera_vertex(
        &self,
        contribution: &Contribution,
        at: &Interaction<'_>,
    ) -> PathStates {
        let direction = contribution.ray.direction;
        let scattered = Scattered::towards(at, self.view.tables.data, direction);
        let automaton = &self.expressions.from_sensor;
        self.camera
            .after(&self.expressions, automaton, at.point, &scattered)
    }

    /// A photon that a camera walk has found around a vertex gives so much light there.
    pub fn gather(&mut self, walk: &Walk, at: &Interaction<'_>, photon: &Photon, light: Rgb) {
        let Some(photons) = &self.photons else {
            return;
        };
        let expressions = &self.expressions;
        let direction = -vec3(photon.direction);
        let scattered = Scattered::towards(at, self.view.tables.data, direction);
        let automaton = &expressions.from_sensor;
        let camera = self
            .camera
            .after(expressions, automaton, at.point, &scattered);
        let before = &photons.states[photon.record as usize];
        let shares = before.join(expressions, &camera);
        if expressions.only != 0 && shares.is_none() {
            return;
        }
        let emitted = photons.photons.emitted.max(1) as f32;
        let found = Contribution {
            value: walk.subpath.throughput * light / emitted,
            t: walk.subpath.depth + 2,
            ..Contribution::NONE
        };
        (self.add)(found, &shares);
    }

    fn add_unoccluded(&mut self, mut contribution: Contribution, shares: &Shares) {
        if self.expressions.only != 0 && shares.is_none() {
            return;
        }
        contribution.value *=
            contribution_transmittance(self.view, &self.connector.rules, &contribution);
        if contribution.is_some() {
            (self.add)(contribution, shares);
        }
    }
}

impl<T: Traverse, K: StateStore, F: FnMut(Contribution, &Shares)> Contributions
    for DividedSample<'_, '_, T, K, F>
{
    fn add(&mut self, contribution: Contribution) {
        // An emitter that the lens sees, or a walk that has met the lens behind as many vertices.
        let behind = contribution.s.max(2) as usize - 2;
        let shares = self.light.get(behind).reach_sensor(&self.expressions);
        self.add_unoccluded(contribution, &shares);
    }

    fn add_at(&mut self, contribution: Contribution, at: &Interaction<'_>) {
        let shares = if contribution.t > 1 {
            self.behind_camera_vertex(&contribution, at)
                .reach_emitter(&self.expressions, contribution.emitter)
        } else {
            self.behind_light_vertex(&contribution, at, true)
                .reach_sensor(&self.expressions)
        };
        self.add_unoccluded(contribution, &shares);
    }

    fn add_between(
        &mut self,
        contribution: Contribution,
        light: &Interaction<'_>,
        camera: &Interaction<'_>,
    ) {
        // Segments lead from the camera's vertex to the light's.
        let from_light = self.behind_light_vertex(&contribution, light, false);
        let from_camera = self.behind_camera_vertex(&contribution, camera);
        let shares = from_light.join(&self.expressions, &from_camera);
        self.add_unoccluded(contribution, &shares);
    }
}

impl<T: Traverse, K: StateStore, F: FnMut(Contribution, &Shares)> PathObserver
    for DividedSample<'_, '_, T, K, F>
{
    fn light_walk_starts(&mut self, start: &EmissionSample) {
        let states = PathStates::at_emitter(&self.expressions, start.emitter);
        self.light.push(&states);
    }

    fn scattered(&mut self, walk: &Walk, at: &Interaction<'_>) -> bool {
        let wo = at.effective(walk.subpath.ray.direction);
        let data = self.view.tables.data;
        let scattered = Scattered::sampled(at.bsdf, data, at.wi, wo, walk.event);
        let expressions = &self.expressions;
        let is_dead = if walk.mode == mode::RADIANCE {
            let automaton = &expressions.from_sensor;
            self.camera = self
                .camera
                .after(expressions, automaton, at.point, &scattered);
            self.camera.is_dead()
        } else {
            let before = self.light.get(walk.subpath.depth as usize - 1);
            let automaton = &expressions.from_light;
            let after = before.after(expressions, automaton, at.point, &scattered);
            self.light.push(&after);
            after.is_dead()
        };
        expressions.only == 0 || !is_dead
    }

    fn emitter_hit(&mut self, contribution: Contribution, emitter: u32) {
        let shares = self.camera.reach_emitter(&self.expressions, emitter);
        if self.expressions.only == 0 || !shares.is_none() {
            (self.add)(contribution, &shares);
        }
    }

    fn camera_vertex(&mut self, walk: &Walk, at: &Interaction<'_>) {
        if let Some(photons) = self.photons {
            let connector = self.connector;
            for_merged(&connector, &photons.photons, walk, at, |photon, light| {
                self.gather(walk, at, photon, light);
            });
        }
    }
}

/// The share of a contribution that counts for the image: all of it, or that of the first expression where nothing else does.
#[inline]
pub fn counted(expressions: &PathExpressions<'_>, shares: &Shares, value: Rgb) -> Rgb {
    if expressions.only != 0 {
        value * shares.of(0)
    } else {
        value
    }
}
