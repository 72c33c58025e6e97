//! Edges of full paths: those that are traced along sampled directions, and those that are tested.
//!
//! Where light may pass straight through a surface, a walk passes with the largest channel of the transmittance as probability;
//! the probabilities of all that it passed and that of standing where it ended are kept, because they are the same in both directions.
//! What stands in the way of a connection dims it.
//!
//! Hosts only, as [`super`].

use super::full_path::Path;
use super::full_path::edited::EditedWalk;
use super::full_path::vertex::{Edge, SMOOTH, Vertex, p_through};
use super::remainder::Remainder;
use super::retarget_states::Edits;
use super::rules::PathRules;
use super::visibility::{MAX_NULL_CROSSINGS, pass_through};
use crate::bsdf::{Bsdf, event, mode};
use crate::math::Ray;
use crate::sampler::Sampler;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{NONE, SceneView, SurfacePoint, Traverse, scene_flag};
use glam::Vec3;

/// Where a walk arrived.
#[derive(Clone, Copy, Debug)]
pub struct TracedEdge {
    /// The surface; nothing where it left the scene.
    pub point: Option<SurfacePoint>,
    /// What it passed, and the direction back.
    pub edge: Edge,
}

/// The scene and the rules of walks in it.
pub struct Tracer<'a, T: Traverse> {
    /// The scene.
    pub view: &'a SceneView<'a, T>,
    /// The rules.
    pub rules: PathRules,
    /// What path tracing leaves to chains, where both render an image together.
    pub remainder: Option<Remainder>,
    /// The edits of the scene's light transport.
    pub edits: Option<&'a Edits<'a>>,
}

impl<T: Traverse> Clone for Tracer<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T: Traverse> Copy for Tracer<'_, T> {}

impl<'a, T: Traverse> Tracer<'a, T> {
    /// [`Path::evaluate`], less what path tracing keeps of the path.
    pub fn evaluate<const N: usize>(&self, path: &mut Path<N>, bsdf: &mut Bsdf) -> bool {
        self.evaluate_and(path, 1, bsdf, |_, _, _, _| {})
    }

    /// [`Path::evaluate_and`], less the same.
    pub fn evaluate_and<const N: usize>(
        &self,
        path: &mut Path<N>,
        first: usize,
        bsdf: &mut Bsdf,
        visit: impl FnMut(&Path<N>, usize, [Vec3; 2], &Bsdf),
    ) -> bool {
        let tables = &self.view.tables;
        if !path.evaluate_and(tables, &self.rules, self.edits, first, bsdf, visit) {
            return false;
        }
        let Some(remainder) = &self.remainder else {
            return true;
        };
        // Path tracing blurs nothing.
        if path.is_blurred() {
            return true;
        }
        let pdf = [0, 1].map(|s| path.strategy_pdf(tables, s, false));
        path.value *= remainder.chain_share(path.luminance(), pdf, path.edges() as u32);
        path.value.max_element() > 0.0
    }

    /// Follows a ray to the surface where a walk stands; `from_sensor` passes emitters that the sensor does not see.
    pub fn trace<S: Sampler>(&self, ray: &Ray, from_sensor: bool, sampler: &mut S) -> TracedEdge {
        let tables = &self.view.tables;
        let mut ray = *ray;
        let mut edge = Edge {
            direction: -ray.direction,
            ..Edge::CLEAR
        };
        for _ in 0..MAX_NULL_CROSSINGS {
            let hit = self.view.traverse.closest_hit(&ray);
            if !hit.is_hit() {
                break;
            }
            let point = surface_with::<{ detail::TANGENTS }>(tables, &ray, &hit);
            let is_hidden = from_sensor && self.rules.hide_emitters != 0 && point.emitter != NONE;
            if !is_hidden {
                let through = p_through(tables, &point);
                let p = through.max_element().min(1.0);
                if !(p > 0.0) || sampler.next_1d() >= p {
                    return TracedEdge {
                        point: Some(point),
                        edge,
                    };
                }
                edge.transmittance *= through;
                edge.pass *= p;
            }
            pass_through(&mut ray, &point);
        }
        TracedEdge { point: None, edge }
    }

    /// What lies along a segment, nothing if it is blocked; `to_sensor` passes emitters that the sensor does not see.
    pub fn segment(&self, segment: &Ray, to_sensor: bool) -> Option<Edge> {
        let tables = &self.view.tables;
        let passes_emitters = to_sensor && self.rules.hide_emitters != 0;
        let mut edge = Edge::CLEAR;
        if tables.info.flags & scene_flag::HAS_NULL == 0 && !passes_emitters {
            let is_free = !self.view.traverse.is_occluded(segment);
            return is_free.then_some(edge);
        }
        let mut ray = *segment;
        for _ in 0..MAX_NULL_CROSSINGS {
            let hit = self.view.traverse.closest_hit(&ray);
            if !hit.is_hit() {
                return Some(edge);
            }
            let point = surface_with::<{ detail::TANGENTS }>(tables, &ray, &hit);
            if !(passes_emitters && point.emitter != NONE) {
                let through = p_through(tables, &point);
                let p = through.max_element().min(1.0);
                if !(p > 0.0) {
                    return None;
                }
                edge.transmittance *= through;
                edge.pass *= p;
            }
            pass_through(&mut ray, &point);
            if ray.t_max <= 0.0 {
                return Some(edge);
            }
        }
        None
    }

    /// A walk from the sensor that draws labels; nothing where there are no edits.
    pub fn from_sensor(&self) -> Option<EditedWalk<'a>> {
        self.edits.map(EditedWalk::at_sensor)
    }

    /// The same from an emitter.
    pub fn from_emitter(&self, emitter: u32) -> Option<EditedWalk<'a>> {
        self.edits
            .map(|edits| EditedWalk::at_emitter(edits, emitter))
    }

    /// Draws the label of a vertex to which a walk that draws them has come against `back`; returns whether there is one.
    pub fn guess<S: Sampler>(
        &self,
        walk: Option<&EditedWalk<'_>>,
        vertex: &mut Vertex,
        back: Vec3,
        bsdf: &mut Bsdf,
        sampler: &mut S,
    ) -> bool {
        let tables = &self.view.tables;
        walk.is_none_or(|walk| walk.guess(tables, vertex, back, bsdf, sampler))
    }

    /// Samples how a walk that came against the unit direction `back` leaves a vertex, and notes the event there, with its label if
    /// the walk draws them.
    pub fn scatter<S: Sampler>(
        &self,
        walk: &mut Option<EditedWalk<'_>>,
        vertex: &mut Vertex,
        back: Vec3,
        bsdf: &mut Bsdf,
        sampler: &mut S,
    ) -> Option<Ray> {
        let tables = &self.view.tables;
        let (u1, u2) = (sampler.next_1d(), sampler.next_2d());
        let point = &vertex.point;
        let mut wi = point.frame.to_local(back);
        if !self.rules.allows(point, back, wi.z) {
            return None;
        }
        let mut arrival = None;
        if let Some(walk) = walk {
            let known = walk.incoming(vertex, back)?;
            wi = point.frame.to_local(known.back);
            arrival = Some(known);
        }
        bsdf.look_up(tables, point, wi, mode::RADIANCE);
        let sample = bsdf.sample(tables.data, wi, u1, u2);
        if !(sample.pdf > 0.0) || sample.event & event::NULL != 0 {
            return None;
        }
        vertex.event = if sample.event & event::DELTA != 0 {
            sample.event
        } else {
            SMOOTH
        };
        let mut direction = point.frame.to_world(sample.wo).normalize();
        let mut cosine = sample.wo.z;
        if let (Some(walk), Some(arrival)) = (walk, arrival) {
            direction = walk.leave(tables, vertex, arrival, bsdf, &sample, direction, sampler);
            cosine = vertex.point.frame.n.dot(direction);
        }
        let point = &vertex.point;
        let allowed = self.rules.allows(point, direction, cosine);
        allowed.then(|| point.spawn(direction))
    }
}
