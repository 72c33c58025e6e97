//! What edits ([`super::retarget`]) do at a vertex of a walk: which of them have turned the direction from which it came, and those
//! in which it is evaluated and sampled.
//!
//! The surface's BSDF knows only directions before turns. A walk therefore evaluates it for R of the direction that it came
//! along and R of the one in which it goes on, while cosines and edges are those of the true directions. With J = |dR o / do| of
//! each, the density of a sampled direction is J p, the reverse density the same with the J of the other direction, and the
//! factors of values are those of [`Edit::value`].
//!
//! Hosts only, as edits are.

use super::retarget::{Edit, MAX_EDITS, Redirection};
use super::retarget_states::{Choice, EditStates, Edits, VertexReading, label};
use super::scattered::{Scattered, kinds_of_lobe};
use crate::bsdf::Bsdf;
use crate::math::Rgb;
use crate::scene::SurfacePoint;
use arrayvec::ArrayVec;
use glam::Vec3;

/// The direction from which a walk came to a vertex, as edits of the other flow may have redirected it.
#[derive(Clone, Copy, Debug)]
pub struct IncomingDirection {
    /// About the edits of the other flow.
    pub choice: Choice,
    /// World direction back along the walk, as the BSDF knows it.
    pub back: Vec3,
    /// |dR o / do| of the direction back along the walk.
    pub jacobian: f32,
    /// Factor on what it scatters: the edit's, over the probability of the guess.
    pub factor: Rgb,
}

impl IncomingDirection {
    /// Along a direction that nothing has turned.
    pub fn unedited(back: Vec3) -> IncomingDirection {
        IncomingDirection {
            choice: Choice::FREE,
            back,
            jacobian: 1.0,
            factor: Vec3::ONE,
        }
    }

    /// Along a direction `back` that the edit of a label of the flow `other` has turned, if it can have.
    pub fn labelled(
        edits: &Edits<'_>,
        other: u32,
        point: &SurfacePoint,
        back: Vec3,
        label: u32,
    ) -> Option<IncomingDirection> {
        let mut incoming = IncomingDirection::unedited(back);
        if label > 0 {
            let edit = &edits.list[label as usize - 1];
            if edit.flow != other {
                return None;
            }
            let origin = edit.origin_at(point, back)?;
            incoming.back = origin.direction;
            incoming.jacobian = origin.jacobian;
            incoming.factor = edit.value(point, origin.direction, back, origin.jacobian);
        }
        incoming.choice = choice(edits, other, point, incoming.back, label);
        Some(incoming)
    }

    /// All ways in which a walk of the states may have come to `point` against the unit direction `back`, of which it guesses each with
    /// the same probability.
    pub fn ways(
        edits: &Edits<'_>,
        states: &EditStates,
        point: &SurfacePoint,
        bsdf: &Bsdf,
        back: Vec3,
    ) -> ArrayVec<IncomingDirection, { MAX_EDITS + 1 }> {
        let other = 1 - states.flow();
        let (first_letter, may) = (edits.words.first_letter(point), scattering_kinds(bsdf));
        (0..=edits.list.len().min(MAX_EDITS) as u32)
            .filter_map(|label| IncomingDirection::labelled(edits, other, point, back, label))
            .filter(|incoming| states.may_choose(edits, first_letter, may, incoming.choice))
            .collect()
    }

    /// Guesses how a walk that has come to `point` against the unit direction `back` got there. `draw` gives a number, which is
    /// only asked for where there is a choice. The factor is zero if no path counts that comes this way.
    pub fn guess(
        edits: &Edits<'_>,
        states: &EditStates,
        point: &SurfacePoint,
        bsdf: &Bsdf,
        back: Vec3,
        draw: impl FnOnce() -> f32,
    ) -> IncomingDirection {
        let ways = IncomingDirection::ways(edits, states, point, bsdf, back);
        let count = ways.len();
        match count {
            0 => IncomingDirection {
                factor: Vec3::ZERO,
                ..IncomingDirection::unedited(back)
            },
            1 => ways[0],
            _ => {
                let mut incoming = ways[((draw() * count as f32) as usize).min(count - 1)];
                incoming.factor *= count as f32;
                incoming
            }
        }
    }
}

/// The choice of a path about the edits of a flow, for the direction before the turn.
fn choice(edits: &Edits<'_>, flow: u32, point: &SurfacePoint, before: Vec3, label: u32) -> Choice {
    let mut within = 0;
    for (i, edit) in edits.list.iter().enumerate() {
        // Of the edit that has applied rounding might say otherwise.
        let is_own = label == i as u32 + 1;
        if edit.flow == flow && (is_own || edit.redirect_at(point, before).is_some()) {
            within |= 1 << i;
        }
    }
    Choice {
        within,
        label,
        is_free: false,
    }
}

/// Kinds of scattering of a material, as bits of [`super::expression::scattering`].
fn scattering_kinds(bsdf: &Bsdf) -> u32 {
    let lobes = 0..bsdf.lobe_count();
    lobes.fold(0, |may, i| may | kinds_of_lobe(bsdf.lobe_at(i).kind))
}

/// What edits do at a vertex.
#[derive(Clone, Copy)]
pub struct Retargeted<'a> {
    /// All of them.
    pub edits: &'a Edits<'a>,
    /// Of the walk before this vertex.
    pub states: &'a EditStates,
    /// How it came.
    pub incoming: IncomingDirection,
    /// One more than the number of the edit by which the direction is turned in which the vertex is evaluated; zero for none.
    pub label: u32,
    /// Whether no edit turns it, whatever is selected.
    pub is_free: bool,
}

/// A sampled direction as an edit redirects it.
#[derive(Clone, Copy, Debug)]
pub struct RedirectedSample {
    /// Unit direction.
    pub direction: Vec3,
    /// Factor on the density of the sample.
    pub pdf: f32,
    /// Factor on the value of the BSDF times the cosine towards the light.
    pub value: Rgb,
    /// One more than the number of the edit; zero for none.
    pub label: u32,
}

impl RedirectedSample {
    /// By no edit.
    pub fn unedited(direction: Vec3) -> RedirectedSample {
        RedirectedSample {
            direction,
            pdf: 1.0,
            value: Vec3::ONE,
            label: 0,
        }
    }
}

impl<'a> Retargeted<'a> {
    /// At a vertex to which a walk has come, evaluated in directions that no edit turns.
    pub fn new(edits: &'a Edits<'a>, states: &'a EditStates, incoming: IncomingDirection) -> Self {
        Retargeted {
            edits,
            states,
            incoming,
            label: 0,
            is_free: false,
        }
    }

    /// The same vertex, evaluated in directions that the edit of the label has turned.
    #[must_use]
    pub fn labelled(self, label: u32) -> Self {
        Retargeted { label, ..self }
    }
}

impl Retargeted<'_> {
    /// The edit of the label.
    fn edit(&self) -> Option<&Edit> {
        self.edits.list.get((self.label as usize).wrapping_sub(1))
    }

    /// The direction that the BSDF knows for the true one, with |dR o / do|; none if the label is none of its.
    pub fn origin(&self, point: &SurfacePoint, direction: Vec3) -> Option<Redirection> {
        match self.edit() {
            Some(edit) => edit.origin_at(point, direction),
            None => Some(Redirection {
                direction,
                jacobian: 1.0,
            }),
        }
    }

    /// Factor on values, for a direction and that of [`Retargeted::origin`].
    pub fn value(&self, point: &SurfacePoint, origin: &Redirection, direction: Vec3) -> Rgb {
        let factor = self.incoming.factor;
        match self.edit() {
            Some(edit) => factor * edit.value(point, origin.direction, direction, origin.jacobian),
            None => factor,
        }
    }

    /// Labels with which a path may go on along a unit direction, as bits.
    pub fn labels(&self, point: &SurfacePoint, direction: Vec3) -> u32 {
        self.edits.labels(self.states.flow(), point, direction)
    }

    /// How the automata read the vertex in a path that goes on along a direction which the BSDF knows as `before`.
    fn reading(&self, point: &SurfacePoint, scattered: Scattered, before: Vec3) -> VertexReading {
        let own = if self.is_free {
            Choice::FREE
        } else {
            choice(self.edits, self.states.flow(), point, before, self.label)
        };
        VertexReading {
            first_letter: self.edits.words.first_letter(point),
            scattered,
            own,
            other: self.incoming.choice,
        }
    }

    /// States behind the vertex in a path that goes on along a direction which the BSDF knows as `before`.
    pub fn after(&self, point: &SurfacePoint, scattered: Scattered, before: Vec3) -> EditStates {
        let reading = self.reading(point, scattered, before);
        self.states.after(self.edits, &reading)
    }

    /// Luminance of the shares of what is scattered by their labels, in a direction that the edits of the bits `within` may turn.
    fn shares(
        &self,
        point: &SurfacePoint,
        scattered: &Scattered,
        within: u32,
    ) -> [f32; MAX_EDITS + 1] {
        let first_letter = self.edits.words.first_letter(point);
        let other = self.incoming.choice;
        self.states
            .own_labels(self.edits, first_letter, scattered, other, within)
    }

    /// The probability with which [`Retargeted::redirect`] gives the label to a sample that the BSDF knows as `before`.
    pub fn probability(&self, point: &SurfacePoint, scattered: &Scattered, before: Vec3) -> f32 {
        let choice = choice(self.edits, self.states.flow(), point, before, self.label);
        if choice.within == 0 {
            return 1.0;
        }
        let shares = self.shares(point, scattered, choice.within);
        let total: f32 = shares.iter().sum();
        if total > 0.0 {
            shares[self.label as usize] / total
        } else {
            0.0
        }
    }

    /// Turns a sampled direction; where only a part of what is scattered is selected, `draw` decides.
    pub fn redirect(
        &self,
        point: &SurfacePoint,
        scattered: &Scattered,
        before: Vec3,
        draw: impl FnOnce() -> f32,
    ) -> RedirectedSample {
        let straight = RedirectedSample {
            value: self.incoming.factor,
            ..RedirectedSample::unedited(before)
        };
        let choice = choice(self.edits, self.states.flow(), point, before, 0);
        if choice.within == 0 {
            return straight;
        }
        let weights = self.shares(point, scattered, choice.within);
        let total: f32 = weights.iter().sum();
        let first = weights.iter().position(|w| *w > 0.0).unwrap_or(0);
        let mut chosen = first;
        let mut probability = 1.0;
        if weights[first] < total {
            let u = draw() * total;
            let mut below = 0.0;
            for (i, weight) in weights.iter().enumerate() {
                if *weight > 0.0 {
                    chosen = i;
                    below += weight;
                    if u < below {
                        break;
                    }
                }
            }
            probability = weights[chosen] / total;
        }
        let value = self.incoming.factor / probability;
        if chosen == 0 {
            return RedirectedSample { value, ..straight };
        }
        let edit = &self.edits.list[chosen - 1];
        let Some(redirected) = edit.redirect_at(point, before) else {
            return straight;
        };
        let jacobian = 1.0 / redirected.jacobian;
        RedirectedSample {
            direction: redirected.direction,
            pdf: jacobian,
            value: value * edit.value(point, before, redirected.direction, jacobian),
            label: label(1 << (chosen - 1)),
        }
    }
}
