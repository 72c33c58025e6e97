//! Full paths with edits ([`crate::path::retarget`]), and the walks that make them.
//!
//! A state of a chain is a **labelled path**: its vertices where light really goes, and at each the labels of both flows
//! ([`crate::path::retarget_states`]). It carries what its vertices scatter between the directions before the turns, R of those along its
//! edges, times the factors of its edits and the share of it that the selections allow; labels that are not those of the
//! selections carry nothing. So chains look for the same image as walks that turn as they go.
//!
//! Measure: that of [`super`], solid angles of true directions, so f |cos| towards the light of a vertex that an edit of
//! importance turns takes |dR o / do|, and so do densities. At a discrete event, which is no part of any density, only the quotient
//! of both Jacobians is left, in the ratio by which a light walk differs from a camera walk.
//!
//! A walk draws labels: at each vertex that of the other flow, evenly among those that it can have ([`IncomingDirection::ways`]), and where it
//! scatters its own, by the shares of what is selected. Their probabilities depend on what the walk has read on its way, and with
//! them p_s is the density of a labelled path; that of a connection, whose labels are chosen evenly, is said where it is made.
//!
//! What moves the vertices of a path a little keeps its labels: R and its inverse are smooth maps, so the vertex behind a turn
//! follows. Only half vectors are no coordinates of a vertex whose directions are turned.
//!
//! Invariant (tests): chains of such paths have the image of path tracing with the same edits, whatever the mutation.
//!
//! Hosts only, as [`super`].

use super::Path;
use super::vertex::Vertex;
use crate::bsdf::{Bsdf, BsdfSample, mode};
use crate::math::Rgb;
use crate::path::retarget::{MAX_EDITS, Redirection, flow};
use crate::path::retarget_states::{EditStates, Edits};
use crate::path::retargeted::{IncomingDirection, Retargeted};
use crate::path::scattered::Scattered;
use crate::sampler::Sampler;
use crate::scene::{SurfacePoint, Tables};
use arrayvec::ArrayVec;
use glam::Vec3;

/// A walk that draws labels.
#[derive(Clone, Copy, Debug)]
pub struct EditedWalk<'a> {
    edits: &'a Edits<'a>,
    states: EditStates,
    /// Whether it has left the sensor, and nothing else: edges to the sensor no edit turns.
    is_first: bool,
}

impl<'a> EditedWalk<'a> {
    /// That starts at the sensor.
    pub fn at_sensor(edits: &'a Edits<'a>) -> EditedWalk<'a> {
        EditedWalk {
            edits,
            states: EditStates::at_sensor(edits),
            is_first: true,
        }
    }

    /// That starts at an emitter.
    pub fn at_emitter(edits: &'a Edits<'a>, emitter: u32) -> EditedWalk<'a> {
        EditedWalk {
            edits,
            states: EditStates::at_emitter(edits, emitter),
            is_first: false,
        }
    }

    /// The flow that it goes with.
    fn flow(&self) -> usize {
        self.states.flow() as usize
    }

    /// The ways in which it may have come to a point against `back`.
    fn ways(
        &self,
        tables: &Tables<'_>,
        point: &SurfacePoint,
        back: Vec3,
        bsdf: &mut Bsdf,
    ) -> ArrayVec<IncomingDirection, { MAX_EDITS + 1 }> {
        if self.is_first {
            return core::iter::once(IncomingDirection::unedited(back)).collect();
        }
        let wi = point.frame.to_local(back);
        bsdf.look_up(tables, point, wi, mode::RADIANCE);
        IncomingDirection::ways(self.edits, &self.states, point, bsdf, back)
    }

    /// Draws the other flow's label at a vertex to which it has come against the unit direction `back`; returns whether there is one.
    pub fn guess<S: Sampler>(
        &self,
        tables: &Tables<'_>,
        vertex: &mut Vertex,
        back: Vec3,
        bsdf: &mut Bsdf,
        sampler: &mut S,
    ) -> bool {
        let ways = self.ways(tables, &vertex.point, back, bsdf);
        let chosen = match ways.len() {
            0 => return false,
            1 => 0,
            count => ((sampler.next_1d() * count as f32) as usize).min(count - 1),
        };
        vertex.labels[1 - self.flow()] = ways[chosen].choice.label;
        true
    }

    /// How it has come to a vertex with the label of the other flow there.
    pub fn incoming(&self, vertex: &Vertex, back: Vec3) -> Option<IncomingDirection> {
        if self.is_first {
            return Some(IncomingDirection::unedited(back));
        }
        let other = 1 - self.flow();
        let label = vertex.labels[other];
        IncomingDirection::labelled(self.edits, other as u32, &vertex.point, back, label)
    }

    /// Goes on from a vertex along a sample of its BSDF whose unit world direction is `sampled`: draws the own label, and returns the
    /// direction after the turn.
    pub fn leave<S: Sampler>(
        &mut self,
        tables: &Tables<'_>,
        vertex: &mut Vertex,
        incoming: IncomingDirection,
        bsdf: &Bsdf,
        sample: &BsdfSample,
        sampled: Vec3,
        sampler: &mut S,
    ) -> Vec3 {
        let point = &vertex.point;
        let wi = point.frame.to_local(incoming.back);
        let scattered = Scattered::sampled(bsdf, tables.data, wi, sample.wo, sample.event);
        let retargeted = self.at(incoming, 0);
        let turned = retargeted.redirect(point, &scattered, sampled, || sampler.next_1d());
        let retargeted = retargeted.labelled(turned.label);
        let after = retargeted.after(point, scattered, sampled);
        vertex.labels[self.flow()] = turned.label;
        self.states = after;
        self.is_first = false;
        turned.direction
    }

    fn at(&self, incoming: IncomingDirection, label: u32) -> Retargeted<'_> {
        Retargeted::new(self.edits, &self.states, incoming).labelled(label)
    }

    /// Passes vertex `i` of a path; returns the probabilities with which it guesses the label of the other flow and draws its own.
    fn pass<const N: usize>(
        &mut self,
        tables: &Tables<'_>,
        path: &Path<N>,
        i: usize,
        bsdf: &mut Bsdf,
    ) -> Option<[f32; 2]> {
        let vertex = &path.vertices[i];
        let point = &vertex.point;
        let mut ends = [path.previous_direction(i), path.next_direction(i)];
        if self.states.flow() == flow::IMPORTANCE {
            ends.reverse();
        }
        let [back, direction] = ends;
        let ways = self.ways(tables, point, back, bsdf);
        let of_other = vertex.labels[1 - self.flow()];
        let incoming = *ways.iter().find(|way| way.choice.label == of_other)?;
        let retargeted = self.at(incoming, vertex.labels[self.flow()]);
        let origin = retargeted.origin(point, direction)?;
        let [wi, wo] = [incoming.back, origin.direction].map(|w| point.frame.to_local(w));
        bsdf.look_up(tables, point, wi, mode::RADIANCE);
        let scattered = Scattered::sampled(bsdf, tables.data, wi, wo, vertex.event);
        let probability = retargeted.probability(point, &scattered, origin.direction);
        let after = retargeted.after(point, scattered, origin.direction);
        self.states = after;
        self.is_first = false;
        Some([1.0 / ways.len() as f32, probability])
    }
}

/// What edits do at a vertex of a path.
pub(super) struct EditedVertex {
    /// Local direction to the sensor, as the BSDF knows it.
    pub to_sensor: Vec3,
    /// To the light.
    pub to_light: Vec3,
    /// |dR o / do| of both.
    pub jacobians: [f32; 2],
    /// Factor on what is scattered.
    pub value: Rgb,
}

impl Vertex {
    /// Where edits have turned the unit directions to the sensor and to the light; nothing where the labels are not possible.
    pub(super) fn edited(
        &self,
        edits: Option<&Edits<'_>>,
        to_sensor: Vec3,
        to_light: Vec3,
    ) -> Option<EditedVertex> {
        let point = &self.point;
        let mut found = EditedVertex {
            to_sensor: point.frame.to_local(to_sensor),
            to_light: point.frame.to_local(to_light),
            jacobians: [1.0; 2],
            value: Vec3::ONE,
        };
        let Some(edits) = edits else {
            return Some(found);
        };
        for (flow, direction) in [(flow::LIGHT, to_sensor), (flow::IMPORTANCE, to_light)] {
            let label = self.labels[flow as usize] as usize;
            if label == 0 {
                continue;
            }
            let edit = &edits.list[label - 1];
            let Redirection {
                direction: before,
                jacobian,
            } = edit.origin_at(point, direction)?;
            // At a discrete event the Jacobian of importance is that of its density as well.
            let of_value = if flow == flow::IMPORTANCE && !self.is_smooth() {
                1.0
            } else {
                jacobian
            };
            found.value *= edit.value(point, before, direction, of_value);
            found.jacobians[flow as usize] = jacobian;
            let local = point.frame.to_local(before);
            if flow == flow::LIGHT {
                found.to_sensor = local;
            } else {
                found.to_light = local;
            }
        }
        Some(found)
    }
}

impl<const N: usize> Path<N> {
    /// Whether an edit turns a direction of it.
    pub fn is_turned(&self) -> bool {
        self.vertices.iter().any(|vertex| vertex.labels != [0; 2])
    }

    /// A walk along the path that comes to vertex `i` with a flow of [`flow`]; `bsdf` is room for the BSDFs on the way.
    pub fn walk_to<'a>(
        &self,
        tables: &Tables<'_>,
        edits: &'a Edits<'a>,
        flow: u32,
        i: usize,
        bsdf: &mut Bsdf,
    ) -> Option<EditedWalk<'a>> {
        if flow == flow::IMPORTANCE {
            let mut walk = EditedWalk::at_sensor(edits);
            for j in (i + 1..self.edges()).rev() {
                walk.pass(tables, self, j, bsdf)?;
            }
            return Some(walk);
        }
        let mut walk = EditedWalk::at_emitter(edits, self.emitter);
        for j in 1..i {
            walk.pass(tables, self, j, bsdf)?;
        }
        Some(walk)
    }

    /// Puts the probabilities of labels into the densities of a path whose vertices have been looked up; returns the share of it
    /// that the selections allow.
    pub(super) fn share_of_labels(
        &mut self,
        tables: &Tables<'_>,
        edits: &Edits<'_>,
        bsdf: &mut Bsdf,
    ) -> Rgb {
        let k = self.edges();
        let mut walk = EditedWalk::at_sensor(edits);
        for i in (1..k).rev() {
            let Some([guess, turn]) = walk.pass(tables, self, i, bsdf) else {
                return Vec3::ZERO;
            };
            let vertex = &mut self.vertices[i];
            vertex.guesses[flow::IMPORTANCE as usize] = guess;
            vertex.pdf_to_light *= turn;
        }
        let share = walk.states.reach_emitter(edits, self.emitter);
        if !(share.max_element() > 0.0) {
            return share;
        }
        let mut walk = EditedWalk::at_emitter(edits, self.emitter);
        let mut is_possible = true;
        for i in 1..k {
            let found = if is_possible {
                walk.pass(tables, self, i, bsdf)
            } else {
                None
            };
            is_possible = found.is_some();
            let [guess, turn] = found.unwrap_or([0.0; 2]);
            let vertex = &mut self.vertices[i];
            vertex.guesses[flow::LIGHT as usize] = guess;
            vertex.pdf_to_sensor *= turn;
        }
        share
    }
}
