//! Independent random numbers: a hash of the counter.

use super::hash::{hashed, keys, to_unit_interval};
use super::{LaneSampler, Sampler};
use bytemuck::Zeroable;

/// Independent numbers: a hash of the counter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Zeroable)]
pub struct IndependentSampler {
    pub(super) key0: u32,
    pub(super) key1: u32,
    pub(super) dimension: u32,
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
}

impl Sampler for IndependentSampler {
    #[inline]
    fn next_1d(&mut self) -> f32 {
        let x = hashed(self.key0, self.key1, self.dimension);
        self.dimension = self.dimension.wrapping_add(1);
        to_unit_interval(x)
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
