//! Vectors of primary samples for Metropolis chains, mutated when they are asked for.
//!
//! A path is a function of numbers in [0, 1); a chain in the space of those numbers changes them a little ("small step") or
//! draws all anew ("large step"; Kelemen et al. 2002, "A simple and robust mutation strategy for the Metropolis light
//! transport algorithm"). A small step moves each number by
//!
//! ```text
//! +- s2 exp(-ln(s2 / s1) u),   s1 = 1/1024, s2 = 1/64,   modulo 1,
//! ```
//!
//! a density that is the same in both directions. How many numbers a path needs is known only when it is traced, so a number that nobody
//! has asked for since some steps catches up with what it missed: the large step after it was last set, then each small
//! one. Every draw is a hash of (chain, step, dimension), so the chain is the same whenever a number is asked for.
//!
//! Numbers are counted in blocks, one for each bounce ([`Sampler::start_bounce`]), so that a bounce which draws fewer does not
//! shift those of the next. Beyond [`CAPACITY`] they come from the last large step alone, which leaves the target distribution
//! as it is. Hosts only: a shader has no storage for such arrays.
//!
//! Invariants (tests): values are uniform after any number of accepted steps, forward and reverse density of a small step are
//! the same, a rejected step leaves no trace.

use super::Sampler;
use super::hash::{hashed, keys, to_unit_interval};
use crate::math::float;

/// Numbers that are kept: those of 64 bounces.
pub const CAPACITY: usize = 512;

/// Numbers of a bounce.
pub const BLOCK: u32 = 8;

/// Smallest change of a small step.
const SMALLEST: f32 = 1.0 / 1024.0;

/// Largest change of a small step.
const LARGEST: f32 = 1.0 / 64.0;

/// ln(s2 / s1) = ln 16.
const LOG_RATIO: f32 = 4.0 * core::f32::consts::LN_2;

/// Tells numbers that catch up from those of proposals.
const MISSED: u32 = 0x8f1b_bcdc;

/// Uniform numbers drawn all at once: those of a large step, or of a path that is not yet part of a chain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FreshSamples {
    key0: u32,
    key1: u32,
    next: u32,
}

impl FreshSamples {
    /// Those of `step` of `chain`.
    #[inline]
    pub fn new(seed: u32, chain: u32, step: u32) -> FreshSamples {
        let (key0, key1) = keys(seed, chain, step);
        FreshSamples {
            key0,
            key1,
            next: 0,
        }
    }

    /// The number of a dimension.
    #[inline]
    pub fn number(&self, dimension: u32) -> f32 {
        to_unit_interval(hashed(self.key0, self.key1, dimension))
    }
}

impl Sampler for FreshSamples {
    #[inline]
    fn next_1d(&mut self) -> f32 {
        let number = self.number(self.next);
        self.next = self.next.wrapping_add(1);
        number
    }

    #[inline]
    fn start_bounce(&mut self, bounce: u32) {
        self.next = block_start(self.next, bounce);
    }
}

/// Where the numbers of a bounce begin: what comes before the first has the first block, and a bounce that drew more than its
/// block does not give the same numbers to the next.
#[inline]
fn block_start(next: u32, bounce: u32) -> u32 {
    next.max(bounce.saturating_add(1).saturating_mul(BLOCK))
}

/// A vector of primary samples, the chain's current one and the proposed.
#[derive(Clone, Debug)]
pub struct PrimarySamples {
    value: [f32; CAPACITY],
    /// Accepted steps when the value was set.
    time: [u32; CAPACITY],
    proposed: [f32; CAPACITY],
    /// The step that last proposed a value.
    asked: [u32; CAPACITY],
    /// Accepted steps so far; values of time zero are those of the start.
    now: u32,
    /// The last accepted large step, or the start.
    large: FreshSamples,
    large_time: u32,
    /// The chain's own stream.
    seed: u32,
    chain: u32,
    /// The step that is being proposed, counted from one.
    step: u32,
    fresh: FreshSamples,
    is_large: bool,
    /// Whether the current vector is handed out.
    is_repeated: bool,
    /// Width of small steps over the usual one.
    width: f32,
    /// The next number, and one more than the last that was asked for and kept.
    next: u32,
    end: u32,
}

impl PrimarySamples {
    /// A chain with the stream of `seed` and `chain` that stands at the numbers of `start`.
    pub fn new(start: FreshSamples, seed: u32, chain: u32) -> PrimarySamples {
        PrimarySamples {
            value: [0.0; CAPACITY],
            time: [0; CAPACITY],
            proposed: [0.0; CAPACITY],
            asked: [0; CAPACITY],
            now: 1,
            large: start,
            large_time: 1,
            seed,
            chain,
            step: 0,
            fresh: start,
            is_large: false,
            is_repeated: false,
            width: 1.0,
            next: 0,
            end: 0,
        }
    }

    /// Makes small steps so many times as wide as usual, less than 32.
    #[inline]
    pub fn set_width(&mut self, width: f32) {
        self.width = width;
    }

    /// Begins to propose a step.
    #[inline]
    pub fn propose(&mut self, is_large: bool) {
        self.step += 1;
        self.fresh = FreshSamples::new(self.seed, self.chain, self.step);
        self.is_large = is_large;
        self.is_repeated = false;
        self.next = 0;
        self.end = 0;
    }

    /// Begins to hand out the current vector once more, instead of a proposal.
    #[inline]
    pub fn repeat(&mut self) {
        self.is_repeated = true;
        self.next = 0;
        self.end = 0;
    }

    /// Makes the proposal the current vector. A proposal that is not accepted is forgotten by the next.
    pub fn accept(&mut self) {
        self.now += 1;
        if self.is_large {
            self.large = self.fresh;
            self.large_time = self.now;
        }
        for d in 0..self.end as usize {
            if self.asked[d] == self.step {
                self.value[d] = self.proposed[d];
                self.time[d] = self.now;
            }
        }
    }

    /// Whether the step that is being proposed draws all anew.
    #[inline]
    pub fn is_large(&self) -> bool {
        self.is_large
    }

    /// Number `dimension` of the current vector.
    pub fn current(&mut self, dimension: u32) -> f32 {
        let d = dimension as usize;
        if d >= CAPACITY {
            return self.large.number(dimension);
        }
        if self.time[d] < self.large_time {
            self.value[d] = self.large.number(dimension);
            self.time[d] = self.large_time;
        }
        while self.time[d] < self.now {
            self.time[d] += 1;
            let missed = FreshSamples::new(self.seed ^ MISSED, self.chain, self.time[d]);
            self.value[d] = perturbed(self.value[d], missed.number(dimension), self.width);
        }
        self.value[d]
    }

    /// Number `dimension` of the proposed vector; small steps do not change those from [`CAPACITY`] on.
    pub fn number(&mut self, dimension: u32) -> f32 {
        if self.is_repeated {
            return self.current(dimension);
        }
        let d = dimension as usize;
        if d >= CAPACITY {
            return if self.is_large {
                self.fresh.number(dimension)
            } else {
                self.large.number(dimension)
            };
        }
        let u = self.fresh.number(dimension);
        let proposed = if self.is_large {
            u
        } else {
            perturbed(self.current(dimension), u, self.width)
        };
        self.proposed[d] = proposed;
        self.asked[d] = self.step;
        let end = dimension + 1;
        if end > self.end {
            self.end = end;
        }
        proposed
    }
}

impl Sampler for PrimarySamples {
    #[inline]
    fn next_1d(&mut self) -> f32 {
        let dimension = self.next;
        self.next += 1;
        self.number(dimension)
    }

    #[inline]
    fn start_bounce(&mut self, bounce: u32) {
        self.next = block_start(self.next, bounce);
    }
}

/// The number `value` moved by a small step that the number `u` chooses, `width` times as far as usual.
#[inline]
pub fn perturbed(value: f32, u: f32, width: f32) -> f32 {
    let is_up = u < 0.5;
    let u = if is_up { 2.0 * u } else { 2.0 * u - 1.0 };
    let change = width * LARGEST * float::exp(-LOG_RATIO * u);
    debug_assert!(change >= 0.99 * width * SMALLEST && change < 0.5);
    let moved = if is_up {
        value + change
    } else {
        value - change
    };
    let wrapped = if moved >= 1.0 {
        moved - 1.0
    } else if moved < 0.0 {
        moved + 1.0
    } else {
        moved
    };
    // Rounding may reach one.
    if wrapped < 1.0 { wrapped } else { 0.0 }
}
