//! Counter-based random numbers and Owen-scrambled Sobol' points.
//!
//! Every number is a function of (seed, pixel, sample, dimension) made of 32-bit integer operations only, so that an
//! image does not depend on threads, tiles or interruptions, and CPU and GPU draw the same numbers. A sampler is the
//! counter: drawing a number advances the dimension.
//!
//! - [`IndependentSampler`] hashes the counter.
//! - [`SobolSampler`] takes Owen-scrambled Sobol' points.
//! - [`AnySampler`] is either of them, as plain data.
//! - `PrimarySamples` are those of a Metropolis chain (hosts only).
//!
//! Invariants (tests): numbers lie in [0, 1) and are uniform (chi-square); neighbouring seeds, pixels, samples and
//! dimensions are uncorrelated.

mod any;
mod hash;
mod independent;
#[cfg(not(target_arch = "spirv"))]
pub mod primary;
mod sobol;

pub use any::{AnySampler, sampler_kind};
pub use hash::{mix, to_unit_interval};
pub use independent::IndependentSampler;
#[cfg(not(target_arch = "spirv"))]
pub use primary::{FreshSamples, PrimarySamples};
pub use sobol::SobolSampler;

use bytemuck::Zeroable;
use glam::Vec2;

/// A stream of numbers in [0, 1) for one sample of one pixel or chain.
pub trait Sampler {
    /// The next number in [0, 1).
    fn next_1d(&mut self) -> f32;
    /// The next point in [0, 1)^2, well distributed over the samples of the pixel where the sampler can.
    #[inline]
    fn next_2d(&mut self) -> Vec2 {
        let x = self.next_1d();
        let y = self.next_1d();
        Vec2::new(x, y)
    }
    /// Says that what follows is of this bounce, counted from zero: a chain keeps the numbers of each bounce together. Others
    /// do not care.
    #[inline(always)]
    fn start_bounce(&mut self, _bounce: u32) {}
}

/// A sampler that is four words, for lanes side by side.
pub trait LaneSampler: Sampler + Copy + Zeroable {
    /// The words.
    fn to_words(self) -> [u32; 4];
    /// The sampler of the words.
    fn from_words(words: [u32; 4]) -> Self;
}
