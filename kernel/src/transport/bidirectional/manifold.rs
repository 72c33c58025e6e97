//! Bidirectional path tracing that also connects to lights through refracting interfaces (Hanika, Droske and Fascione 2015).
//!
//! Every rough vertex of a camera walk is connected to a light through the interfaces between both
//! ([`crate::transport::manifold_connection`]). Paths that such a connection finds are left to it: of what the other strategies
//! find, whichever of a path's vertices they join, only the rest counts. Which paths are left depends on the paths alone, and
//! the weights of the other strategies sum to one on every path of the rest.
//!
//! A path belongs to the connection by the end at its light: a point of the light, interfaces that it passes, and the anchor. A light walk
//! that has come to an anchor in this way ends there, because all that begins like it is left. Before that, the part
//! of the interfaces that the light walk has passed is joined with the part that the camera walk has passed since its last
//! anchor.
//!
//! Hosts only, as the connections.

use super::algorithm::Bidirectional;
use super::sample::{PathObserver, sample_observed};
use super::vertex_store::VertexStore;
use crate::bsdf::{Bsdf, event, mode};
use crate::manifold::ChainVertex;
use crate::math::Ray;
use crate::path::through_interfaces::{MAX_INTERFACES, interface, interface_vertex};
use crate::path::visibility::contribution_transmittance;
use crate::path::{Contribution, Contributions, Interaction, PathRules, Walk};
use crate::sampler::{IndependentSampler, Sampler};
use crate::scene::camera::CameraSample;
use crate::scene::emitter::emission::EmissionSample;
use crate::scene::{NONE, SceneView, Traverse, emitter_kind};
use crate::transport::manifold_connection::{
    Anchor, connect, has_position, is_anchor, light_point, passes,
};
use arrayvec::ArrayVec;
use glam::Vec3;

/// One sample of an algorithm that is not regularised and merges nothing: `add` takes what each strategy finds, as in
/// [`super::sample`].
pub fn sample_through_interfaces<T: Traverse, S: Sampler, V: VertexStore>(
    view: &SceneView<'_, T>,
    algorithm: &Bidirectional<'_>,
    light_sampler: &mut S,
    camera_sampler: &mut S,
    seen: &CameraSample,
    store: &mut V,
    add: impl FnMut(Contribution),
) {
    let mut observer = Left::new(view, algorithm.connector.rules, light_sampler, add);
    sample_observed(
        view,
        algorithm,
        light_sampler,
        camera_sampler,
        seen,
        store,
        &mut observer,
    );
}

/// A light walk as far as it belongs to chains of interfaces.
struct LightPart {
    /// Where it began, if connections reach such lights.
    start: Option<ChainVertex>,
    /// The interfaces that it has passed, one after the other from the light on.
    passed: ArrayVec<ChainVertex, MAX_INTERFACES>,
    /// Whether paths that begin as it does, up to the anchor after them, are left to the connection; not known before it is needed.
    is_left: Option<bool>,
}

/// The role of the end of a light walk in a connection.
enum ChainEnd {
    /// None of the paths through it is left, or all of them.
    Known(bool),
    /// An interface through which the path goes on to the other end, and the number of interfaces before it.
    Interface(ChainVertex, usize),
}

/// Passes on what is not left to connections through interfaces, and makes these.
struct Left<'a, 'b, T: Traverse, F> {
    view: &'a SceneView<'b, T>,
    rules: PathRules,
    /// Numbers of the connections.
    sampler: IndependentSampler,
    light: LightPart,
    /// The last anchor of the camera walk.
    camera: Option<Anchor>,
    /// Its ray.
    ray: Ray,
    scratch: Bsdf,
    add: F,
}

/// World direction from which a walk has come.
fn back(at: &Interaction<'_>) -> Vec3 {
    at.point.frame.to_world(at.wi)
}

impl<'a, 'b, T: Traverse, F: FnMut(Contribution)> Left<'a, 'b, T, F> {
    /// Two numbers of a walk begin the stream of the connections.
    fn new(
        view: &'a SceneView<'b, T>,
        rules: PathRules,
        sampler: &mut impl Sampler,
        add: F,
    ) -> Left<'a, 'b, T, F> {
        let [a, b] = [sampler.next_1d(), sampler.next_1d()].map(f32::to_bits);
        Left {
            view,
            rules,
            sampler: IndependentSampler::new(a, b, 0),
            light: LightPart {
                start: None,
                passed: ArrayVec::new(),
                is_left: None,
            },
            camera: None,
            ray: Ray::new(Vec3::ZERO, Vec3::Z),
            scratch: Bsdf::BLACK,
            add,
        }
    }

    /// Whether the connection from an anchor finds the path to the light through the first `count` interfaces of the light walk.
    fn is_found_by_walk(&mut self, mut anchor: Anchor, count: usize) -> bool {
        let Some(light) = self.light.start else {
            return false;
        };
        let passed = &self.light.passed[..count];
        passed.iter().rev().all(|vertex| anchor.push(*vertex))
            && anchor.is_found_by_walk(self.view, light, &mut self.scratch)
    }

    /// The role of vertex `i` of the light walk, whose start is vertex 0, in a path that leaves it along `direction`.
    fn light_end(&mut self, i: usize, at: &Interaction<'_>, direction: Vec3) -> ChainEnd {
        let count = self.light.passed.len();
        // Behind a vertex that it has not passed as an interface there is no chain.
        if self.light.start.is_none() || i == 0 || i > count + 1 {
            return ChainEnd::Known(false);
        }
        match interface(at.bsdf) {
            Some(alpha) if passes(at.point, -back(at), direction) => {
                let vertex = interface_vertex(at.point, at.bsdf, alpha, back(at));
                ChainEnd::Interface(vertex, i - 1)
            }
            Some(_) => ChainEnd::Known(false),
            None => ChainEnd::Known(self.ends_at_anchor(at)),
        }
    }

    /// Whether the paths that begin as the light walk are left because of the vertex behind the interfaces that it has passed.
    fn ends_at_anchor(&mut self, at: &Interaction<'_>) -> bool {
        if let Some(known) = self.light.is_left {
            return known;
        }
        let count = self.light.passed.len();
        let is_left =
            is_anchor(at.bsdf) && count > 0 && self.is_found_by_walk(Anchor::new(at.point), count);
        self.light.is_left = Some(is_left);
        is_left
    }

    /// Whether a path is left that leads through an interface to the light, from where a camera walk has arrived, in this direction.
    fn is_left_beyond(
        &mut self,
        camera: &Interaction<'_>,
        direction: Vec3,
        (vertex, before): (ChainVertex, usize),
    ) -> bool {
        let chain = match interface(camera.bsdf) {
            None => is_anchor(camera.bsdf).then(|| Anchor::new(camera.point)),
            Some(alpha) => self
                .camera
                .filter(|_| passes(camera.point, -back(camera), direction))
                .and_then(|mut anchor| {
                    let between = interface_vertex(camera.point, camera.bsdf, alpha, direction);
                    anchor.push(between).then_some(anchor)
                }),
        };
        chain.is_some_and(|mut anchor| anchor.push(vertex) && self.is_found_by_walk(anchor, before))
    }

    /// Whether next event estimation from an interface finds a path that is left.
    fn is_left_to_light(&mut self, contribution: &Contribution, at: &Interaction<'_>) -> bool {
        let direction = contribution.ray.direction;
        let (Some(mut anchor), Some(alpha)) = (self.camera, interface(at.bsdf)) else {
            return false;
        };
        if contribution.emitter == NONE || !passes(at.point, -back(at), direction) {
            return false;
        }
        let between = interface_vertex(at.point, at.bsdf, alpha, direction);
        anchor.push(between)
            && light_point(self.view, &at.point.spawn(direction), contribution.emitter)
                .is_some_and(|light| anchor.is_found_by_walk(self.view, light, &mut self.scratch))
    }

    /// What is left of a contribution in the shadow of others.
    fn unoccluded(&self, mut contribution: Contribution) -> Option<Contribution> {
        if !contribution.is_some() {
            return None;
        }
        contribution.value *= contribution_transmittance(self.view, &self.rules, &contribution);
        contribution.is_some().then_some(contribution)
    }
}

impl<T: Traverse, F: FnMut(Contribution)> Contributions for Left<'_, '_, T, F> {
    fn add(&mut self, contribution: Contribution) {
        // Light that the lens sees directly, or by a walk that would have ended at an anchor.
        if let Some(found) = self.unoccluded(contribution) {
            (self.add)(found);
        }
    }

    fn add_at(&mut self, contribution: Contribution, at: &Interaction<'_>) {
        let Some(found) = self.unoccluded(contribution) else {
            return;
        };
        let is_left = if found.t > 1 {
            self.is_left_to_light(&found, at)
        } else {
            let vertex = found.s as usize - 1;
            // An interface that the lens sees has no anchor.
            let end = self.light_end(vertex, at, found.ray.direction);
            matches!(end, ChainEnd::Known(true))
        };
        if !is_left {
            (self.add)(found);
        }
    }

    fn add_between(
        &mut self,
        contribution: Contribution,
        light: &Interaction<'_>,
        camera: &Interaction<'_>,
    ) {
        let Some(found) = self.unoccluded(contribution) else {
            return;
        };
        // Segments lead from the camera's vertex to the light's.
        let direction = found.ray.direction;
        let is_left = match self.light_end(found.s as usize - 1, light, -direction) {
            ChainEnd::Known(is_left) => is_left,
            ChainEnd::Interface(vertex, before) => {
                self.is_left_beyond(camera, direction, (vertex, before))
            }
        };
        if !is_left {
            (self.add)(found);
        }
    }
}

impl<T: Traverse, F: FnMut(Contribution)> PathObserver for Left<'_, '_, T, F> {
    fn light_walk_starts(&mut self, start: &EmissionSample) {
        let kind = self.view.tables.emitters[start.emitter as usize].kind;
        self.light.start = if kind == emitter_kind::AREA {
            Some(ChainVertex::from_surface(&start.point))
        } else {
            has_position(kind).then(|| ChainVertex::point(start.point.position))
        };
    }

    fn scattered(&mut self, walk: &Walk, at: &Interaction<'_>) -> bool {
        let (back, after) = (back(at), walk.subpath.ray.direction);
        let alpha = interface(at.bsdf);
        let passes = passes(at.point, -back, after);
        let is_discrete = walk.event & event::DELTA != 0;
        if walk.mode == mode::RADIANCE {
            self.ray = walk.subpath.ray;
            self.camera = match (self.camera, alpha) {
                (_, None) if is_anchor(at.bsdf) && !is_discrete => Some(Anchor::new(at.point)),
                (Some(mut anchor), Some(alpha)) if passes => {
                    let vertex = interface_vertex(at.point, at.bsdf, alpha, after);
                    anchor.push(vertex).then_some(anchor)
                }
                _ => None,
            };
            return true;
        }
        if self.light.start.is_none() || walk.subpath.depth as usize != self.light.passed.len() + 1
        {
            return true;
        }
        match alpha {
            Some(alpha) if passes => {
                let vertex = interface_vertex(at.point, at.bsdf, alpha, back);
                // More than fit are no chain.
                let _ = self.light.passed.try_push(vertex);
                true
            }
            Some(_) => true,
            None => is_discrete || !self.ends_at_anchor(at),
        }
    }

    fn emitter_hit(&mut self, contribution: Contribution, emitter: u32) {
        let is_left = emitter != NONE
            && self.camera.is_some_and(|anchor| {
                light_point(self.view, &self.ray, emitter).is_some_and(|light| {
                    anchor.is_found_by_walk(self.view, light, &mut self.scratch)
                })
            });
        if !is_left {
            (self.add)(contribution);
        }
    }

    fn camera_vertex(&mut self, walk: &Walk, at: &Interaction<'_>) {
        if !is_anchor(at.bsdf) {
            return;
        }
        let depth = walk.subpath.depth;
        let found = connect(
            self.view,
            &self.rules,
            (at.point, at.bsdf, at.wi),
            depth,
            &mut self.sampler,
            &mut self.scratch,
        );
        let found = Contribution {
            value: walk.subpath.throughput * found,
            t: depth + 2,
            ..Contribution::NONE
        };
        if found.is_some() {
            (self.add)(found);
        }
    }
}
