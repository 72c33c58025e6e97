//! What path expressions get of the light of a path: bits of the expressions that match, and shares per channel.
//!
//! A path belongs to several sets with a share each where a material scatters diffusely and glossily into the same direction
//! ([`super::path_states`]). With f_D the diffuse part of the BSDF f, a walk in one state which scatters once and ends at an emitter
//! has only two of them: f_D / f and 1 - f_D / f.
//!
//! Invariant (tests): the shares of expressions that divide the paths among them sum to one, to rounding.

use super::expression::{MAX_PARTS, PathExpressions, scattering};
use super::scattered::Scattered;
use crate::math::Rgb;
use crate::scene::NONE;
use glam::Vec3;

/// The expressions that a walk with one state matches where it is lit: those of diffuse scattering, or of the only kind that
/// there is, and those of glossy scattering into the same direction.
#[derive(Clone, Copy, Debug)]
pub struct EmitterMatches {
    /// Whether the rest says it.
    pub is_known: bool,
    /// Bits of the expressions.
    pub bits: u32,
    /// Their share.
    pub weight: Rgb,
    /// Bits of those of what is glossy.
    pub glossy_bits: u32,
    /// Their share.
    pub glossy_weight: Rgb,
}

impl EmitterMatches {
    /// It is not known.
    pub const NONE: EmitterMatches = EmitterMatches {
        is_known: false,
        bits: 0,
        weight: Vec3::ZERO,
        glossy_bits: 0,
        glossy_weight: Vec3::ZERO,
    };

    /// Of a walk in a state with a weight, at a [`PathExpressions::first_letter`].
    #[inline]
    pub fn of(
        expressions: &PathExpressions<'_>,
        (state, weight): (u32, Rgb),
        first_letter: u32,
        scattered: &Scattered,
        emitter: u32,
    ) -> EmitterMatches {
        let automaton = &expressions.from_sensor;
        let last = expressions.emitters[emitter as usize];
        let kind = scattered.kind();
        if kind != NONE {
            let next = automaton.after(state, expressions.letter(first_letter, kind));
            return EmitterMatches {
                is_known: true,
                bits: automaton.matched_with(next, last),
                weight,
                glossy_bits: 0,
                glossy_weight: Vec3::ZERO,
            };
        }
        let side = scattered.is_transmitted as u32;
        let diffuse = expressions.letter(first_letter, scattering::DIFFUSE_REFLECTION + side);
        let glossy = expressions.letter(first_letter, scattering::GLOSSY_REFLECTION + side);
        EmitterMatches {
            is_known: true,
            bits: automaton.matched_with(automaton.after(state, diffuse), last),
            weight: weight * scattered.diffuse,
            glossy_bits: automaton.matched_with(automaton.after(state, glossy), last),
            glossy_weight: weight * (Vec3::ONE - scattered.diffuse),
        }
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

    /// Of light that has been divided into parts already.
    pub fn of_parts(whole: Rgb, parts: &[Rgb]) -> Shares {
        let mut shares = Shares::NONE;
        for part in 0..parts.len() {
            let light = parts[part];
            if light.max_element() > 0.0 {
                let share = |part: f32, whole: f32| if whole > 0.0 { part / whole } else { 0.0 };
                shares.parts[part] = Vec3::new(
                    share(light.x, whole.x),
                    share(light.y, whole.y),
                    share(light.z, whole.z),
                );
                shares.bits |= 1 << part;
            }
        }
        shares
    }

    /// Adds a share to the first `count` expressions whose bits are set.
    #[inline]
    pub(super) fn add(&mut self, count: u32, bits: u32, weight: Rgb) {
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
