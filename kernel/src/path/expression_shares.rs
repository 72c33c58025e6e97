//! What path expressions get of the light of a path: bits of the expressions that match, and shares per channel.
//!
//! A path belongs to several sets with a share each where a material scatters diffusely and glossily into the same direction
//! ([`super::path_states`]). With f_D the diffuse part of the BSDF f, each state of a walk which scatters once and ends at an emitter
//! has two of them: f_D / f and 1 - f_D / f.
//!
//! Invariant (tests): the shares of expressions that divide the paths among them sum to one, to rounding.

use super::expression::MAX_PARTS;
use crate::math::Rgb;
use glam::Vec3;

/// Most sets: two for each state of a walk.
pub const MOST_MATCHES: usize = 32;

/// What a walk from the sensor matches where it is lit: sets of expressions, as bits, each with its share of the light. They are kept
/// until it is known whether the emitter is visible.
#[derive(Clone, Copy, Debug)]
pub struct EmitterMatches {
    count: u32,
    entries: [(u32, Rgb); MOST_MATCHES],
}

impl EmitterMatches {
    /// Nothing matches.
    pub const NONE: EmitterMatches = EmitterMatches {
        count: 0,
        entries: [(0, Vec3::ZERO); MOST_MATCHES],
    };

    /// Forgets all.
    #[inline]
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Whether nothing matches.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Adds the share of the expressions whose bits are set.
    #[inline]
    pub fn add(&mut self, bits: u32, weight: Rgb) {
        let i = self.count as usize;
        if bits != 0 && weight.max_element() > 0.0 && i < MOST_MATCHES {
            self.entries[i] = (bits, weight);
            self.count += 1;
        }
    }

    /// Number of sets.
    #[inline]
    pub fn len(&self) -> usize {
        (self.count as usize).min(MOST_MATCHES)
    }

    /// Bits and share of set `i`.
    #[inline]
    pub fn get(&self, i: usize) -> (u32, Rgb) {
        self.entries[i]
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
