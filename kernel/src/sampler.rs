//! Counter-based random numbers and Owen-scrambled Sobol' points.
//!
//! Every number is a function of (seed, pixel, sample, dimension) made of 32-bit integer operations only, so that an
//! image does not depend on threads, tiles or interruptions, and CPU and GPU draw the same numbers. A sampler is the
//! counter: asking for the next number advances the dimension.
//!
//! - [`IndependentSampler`] hashes the counter.
//! - [`SobolSampler`] takes two-dimensional Sobol' points (a (0,2)-sequence in base 2), scrambled in the sense of Owen
//!   by a hash and padded over pairs of dimensions by shuffling the order of the points (Burley 2020, "Practical
//!   Hash-based Owen Scrambling", JCGT 9(4)).
//!
//! Invariants (tests): numbers lie in [0, 1) and are uniform (chi-square); neighbouring seeds, pixels, samples and
//! dimensions are uncorrelated; of the first 2^k Sobol' points of a pixel each elementary interval of area 2^-k holds
//! exactly one.

use bytemuck::{Pod, Zeroable};
use glam::Vec2;

/// A stream of numbers in [0, 1) for one sample of one pixel or chain.
pub trait Sampler {
    /// The next number in [0, 1).
    fn next_1d(&mut self) -> f32;
    /// The next point in [0, 1)^2, well distributed over the samples of the pixel where the sampler can.
    fn next_2d(&mut self) -> Vec2;
}

/// A sampler that is four words, for lanes side by side.
pub trait LaneSampler: Sampler + Copy + Zeroable {
    /// The words.
    fn to_words(self) -> [u32; 4];
    /// The sampler of the words.
    fn from_words(words: [u32; 4]) -> Self;
}

/// Mixes the bits of a word: a bijection in which each input bit flips each output bit with a probability of nearly
/// one half (constants with the lowest known bias of this form: Wellons, "Hash Prospector").
#[inline]
pub fn mix(x: u32) -> u32 {
    let mut x = x;
    x ^= x >> 16;
    x = x.wrapping_mul(0x21f0_aaad);
    x ^= x >> 15;
    x = x.wrapping_mul(0xd35a_2d97);
    x ^ (x >> 15)
}

/// A word as a float in [0, 1): its upper 24 bits, which a float holds exactly.
#[inline]
pub fn to_unit_interval(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// 2^32 over the golden ratio, rounded to odd: counts through dimensions far apart in bits.
const GOLDEN: u32 = 0x9e37_79b9;

/// Two words from three: 64 bits, so that the 10^9 samples of an image hardly ever share a stream.
#[inline]
fn keys(seed: u32, pixel: u32, sample: u32) -> (u32, u32) {
    let a = mix(pixel.wrapping_add(mix(seed.wrapping_add(0x6a09_e667))));
    let b = mix(pixel.wrapping_add(mix(seed.wrapping_add(0xbb67_ae85))));
    (mix(sample.wrapping_add(a)), mix(sample.wrapping_add(b)))
}

/// Number `dimension` of the stream with these keys.
#[inline]
fn hashed(key0: u32, key1: u32, dimension: u32) -> u32 {
    mix(key0 ^ mix(key1.wrapping_add(dimension.wrapping_mul(GOLDEN))))
}

/// Independent numbers: a hash of the counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Zeroable)]
pub struct IndependentSampler {
    key0: u32,
    key1: u32,
    dimension: u32,
}

impl IndependentSampler {
    /// The stream of one sample of one pixel.
    #[inline]
    pub fn new(seed: u32, pixel: u32, sample: u32) -> IndependentSampler {
        let (key0, key1) = keys(seed, pixel, sample);
        IndependentSampler {
            key0,
            key1,
            dimension: 0,
        }
    }

    #[inline]
    fn next(&mut self) -> f32 {
        let x = hashed(self.key0, self.key1, self.dimension);
        self.dimension = self.dimension.wrapping_add(1);
        to_unit_interval(x)
    }
}

impl Sampler for IndependentSampler {
    #[inline]
    fn next_1d(&mut self) -> f32 {
        self.next()
    }

    #[inline]
    fn next_2d(&mut self) -> Vec2 {
        let x = self.next();
        let y = self.next();
        Vec2::new(x, y)
    }
}

impl LaneSampler for IndependentSampler {
    #[inline(always)]
    fn to_words(self) -> [u32; 4] {
        [self.key0, self.key1, 0, self.dimension]
    }

    #[inline(always)]
    fn from_words([key0, key1, _, dimension]: [u32; 4]) -> IndependentSampler {
        IndependentSampler {
            key0,
            key1,
            dimension,
        }
    }
}

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
    key0: u32,
    key1: u32,
    /// The sample's number with its bits reversed.
    index: u32,
    dimension: u32,
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
    fn advance(&mut self) -> u32 {
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

/// Kinds of [`AnySampler`].
pub mod sampler_kind {
    /// [`super::IndependentSampler`].
    pub const INDEPENDENT: u32 = 0;
    /// [`super::SobolSampler`].
    pub const SOBOL: u32 = 1;
}

/// Either sampler, chosen at run time; plain numbers, so that a buffer can hold it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct AnySampler {
    kind: u32,
    /// The counter; an independent sampler is the same but for its keys and the unused index.
    state: SobolSampler,
}

impl AnySampler {
    /// A sampler of one of [`sampler_kind`]; unknown kinds are independent.
    #[inline]
    pub fn new(kind: u32, seed: u32, pixel: u32, sample: u32) -> AnySampler {
        let state = if kind == sampler_kind::SOBOL {
            SobolSampler::new(seed, pixel, sample)
        } else {
            let s = IndependentSampler::new(seed, pixel, sample);
            SobolSampler {
                key0: s.key0,
                key1: s.key1,
                index: 0,
                dimension: s.dimension,
            }
        };
        AnySampler { kind, state }
    }

    #[inline]
    fn next_independent(&mut self) -> f32 {
        to_unit_interval(self.state.advance())
    }
}

impl Sampler for AnySampler {
    #[inline]
    fn next_1d(&mut self) -> f32 {
        if self.kind == sampler_kind::SOBOL {
            self.state.next_1d()
        } else {
            self.next_independent()
        }
    }

    #[inline]
    fn next_2d(&mut self) -> Vec2 {
        if self.kind == sampler_kind::SOBOL {
            self.state.next_2d()
        } else {
            let x = self.next_independent();
            let y = self.next_independent();
            Vec2::new(x, y)
        }
    }
}
