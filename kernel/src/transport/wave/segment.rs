//! Runs of slots in a wave's arrays.

use crate::math::lanes::VECTOR;
use bytemuck::Zeroable;
use core::ops::Range;

/// The slots of a class of paths: from a multiple of [`VECTOR`] on, up to another, of which the first `count` are taken.
#[derive(Clone, Copy, Zeroable)]
pub(super) struct Segment {
    pub first: usize,
    pub count: usize,
}

impl Segment {
    /// All slots, in whole vectors.
    #[inline(always)]
    pub fn slots<const N: usize>(self) -> Range<usize> {
        let first = self.first & !(VECTOR - 1);
        let end = (self.first + self.count + (VECTOR - 1)) & !(VECTOR - 1);
        let capacity = N & !(VECTOR - 1);
        first..if end < capacity { end } else { capacity }
    }

    /// The slots that are taken.
    #[inline(always)]
    pub fn taken<const N: usize>(self) -> Range<usize> {
        let end = self.first + self.count;
        self.first..if end < N { end } else { N }
    }
}
