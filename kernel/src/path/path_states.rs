//! Walks that read path expressions: the states of the automaton along a walk, and the parts of a path's light.
//!
//! Where a material scatters diffusely and glossily into the same direction, a path belongs to several sets of paths, to each
//! with a share of its light per channel. A walk therefore carries weights over the automaton's states ([`PathStates`]), which
//! sum to one: at every vertex the weight of a state is divided by f_D / f and f_G / f ([`Bsdf::diffuse_share`]) and moved on.
//! Most materials do one of both, and most walks have one state. A discrete event is specular. Reflection and transmission are
//! told apart by the shading normal.
//!
//! Everything here depends on the path alone, so that all algorithms divide an image alike (but for materials that are not
//! reciprocal, whose shares a walk takes for its own direction). Invariant (tests): expressions that divide the paths among
//! them divide every contribution, to rounding.

use super::evaluation::Interaction;
use super::expression::{Automaton, DEAD, MAX_PARTS, PathExpressions, START, scattering};
use crate::bsdf::{Bsdf, event};
use crate::math::Rgb;
use crate::scene::{NONE, SurfacePoint};
use glam::Vec3;

/// Most states that a walk can be in. A front end makes sure that it is enough for its expressions.
pub const CAPACITY: usize = 16;

/// What happens at a vertex, for expressions.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// Whether it is a discrete event.
    pub is_specular: bool,
    /// Whether light passes to the other side.
    pub is_transmitted: bool,
    /// Share of diffuse scattering in what is no discrete event.
    pub diffuse: Rgb,
}

impl Scattered {
    /// A discrete event, with its bits of [`event`].
    #[inline]
    pub fn specular(bits: u32) -> Scattered {
        Scattered {
            is_specular: true,
            is_transmitted: bits & event::TRANSMISSION != 0,
            diffuse: Vec3::ZERO,
        }
    }

    /// Scattering that is no discrete event, by the smooth part of a BSDF between two local directions.
    #[inline]
    pub fn smooth(bsdf: &Bsdf, data: &[f32], wi: Vec3, wo: Vec3) -> Scattered {
        Scattered {
            is_specular: false,
            is_transmitted: wi.z * wo.z < 0.0,
            diffuse: bsdf.diffuse_share(data, wi, wo),
        }
    }

    /// A sample of a BSDF towards the local direction `wo`, with its bits of [`event`].
    #[inline]
    pub fn sampled(bsdf: &Bsdf, data: &[f32], wi: Vec3, wo: Vec3, bits: u32) -> Scattered {
        if bits & event::DELTA != 0 {
            Scattered::specular(bits)
        } else {
            Scattered::smooth(bsdf, data, wi, wo)
        }
    }

    /// The kind of [`scattering`], if there is but one; [`NONE`] for diffuse and glossy at once.
    #[inline]
    pub fn kind(&self) -> u32 {
        let kind = if self.is_specular {
            scattering::SPECULAR_REFLECTION
        } else if self.diffuse == Vec3::ONE {
            scattering::DIFFUSE_REFLECTION
        } else if self.diffuse == Vec3::ZERO {
            scattering::GLOSSY_REFLECTION
        } else {
            return NONE;
        };
        kind + self.is_transmitted as u32
    }

    /// Scattering of a walk into the unit world `direction` at the end of a connection.
    #[inline]
    pub fn towards(at: &Interaction<'_>, data: &[f32], direction: Vec3) -> Scattered {
        let wo = at.point.frame.to_local(direction);
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

    /// Adds weight to a state; there is nothing to know of the dead one.
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
        let mut next = PathStates::DEAD;
        if self.count == 0 {
            return next;
        }
        let place = expressions.place(point);
        let side = u32::from(scattered.is_transmitted);
        for i in 0..self.count as usize {
            let (state, weight) = self.entries[i];
            let mut step = |kind: u32, share: Rgb| {
                let letter = expressions.letter(place, kind + side);
                next.add(automaton.after(state, letter), weight * share);
            };
            if scattered.is_specular {
                step(scattering::SPECULAR_REFLECTION, Vec3::ONE);
            } else {
                step(scattering::DIFFUSE_REFLECTION, scattered.diffuse);
                step(scattering::GLOSSY_REFLECTION, Vec3::ONE - scattered.diffuse);
            }
        }
        next
    }

    /// [`PathStates::after`] in place: what most walks need of it, one state and one kind of scattering, at little cost.
    #[inline]
    pub fn advance(
        &mut self,
        expressions: &PathExpressions<'_>,
        automaton: &Automaton<'_>,
        point: &SurfacePoint,
        scattered: &Scattered,
    ) {
        let kind = scattered.kind();
        if self.count != 1 || kind == NONE {
            *self = self.after(expressions, automaton, point, scattered);
            return;
        }
        let letter = expressions.letter(expressions.place(point), kind);
        let state = automaton.after(self.entries[0].0, letter);
        self.entries[0].0 = state;
        self.count = (state != DEAD) as u32;
    }

    /// Bits of the expressions that match a walk from the sensor which is in one state, scatters in one way, and then ends at
    /// an emitter; false if there is more to it.
    #[inline]
    pub fn lit_by(
        &self,
        expressions: &PathExpressions<'_>,
        point: &SurfacePoint,
        scattered: &Scattered,
        emitter: u32,
    ) -> (bool, u32) {
        let kind = scattered.kind();
        if self.count != 1 || kind == NONE || emitter == NONE {
            return (false, 0);
        }
        let automaton = &expressions.from_sensor;
        let letter = expressions.letter(expressions.place(point), kind);
        let state = automaton.after(self.entries[0].0, letter);
        let last = expressions.emitters[emitter as usize];
        (true, automaton.matched_with(state, last))
    }

    /// Weight of the one state.
    #[inline]
    pub fn weight(&self) -> Rgb {
        self.entries[0].1
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
        if emitter == NONE {
            return;
        }
        let letter = expressions.emitters[emitter as usize];
        for i in 0..self.count as usize {
            let (state, weight) = self.entries[i];
            let bits = expressions.from_sensor.matched_with(state, letter);
            add_to_parts(bits, light * weight, sums);
        }
    }

    /// Shares of the expressions in a walk from the sensor that ends at an emitter.
    #[inline]
    pub fn reach_emitter(&self, expressions: &PathExpressions<'_>, emitter: u32) -> Shares {
        let mut shares = Shares::NONE;
        if emitter == NONE {
            return shares;
        }
        let letter = expressions.emitters[emitter as usize];
        for i in 0..self.count as usize {
            let (state, weight) = self.entries[i];
            let bits = expressions.from_sensor.matched_with(state, letter);
            shares.add(expressions.count, bits, weight);
        }
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

/// The share of each expression in the light of a path, per channel.
#[derive(Clone, Copy, Debug)]
pub struct Shares {
    parts: [Rgb; MAX_PARTS],
    /// Bits of those that are not zero.
    bits: u32,
}

impl Shares {
    /// Of none.
    pub const NONE: Shares = Shares {
        parts: [Vec3::ZERO; MAX_PARTS],
        bits: 0,
    };

    #[inline]
    fn add(&mut self, count: u32, bits: u32, weight: Rgb) {
        if bits == 0 {
            return;
        }
        self.bits |= bits;
        for part in 0..(count as usize).min(MAX_PARTS) {
            if bits >> part & 1 != 0 {
                self.parts[part] += weight;
            }
        }
    }

    /// Whether no expression has a share.
    #[inline]
    pub fn is_none(&self) -> bool {
        self.bits == 0
    }

    /// The share of an expression.
    #[inline]
    pub fn of(&self, part: usize) -> Rgb {
        self.parts[part]
    }
}

/// Adds light to the sums of the expressions whose bits are set.
#[inline]
pub fn add_to_parts(bits: u32, light: Rgb, sums: &mut [Rgb]) {
    if bits == 0 {
        return;
    }
    for part in 0..sums.len() {
        if bits >> part & 1 != 0 {
            sums[part] += light;
        }
    }
}
