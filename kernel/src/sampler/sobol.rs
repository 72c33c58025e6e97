//! Owen-scrambled Sobol' points.
//!
//! Two-dimensional Sobol' points (a (0,2)-sequence in base 2), scrambled in the sense of Owen by a hash and padded over
//! pairs of dimensions by shuffling the order of the points (Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4)).
//! Invariant (tests): of the first 2^k points of a pixel each elementary interval of area 2^-k holds exactly one.

use super::hash::{GOLDEN, hashed, keys, mix, to_unit_interval};
use super::{LaneSampler, Sampler};
use bytemuck::{Pod, Zeroable};
use glam::Vec2;

/// Flips each bit of `x` depending on the lower bits and the seed: Owen scrambling for words whose bits are reversed
/// (Laine and Karras 2011; this form and its constants: Vegdahl 2021, "Building a Better LK Hash", which removes the
/// bias of the original's).
#[inline]
fn scramble_reversed(x: u32, seed: u32) -> u32 {
    let mut x = x;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The second Sobol' dimension of `index` with its bits reversed: Pascal's triangle modulo 2 times the bits of the
/// index, as the five factors of the matrix (a Kronecker power of [[1, 1], [0, 1]]).
#[inline]
fn sobol_second_reversed(index: u32) -> u32 {
    let mut x = index;
    x ^= (x & 0xaaaa_aaaa) >> 1;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^ (x >> 16)
}

/// Owen-scrambled Sobol' points.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct SobolSampler {
    pub(super) key0: u32,
    pub(super) key1: u32,
    /// The sample's number with its bits reversed.
    pub(super) index: u32,
    pub(super) dimension: u32,
}

impl SobolSampler {
    /// Point number `sample` of a pixel's own scrambled sequence.
    #[inline]
    pub fn new(seed: u32, pixel: u32, sample: u32) -> SobolSampler {
        // Not the sample: all samples of a pixel belong to one sequence.
        let (key0, key1) = keys(seed, pixel, 0x3c6e_f372);
        SobolSampler {
            key0,
            key1,
            index: sample.reverse_bits(),
            dimension: 0,
        }
    }

    #[inline]
    pub(super) fn advance(&mut self) -> u32 {
        let key = hashed(self.key0, self.key1, self.dimension);
        self.dimension = self.dimension.wrapping_add(1);
        key
    }
}

impl Sampler for SobolSampler {
    #[inline]
    fn next_1d(&mut self) -> f32 {
        let key = self.advance();
        // The order of points is shuffled as a tree: blocks of 2^k samples stay blocks.
        let index = scramble_reversed(self.index, key).reverse_bits();
        // The first Sobol' dimension reverses the bits of the index, which is the form the scrambling takes.
        to_unit_interval(scramble_reversed(index, mix(key ^ GOLDEN)).reverse_bits())
    }

    #[inline]
    fn next_2d(&mut self) -> Vec2 {
        let key = self.advance();
        let index = scramble_reversed(self.index, key).reverse_bits();
        let key_x = mix(key ^ GOLDEN);
        let key_y = mix(key_x ^ GOLDEN);
        let x = scramble_reversed(index, key_x);
        let y = scramble_reversed(sobol_second_reversed(index), key_y);
        Vec2::new(
            to_unit_interval(x.reverse_bits()),
            to_unit_interval(y.reverse_bits()),
        )
    }
}

impl LaneSampler for SobolSampler {
    #[inline(always)]
    fn to_words(self) -> [u32; 4] {
        [self.key0, self.key1, self.index, self.dimension]
    }

    #[inline(always)]
    fn from_words([key0, key1, index, dimension]: [u32; 4]) -> SobolSampler {
        SobolSampler {
            key0,
            key1,
            index,
            dimension,
        }
    }
}
