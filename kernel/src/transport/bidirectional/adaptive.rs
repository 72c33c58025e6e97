//! Bidirectional path tracing and vertex merging whose regularisation depends on the path: the heuristics of Jendersie and
//! Grosch 2019, section 3.5.
//!
//! - *path diffusion*: tau of a vertex is `tau / sigma`, sigma the spread of the path from the sensor to it. A vertex of a light
//!   subpath has another tau for each camera subpath that it is connected to;
//! - *sampler quality*: a share of each path, which depends on its best connection, is regularised
//!   ([`crate::regularize::heuristic::quality_share`]); the rest is what the algorithm without regularisation makes of it.
//!
//! Either way what is regularised at a vertex is a function of the whole path, so that the weights of its strategies (equation 13)
//! are a partition of one; they are summed for each path anew ([`crate::path::whole_weights`]). Paths along which nothing is
//! shiny have the weights of the recursion, and so has the share that is not regularised.
//!
//! Both subpaths sample the model as it is, and their random numbers are those without regularisation. Light walks do not meet a
//! lens here (t = 0), and paths have [`MAX_EDGES`] edges at most. What a merge finds is none of the connections whose quality counts.
//!
//! Invariants (tests): without shiny surfaces the image is that of the algorithm, and with plain values it has its mean.
//!
//! Hosts only, because it keeps both subpaths.

use super::adaptive_strategies::Ends;
use super::algorithm::{Bidirectional, ConnectedPoints};
use crate::math::float;
use crate::path::path_node::PathNode;
use crate::path::rules::step;
use crate::path::visibility::contribution_transmittance;
use crate::path::whole_weights::{LightStart, MAX_INNER, WholeDensities};
use crate::path::{Connector, Contribution, Interaction, ShadingPoint, Walk};
use crate::regularize::bandwidth::TAU_MAX;
use crate::regularize::heuristic::PathDiffusion;
use crate::regularize::settings::Regularization;
use crate::sampler::Sampler;
use crate::scene::camera::CameraSample;
use crate::scene::emitter::emission::EmissionSample;
use crate::scene::{Hit, NONE, SceneView, Tables, Traverse};
use crate::transport::photon::merging::PassPhotons;
use crate::transport::photon::tracing::{PhotonStore, PhotonTracer};
use arrayvec::ArrayVec;
use glam::Vec3;

/// Most edges of a path.
pub const MAX_EDGES: u32 = MAX_INNER as u32;

/// Most vertices of a subpath, those counted whose masks it passes.
const MAX_NODES: usize = 2 * MAX_INNER;

/// Room for the two subpaths of a sample.
pub struct AdaptiveRoom {
    light: ArrayVec<PathNode, MAX_NODES>,
    camera: ArrayVec<PathNode, MAX_NODES>,
    points: ConnectedPoints,
    path: WholeDensities,
}

impl AdaptiveRoom {
    /// Empty.
    pub fn new() -> AdaptiveRoom {
        AdaptiveRoom {
            light: ArrayVec::new(),
            camera: ArrayVec::new(),
            points: ConnectedPoints::NONE,
            path: WholeDensities {
                inner: ArrayVec::new(),
                start: LightStart::NONE,
                sensor: Vec3::ZERO,
                first: 0.0,
            },
        }
    }
}

impl Default for AdaptiveRoom {
    fn default() -> AdaptiveRoom {
        AdaptiveRoom::new()
    }
}

/// The photons of a pass with the vertices of their walks.
#[derive(Clone, Copy)]
pub struct AdaptivePhotons<'a> {
    /// The photons.
    pub photons: PassPhotons<'a>,
    /// By [`crate::transport::photon::cache::Photon::beside`]; each has the index of the one before.
    pub nodes: &'a [PathNode],
}

/// Where photons are kept with the vertices of their walks.
pub trait NodeStore: PhotonStore {
    /// Keeps a vertex, that of the photon that comes next if there is one, and returns its index.
    fn push_node(&mut self, node: &PathNode) -> u32;
    /// A vertex that was kept.
    fn node_mut(&mut self, index: u32) -> Option<&mut PathNode>;
}

/// The algorithm with what one sample is asked for.
#[derive(Clone, Copy)]
pub struct Adaptive<'a> {
    pub(super) algorithm: Bidirectional<'a>,
    /// Without weights.
    pub(super) bare: Connector<'a>,
    pub(super) own: Regularization,
}

impl<'a> Adaptive<'a> {
    /// Of an algorithm that has its regularisation ([`Bidirectional::regularized`]).
    pub fn new(algorithm: &Bidirectional<'a>) -> Adaptive<'a> {
        let mut algorithm = *algorithm;
        let connector = &mut algorithm.connector;
        let own = connector.regularization;
        connector.regularization = Regularization::NONE;
        connector.strategies.meets_lens = false;
        connector.rules.max_depth = connector.rules.max_depth.min(MAX_EDGES);
        let mut bare = *connector;
        bare.strategies.unweighted = true;
        Adaptive {
            algorithm,
            bare,
            own,
        }
    }

    /// One sample: `add` takes what each strategy finds, nothing where it lies in shadow.
    pub fn sample<T: Traverse, S: Sampler>(
        &self,
        view: &SceneView<'_, T>,
        photons: Option<&AdaptivePhotons<'_>>,
        (light_sampler, camera_sampler): (&mut S, &mut S),
        seen: &CameraSample,
        room: &mut AdaptiveRoom,
        mut add: impl FnMut(Contribution),
    ) {
        let rules = self.algorithm.connector.rules;
        let mut hand_on = |mut found: Contribution| {
            if found.is_some() {
                found.value *= contribution_transmittance(view, &rules, &found);
                add(found);
            }
        };
        room.light.clear();
        room.camera.clear();
        if rules.max_depth == 0 {
            return;
        }
        let start = self.algorithm.emit(light_sampler);
        if start.is_some() {
            hand_on(self.algorithm.start(&start, light_sampler));
            self.light_walk(view, &start, light_sampler, room, &mut hand_on);
        }
        if self.algorithm.has_camera_walks {
            self.camera_walk(
                view,
                photons,
                &start,
                camera_sampler,
                seen,
                room,
                &mut hand_on,
            );
        }
    }

    fn light_walk<T: Traverse, S: Sampler>(
        &self,
        view: &SceneView<'_, T>,
        start: &EmissionSample,
        sampler: &mut S,
        room: &mut AdaptiveRoom,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let strategies = &connector.strategies;
        let tables = connector.tables;
        let mut walk = Walk::from_emitter(start);
        let mut last = NONE;
        let mut next = step::TRACE;
        while next == step::TRACE && !room.light.is_full() {
            sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
            let hit = view.traverse.closest_hit(&walk.subpath.ray);
            let direction = walk.subpath.ray.direction;
            next = connector.arrive(&mut walk, &hit, &mut room.points.own).1;
            if next != step::SCATTER {
                continue;
            }
            let at = room.points.own.interaction(direction);
            let before = (last, room.light.get(last as usize));
            let node = PathNode::new(tables, strategies, &self.own, &walk, &hit, &at, before, 0.0);
            let index = room.light.len();
            room.light.push(node);
            if strategies.light_image && (at.is_connectable() || node.is_raised) {
                let u_lens = self.algorithm.lens_numbers(sampler);
                let ends = Ends {
                    nodes: &room.light,
                    path: &mut room.path,
                    site: &mut room.points.light,
                };
                self.seen_by_lens(ends, index, &walk, &at, u_lens, add);
            }
            next = self.scatter(&mut walk, sampler, &at, &mut room.light[index]);
            if next == step::TRACE && room.light[index].is_left {
                last = index as u32;
            }
        }
    }

    fn camera_walk<T: Traverse, S: Sampler>(
        &self,
        view: &SceneView<'_, T>,
        photons: Option<&AdaptivePhotons<'_>>,
        start: &EmissionSample,
        sampler: &mut S,
        seen: &CameraSample,
        room: &mut AdaptiveRoom,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let strategies = &connector.strategies;
        let tables = connector.tables;
        let mut walk = Walk::from_sensor(seen);
        let mut last = NONE;
        let mut diffusion = PathDiffusion::SHARP;
        let mut next = step::TRACE;
        room.path.sensor = walk.subpath.position;
        while next == step::TRACE && !room.camera.is_full() {
            sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
            let hit = view.traverse.closest_hit(&walk.subpath.ray);
            let direction = walk.subpath.ray.direction;
            let before = room.camera.get(last as usize);
            let ends = Ends {
                nodes: &room.camera,
                path: &mut room.path,
                site: &mut room.points.own,
            };
            next = self.arrive(ends, &mut walk, &hit, before, add);
            if next != step::SCATTER {
                continue;
            }
            let at = room.points.own.interaction(direction);
            let distance = (at.point.position - walk.subpath.position).length();
            let first = walk.pdf_first(tables, at.point, distance);
            let sensor_bound = if strategies.light_image {
                first * float::sqr(distance)
            } else {
                TAU_MAX
            };
            let of_walk = (last, before);
            let mut node = PathNode::new(
                tables,
                strategies,
                &self.own,
                &walk,
                &hit,
                &at,
                of_walk,
                sensor_bound,
            );
            if last == NONE {
                node.first = first;
            }
            let mut arrived = diffusion;
            arrived.travel(distance);
            node.tau = self.own.threshold(&arrived);
            if at.is_connectable() || node.is_raised {
                let own = super::adaptive_strategies::Seen {
                    walk: &walk,
                    at: &at,
                    node: &node,
                    before: &room.camera,
                    diffusion: arrived,
                };
                let mut ends = Ends {
                    nodes: &room.light,
                    path: &mut room.path,
                    site: &mut room.points.light,
                };
                if let Some(photons) = photons {
                    self.merge(&mut ends, &own, photons, add);
                }
                self.lit(&mut ends, &own, start, sampler, add);
                for end in 0..room.light.len() {
                    self.inner(&mut ends, &own, end, add);
                }
            }
            let index = room.camera.len();
            next = self.scatter(&mut walk, sampler, &at, &mut node);
            room.camera.push(node);
            if next == step::TRACE && node.is_left {
                last = index as u32;
                diffusion = arrived;
                diffusion.scatter(node.left.bound, node.curvature);
            }
        }
    }

    /// Scatters at a vertex, which learns of it if the walk goes on from there and not through its mask.
    fn scatter<S: Sampler>(
        &self,
        walk: &mut Walk,
        sampler: &mut S,
        at: &Interaction<'_>,
        node: &mut PathNode,
    ) -> u32 {
        let connector = &self.algorithm.connector;
        let h = connector.heuristic_at(at.point.position);
        let depth = walk.subpath.depth;
        let next = walk.scatter(connector.tables, &connector.rules, h, sampler, at);
        if next == step::TRACE && walk.subpath.depth > depth {
            node.leave(connector.tables, &self.own, at, walk);
        }
        next
    }
}

/// [`PhotonTracer::light_bounce`] of a walk that keeps its vertices, the last of them with the index `last`; the weights of
/// `tracer` are those without regularisation.
pub fn photon_bounce<S: Sampler, P: NodeStore>(
    tracer: &PhotonTracer<'_>,
    own: &Regularization,
    walk: &mut Walk,
    last: &mut u32,
    sampler: &mut S,
    hit: &Hit,
    site: &mut ShadingPoint,
    store: &mut P,
) -> u32 {
    let connector = &tracer.connector;
    let tables: &Tables<'_> = connector.tables;
    let next = connector.arrive(walk, hit, site).1;
    if next != step::SCATTER {
        return next;
    }
    let at = site.interaction(walk.subpath.ray.direction);
    let before = store.node_mut(*last).copied();
    let node = PathNode::new(
        tables,
        &connector.strategies,
        own,
        walk,
        hit,
        &at,
        (*last, before.as_ref()),
        0.0,
    );
    let index = store.push_node(&node);
    // As it may be gathered where it is regularised most.
    tracer.leave(walk, &at.regularized(own.tau, own.flags), store);
    let h = connector.heuristic_at(at.point.position);
    let depth = walk.subpath.depth;
    let next = walk.scatter(tables, &connector.rules, h, sampler, &at);
    if next == step::TRACE && walk.subpath.depth > depth {
        if let Some(node) = store.node_mut(index) {
            node.leave(tables, own, &at, walk);
        }
        *last = index;
    }
    next
}
