//! Which edits ([`super::retarget`]) apply to a path, whatever the end from which it is built.
//!
//! An edit of light applies at a vertex x_i if its expression matches x_0 ... x_i with any surface vertex behind, and if the
//! direction in which the light would go meets its source; an edit of importance the same from the sensor. Of several the first
//! applies. At every vertex a path therefore has a **label** for each flow: the number of the edit that has turned its direction
//! there, or none. The same vertices with other labels are another path, with its own value: where the target of an edit overlaps
//! what else is lit, both light that was turned and light that was not arrive. What is rendered is the sum over all labels that
//! the selections allow.
//!
//! The walk that goes with a flow knows the label once it has a direction. The other knows the direction after the turn and has
//! to guess: it goes on along R o, as if the edit had applied, or along o, with probabilities by which it is divided, and the
//! selection decides when the rest of the path is known (thesis 9.2.1: the modification is rejected). Of the automaton that reads
//! from the other end it therefore keeps the **set of states** V in which that end must arrive for all labels so far to be right:
//!
//! ```text
//! V'  =  { q : d(q, letter) in V, and the edit that applies in d(q, letter) is the label },   V = all at its own end,
//! ```
//!
//! for each vertex that it passes, d the step of the automaton. Both walks of a connection hold such a set and a state of their
//! own; the path counts if each state is in the other's set. Where vertices are diffuse and glossy at once, a walk holds several
//! such pairs with the shares of its light ([`super::path_states`]). Segments that end at the sensor no edit of light turns: a
//! surface keeps its looks, and what it sends elsewhere moves. For emitters there is no such exception.
//!
//! Probabilities of guesses stay out of the weights of strategies, as those of Russian roulette do ([`super::rules`]): weights
//! depend on the labelled path alone and sum to one.
//!
//! Hosts only, as edits are.

use super::expression::{Automaton, PathExpressions, START, scattering};
use super::retarget::Edit;
use super::scattered::Scattered;
use crate::math::{Rgb, luminance};
use crate::scene::{NONE, SurfacePoint};
use glam::Vec3;

/// Most pairs of a walk. A front end makes sure that it is enough for its edits.
pub const PAIRS: usize = 24;

/// Most states of an automaton of edits: the bits of a set.
pub const MAX_STATES: usize = 64;

/// The edits of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Edits<'a> {
    /// In the order in which they apply, at most [`super::retarget::MAX_EDITS`].
    pub list: &'a [Edit],
    /// The letters and automata of their selections. `matched` has, by state, the bits of the edits of the automaton's own
    /// flow that apply behind what has been read; there are no joins.
    pub words: PathExpressions<'a>,
}

impl<'a> Edits<'a> {
    /// The automaton that walks of a flow (one of [`super::retarget::flow`]) read.
    #[inline]
    pub fn automaton(&self, flow: u32) -> &Automaton<'a> {
        if flow == super::retarget::flow::LIGHT {
            &self.words.from_light
        } else {
            &self.words.from_sensor
        }
    }
}

impl Edits<'_> {
    /// Labels of a flow that a vertex can have at an edge along the unit direction, as bits.
    pub fn labels(&self, flow: u32, point: &SurfacePoint, direction: Vec3) -> u32 {
        let mut labels = 1;
        for (i, edit) in self.list.iter().enumerate() {
            if edit.flow == flow && edit.origin_at(point, direction).is_some() {
                labels |= 2 << i;
            }
        }
        labels
    }
}

/// The choice that a path makes about the edits of a flow at a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Bits of the edits whose sources the direction before the turn meets.
    pub within: u32,
    /// One more than the number of the edit that has turned it; zero for none.
    pub label: u32,
    /// Whether no edit applies, whatever is selected.
    pub is_free: bool,
}

impl Choice {
    /// No edit applies.
    pub const FREE: Choice = Choice {
        within: 0,
        label: 0,
        is_free: true,
    };

    /// Whether the label is right where the edits of the bits `selected` are selected.
    #[inline]
    pub fn is_right(&self, selected: u32) -> bool {
        self.is_free || label(selected & self.within) == self.label
    }
}

/// The label of the first of several edits.
#[inline]
pub fn label(bits: u32) -> u32 {
    if bits == 0 {
        0
    } else {
        bits.trailing_zeros() + 1
    }
}

/// A vertex as the automata of edits read it.
#[derive(Clone, Copy, Debug)]
pub struct VertexReading {
    /// [`PathExpressions::first_letter`].
    pub first_letter: u32,
    /// What happens there.
    pub scattered: Scattered,
    /// About the edits of the walk's own flow.
    pub own: Choice,
    /// About those of the other.
    pub other: Choice,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Pair {
    /// State of the automaton that the walk reads.
    state: u32,
    /// States of the other in which the rest of the path must arrive.
    wanted: u64,
    /// Share of the light.
    weight: Rgb,
}

/// What a walk knows of the edits that apply to its path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EditStates {
    /// One of [`super::retarget::flow`]: the one that the walk goes with.
    flow: u32,
    count: u32,
    pairs: [Pair; PAIRS],
}

impl EditStates {
    /// Of no path.
    pub fn none(flow: u32) -> EditStates {
        EditStates {
            flow,
            count: 0,
            pairs: [Pair {
                state: 0,
                wanted: 0,
                weight: Vec3::ZERO,
            }; PAIRS],
        }
    }

    fn start(flow: u32, edits: &Edits<'_>, first: u32) -> EditStates {
        let (own, other) = (edits.automaton(flow), edits.automaton(1 - flow));
        let all = u64::MAX >> (MAX_STATES - other.matched.len().clamp(1, MAX_STATES));
        let mut states = EditStates::none(flow);
        states.add(own.after(START, first), all, Vec3::ONE);
        states
    }

    /// Of a walk that starts at the sensor.
    pub fn at_sensor(edits: &Edits<'_>) -> EditStates {
        EditStates::start(super::retarget::flow::IMPORTANCE, edits, edits.words.sensor)
    }

    /// Of a walk that starts at an emitter.
    pub fn at_emitter(edits: &Edits<'_>, emitter: u32) -> EditStates {
        let flow = super::retarget::flow::LIGHT;
        if emitter == NONE {
            return EditStates::none(flow);
        }
        let first = edits.words.emitters[emitter as usize];
        EditStates::start(flow, edits, first)
    }

    /// The flow that the walk goes with.
    #[inline]
    pub fn flow(&self) -> u32 {
        self.flow
    }

    /// Whether no path that goes on from here counts.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.count == 0
    }

    fn add(&mut self, state: u32, wanted: u64, weight: Rgb) {
        if wanted == 0 || !(weight.max_element() > 0.0) {
            return;
        }
        let count = self.count as usize;
        for pair in &mut self.pairs[..count] {
            if pair.state == state && pair.wanted == wanted {
                pair.weight += weight;
                return;
            }
        }
        if count < PAIRS {
            self.pairs[count] = Pair {
                state,
                wanted,
                weight,
            };
            self.count += 1;
        }
    }

    fn pairs(&self) -> &[Pair] {
        &self.pairs[..self.count as usize]
    }

    /// Passes on what each pair comes to by each kind of scattering: the state, its set, and its weight; whatever the own choice.
    fn steps(
        &self,
        edits: &Edits<'_>,
        first_letter: u32,
        kinds: &[(u32, Rgb)],
        other: Choice,
        mut take: impl FnMut(u32, u64, Rgb),
    ) {
        let (reads, waits) = (edits.automaton(self.flow), edits.automaton(1 - self.flow));
        for pair in self.pairs() {
            for (kind, share) in kinds {
                let weight = pair.weight * *share;
                if !(weight.max_element() > 0.0) {
                    continue;
                }
                let letter = edits.words.letter(first_letter, *kind);
                let mut wanted = 0;
                for q in 0..waits.matched.len().min(MAX_STATES) {
                    let after = waits.after(q as u32, letter);
                    let is_wanted = pair.wanted >> after & 1 != 0;
                    if is_wanted && other.is_right(waits.matched[after as usize]) {
                        wanted |= 1 << q;
                    }
                }
                if wanted != 0 {
                    take(reads.after(pair.state, letter), wanted, weight);
                }
            }
        }
    }

    /// Those behind a vertex.
    #[must_use]
    pub fn after(&self, edits: &Edits<'_>, reading: &VertexReading) -> EditStates {
        let mut next = EditStates::none(self.flow);
        let automaton = edits.automaton(self.flow);
        let kinds = kinds(&reading.scattered);
        self.steps(
            edits,
            reading.first_letter,
            &kinds,
            reading.other,
            |state, wanted, weight| {
                if reading.own.is_right(automaton.matched[state as usize]) {
                    next.add(state, wanted, weight);
                }
            },
        );
        next
    }

    /// Luminance of the shares by the label that each has behind a vertex, for a direction that meets the sources of the edits
    /// `within`; the weights by label.
    pub fn own_labels(
        &self,
        edits: &Edits<'_>,
        first_letter: u32,
        scattered: &Scattered,
        other: Choice,
        within: u32,
    ) -> [f32; super::retarget::MAX_EDITS + 1] {
        let mut weights = [0.0; super::retarget::MAX_EDITS + 1];
        let automaton = edits.automaton(self.flow);
        self.steps(
            edits,
            first_letter,
            &kinds(scattered),
            other,
            |state, _, weight| {
                let label = label(automaton.matched[state as usize] & within);
                weights[label as usize] += luminance(weight);
            },
        );
        weights
    }

    /// Whether some path counts that has the choice `other` at a vertex which may scatter by the kinds in the bits `may` (of
    /// [`scattering`]).
    pub fn may_choose(
        &self,
        edits: &Edits<'_>,
        first_letter: u32,
        may: u32,
        other: Choice,
    ) -> bool {
        let mut is_some = false;
        for kind in 0..scattering::COUNT {
            if may >> kind & 1 != 0 && !is_some {
                self.steps(
                    edits,
                    first_letter,
                    &[(kind, Vec3::ONE)],
                    other,
                    |_, _, _| {
                        is_some = true;
                    },
                );
            }
        }
        is_some
    }

    /// The share of a path of a walk that ends at the start of another, which reads `first` there.
    fn reach(&self, edits: &Edits<'_>, first: u32) -> Rgb {
        let state = edits.automaton(1 - self.flow).after(START, first);
        let wanted = self.pairs().iter().filter(|p| p.wanted >> state & 1 != 0);
        wanted.fold(Vec3::ZERO, |sum, pair| sum + pair.weight)
    }

    /// The share of a path from the sensor that ends at an emitter.
    pub fn reach_emitter(&self, edits: &Edits<'_>, emitter: u32) -> Rgb {
        if emitter == NONE {
            return Vec3::ZERO;
        }
        self.reach(edits, edits.words.emitters[emitter as usize])
    }

    /// The share of a path from an emitter that ends at the sensor.
    pub fn reach_sensor(&self, edits: &Edits<'_>) -> Rgb {
        self.reach(edits, edits.words.sensor)
    }

    /// The share of a path of two walks that have read all of it together.
    pub fn join(&self, other: &EditStates) -> Rgb {
        let mut sum = Vec3::ZERO;
        for a in self.pairs() {
            for b in other.pairs() {
                if a.wanted >> b.state & 1 != 0 && b.wanted >> a.state & 1 != 0 {
                    sum += a.weight * b.weight;
                }
            }
        }
        sum
    }
}

/// Kinds of scattering and their shares.
fn kinds(scattered: &Scattered) -> [(u32, Rgb); 2] {
    let side = u32::from(scattered.is_transmitted);
    if scattered.is_specular {
        let kind = scattering::SPECULAR_REFLECTION + side;
        return [(kind, Vec3::ONE), (kind, Vec3::ZERO)];
    }
    [
        (scattering::DIFFUSE_REFLECTION + side, scattered.diffuse),
        (
            scattering::GLOSSY_REFLECTION + side,
            Vec3::ONE - scattered.diffuse,
        ),
    ]
}
