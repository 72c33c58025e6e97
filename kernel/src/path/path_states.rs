//! Walks that read path expressions: the states of the automaton along a walk, and the parts of a path's light.
//!
//! Where a material scatters diffusely and glossily into the same direction, a path belongs to several sets of paths, to each
//! with a share of its light per channel. A walk therefore carries weights over the automaton's states ([`PathStates`]), which
//! sum to one: at every vertex the weight of a state is divided by f_D / f and f_G / f ([`crate::bsdf::Bsdf::diffuse_share`]) and moved on.
//! Most materials do one of both, and most walks have one state. A discrete event is specular. Reflection and transmission are
//! distinguished by the shading normal.
//!
//! Everything here depends on the path alone, so that all algorithms divide an image alike (but for materials that are not
//! reciprocal, whose shares a walk takes for its own direction). Invariant (tests): expressions that divide the paths among
//! them divide every contribution, to rounding.

use super::evaluation::Interaction;
use super::expression::{Automaton, DEAD, PathExpressions, START, scattering};
use super::expression_shares::{EmitterMatches, MOST_MATCHES, Shares, add_to_parts};
use super::scattered::Scattered;
use crate::math::Rgb;
use crate::scene::{NONE, SurfacePoint};
use glam::Vec3;

/// Most states that a walk can be in. A front end makes sure that it is enough for its expressions.
pub const CAPACITY: usize = 16;

const _: () = assert!(MOST_MATCHES >= 2 * CAPACITY);

impl Scattered {
    /// Scattering of a walk into the unit world `direction` at the end of a connection.
    #[inline]
    pub fn towards(at: &Interaction<'_>, data: &[f32], direction: Vec3) -> Scattered {
        let wo = at.effective(direction);
        Scattered::smooth(at.bsdf, data, at.wi, wo)
    }
}

/// Weights over the states of an automaton that a walk may be in.
#[derive(Clone, Copy, Debug)]
pub struct PathStates {
    count: u32,
    /// States and their weights, side by side: most walks read the first alone.
    entries: [(u32, Rgb); CAPACITY],
}

impl PathStates {
    /// No state: nothing matches any more.
    pub const DEAD: PathStates = PathStates {
        count: 0,
        entries: [(DEAD, Vec3::ZERO); CAPACITY],
    };

    /// In one state.
    #[inline]
    fn one(state: u32) -> PathStates {
        let mut states = PathStates::DEAD;
        states.add(state, Vec3::ONE);
        states
    }

    /// Of a walk that starts at the sensor.
    #[inline]
    pub fn at_sensor(expressions: &PathExpressions<'_>) -> PathStates {
        let automaton = &expressions.from_sensor;
        PathStates::one(automaton.after(START, expressions.sensor))
    }

    /// In one state, in place, without a copy of the whole array.
    #[inline]
    pub fn restart(&mut self, state: u32) {
        self.count = (state != DEAD) as u32;
        self.entries[0] = (state, Vec3::ONE);
    }

    /// Of a walk that starts at an emitter.
    #[inline]
    pub fn at_emitter(expressions: &PathExpressions<'_>, emitter: u32) -> PathStates {
        if emitter == NONE {
            return PathStates::DEAD;
        }
        let letter = expressions.emitters[emitter as usize];
        PathStates::one(expressions.from_light.after(START, letter))
    }

    /// Whether no expression can match any more, however the walk goes on.
    #[inline]
    pub fn is_dead(&self) -> bool {
        self.count == 0
    }

    /// Adds weight to a state; the dead state carries no weight.
    #[inline]
    fn add(&mut self, state: u32, weight: Rgb) {
        if state == DEAD || !(weight.max_element() > 0.0) {
            return;
        }
        for i in 0..self.count as usize {
            if self.entries[i].0 == state {
                self.entries[i].1 += weight;
                return;
            }
        }
        let i = self.count as usize;
        if i < CAPACITY {
            self.entries[i] = (state, weight);
            self.count += 1;
        }
    }

    /// The states behind a vertex at which the walk scattered; `automaton` is the one that the walk reads.
    #[inline]
    #[must_use]
    pub fn after(
        &self,
        expressions: &PathExpressions<'_>,
        automaton: &Automaton<'_>,
        point: &SurfacePoint,
        scattered: &Scattered,
    ) -> PathStates {
        self.after_at(
            expressions,
            automaton,
            expressions.first_letter(point),
            scattered,
        )
    }

    /// The same at a [`PathExpressions::first_letter`].
    #[inline]
    #[must_use]
    pub fn after_at(
        &self,
        expressions: &PathExpressions<'_>,
        automaton: &Automaton<'_>,
        first_letter: u32,
        scattered: &Scattered,
    ) -> PathStates {
        let mut next = PathStates::DEAD;
        for i in 0..self.count as usize {
            next.step(
                expressions,
                automaton,
                first_letter,
                scattered,
                self.entries[i],
            );
        }
        next
    }

    /// [`PathStates::after`] in place.
    #[inline]
    pub fn advance(
        &mut self,
        expressions: &PathExpressions<'_>,
        automaton: &Automaton<'_>,
        point: &SurfacePoint,
        scattered: &Scattered,
    ) {
        self.advance_at(
            expressions,
            automaton,
            expressions.first_letter(point),
            scattered,
        );
    }

    /// The same at a [`PathExpressions::first_letter`]: what most walks need of it, one or two states and few kinds of scattering, at little
    /// cost.
    #[inline]
    pub fn advance_at(
        &mut self,
        expressions: &PathExpressions<'_>,
        automaton: &Automaton<'_>,
        first_letter: u32,
        scattered: &Scattered,
    ) {
        let kind = scattered.kind();
        if kind != NONE && self.count == 1 {
            let letter = expressions.letter(first_letter, kind);
            let state = automaton.after(self.entries[0].0, letter);
            self.entries[0].0 = state;
            self.count = (state != DEAD) as u32;
            return;
        }
        if self.count > 2 {
            *self = self.after_at(expressions, automaton, first_letter, scattered);
            return;
        }
        let before = [self.entries[0], self.entries[1]];
        let count = self.count as usize;
        self.count = 0;
        for i in 0..count {
            self.step(expressions, automaton, first_letter, scattered, before[i]);
        }
    }

    /// Adds what a state and its weight come to at a vertex.
    #[inline]
    fn step(
        &mut self,
        expressions: &PathExpressions<'_>,
        automaton: &Automaton<'_>,
        first_letter: u32,
        scattered: &Scattered,
        (state, weight): (u32, Rgb),
    ) {
        let side = u32::from(scattered.is_transmitted);
        let mut step = |kind: u32, share: Rgb| {
            let letter = expressions.letter(first_letter, kind + side);
            self.add(automaton.after(state, letter), weight * share);
        };
        if scattered.is_specular {
            step(scattering::SPECULAR_REFLECTION, Vec3::ONE);
        } else {
            step(scattering::DIFFUSE_REFLECTION, scattered.diffuse);
            step(scattering::GLOSSY_REFLECTION, Vec3::ONE - scattered.diffuse);
        }
    }

    /// All states behind a vertex at which the walk scattered by a letter.
    #[inline]
    pub fn advance_by(&mut self, automaton: &Automaton<'_>, letter: u32) {
        let count = self.count as usize;
        self.count = 0;
        // What is added lies in front of what is left to read.
        for i in 0..count {
            let (state, weight) = self.entries[i];
            self.add(automaton.after(state, letter), weight);
        }
    }

    /// The same by two letters, with the share of the first.
    #[inline]
    pub fn advance_by_two(&mut self, automaton: &Automaton<'_>, letters: [u32; 2], share: Rgb) {
        let step = |states: &mut PathStates, (state, weight): (u32, Rgb)| {
            states.add(automaton.after(state, letters[0]), weight * share);
            states.add(
                automaton.after(state, letters[1]),
                weight * (Vec3::ONE - share),
            );
        };
        // Most have one state or two: no copy of the whole array.
        if self.count <= 2 {
            let (before, count) = ([self.entries[0], self.entries[1]], self.count as usize);
            self.count = 0;
            (0..count).for_each(|i| step(self, before[i]));
        } else {
            let before = *self;
            self.count = 0;
            (0..before.count as usize).for_each(|i| step(self, before.entries[i]));
        }
    }

    /// Adds what a walk from the sensor matches that scatters by a letter, with a share, and then ends at an emitter of the letter
    /// `last`.
    #[inline]
    pub fn match_emitter(
        &self,
        automaton: &Automaton<'_>,
        letter: u32,
        share: Rgb,
        last: u32,
        matches: &mut EmitterMatches,
    ) {
        for i in 0..self.count as usize {
            let (state, weight) = self.entries[i];
            let bits = automaton.matched_with(automaton.after(state, letter), last);
            matches.add(bits, weight * share);
        }
    }

    /// Calls `add` with bits of expressions and their share where a walk from the sensor ends at an emitter.
    #[inline]
    pub fn for_shares(
        &self,
        expressions: &PathExpressions<'_>,
        emitter: u32,
        mut add: impl FnMut(u32, Rgb),
    ) {
        if emitter == NONE {
            return;
        }
        let letter = expressions.emitters[emitter as usize];
        for i in 0..self.count as usize {
            let (state, weight) = self.entries[i];
            add(expressions.from_sensor.matched_with(state, letter), weight);
        }
    }

    /// Adds the parts of `light` to sums where a walk from the sensor ends at an emitter.
    #[inline]
    pub fn divide(
        &self,
        expressions: &PathExpressions<'_>,
        emitter: u32,
        light: Rgb,
        sums: &mut [Rgb],
    ) {
        self.for_shares(expressions, emitter, |bits, weight| {
            add_to_parts(bits, light * weight, sums);
        });
    }

    /// Shares of the expressions in a walk from the sensor that ends at an emitter.
    #[inline]
    pub fn reach_emitter(&self, expressions: &PathExpressions<'_>, emitter: u32) -> Shares {
        let mut shares = Shares::NONE;
        self.for_shares(expressions, emitter, |bits, weight| {
            shares.add(expressions.count, bits, weight);
        });
        shares
    }

    /// Shares of the expressions in a walk from an emitter that ends at the sensor.
    #[inline]
    pub fn reach_sensor(&self, expressions: &PathExpressions<'_>) -> Shares {
        let mut shares = Shares::NONE;
        for i in 0..self.count as usize {
            let (state, weight) = self.entries[i];
            let bits = expressions
                .from_light
                .matched_with(state, expressions.sensor);
            shares.add(expressions.count, bits, weight);
        }
        shares
    }

    /// Shares of the expressions in a path of a walk from an emitter, `self`, and of one from the sensor.
    #[inline]
    pub fn join(&self, expressions: &PathExpressions<'_>, sensor: &PathStates) -> Shares {
        let mut shares = Shares::NONE;
        for i in 0..self.count as usize {
            for j in 0..sensor.count as usize {
                let (a, b) = (self.entries[i], sensor.entries[j]);
                let bits = expressions.joined(a.0, b.0);
                shares.add(expressions.count, bits, a.1 * b.1);
            }
        }
        shares
    }
}
