//! Runs of slots in a wave's arrays.

use crate::simd::lanes::VECTOR_WIDTH;
use bytemuck::Zeroable;
use core::ops::Range;

/// The slots of a class of paths: from a multiple of [`VECTOR_WIDTH`] on, up to another, of which the first `count` are taken. Parts of
/// it begin anywhere.
#[derive(Clone, Copy, Zeroable)]
pub(super) struct Segment {
    pub first: usize,
    pub count: usize,
}

impl Segment {
    /// No slot.
    pub const NONE: Segment = Segment { first: 0, count: 0 };

    /// The slots from `first` on below `end`, which is no less.
    pub fn between(first: usize, end: usize) -> Segment {
        Segment {
            first,
            count: end - first,
        }
    }

    /// All slots, in whole vectors.
    #[inline(always)]
    pub fn slots<const N: usize>(self) -> Range<usize> {
        let first = self.first & !(VECTOR_WIDTH - 1);
        let end = (self.first + self.count + (VECTOR_WIDTH - 1)) & !(VECTOR_WIDTH - 1);
        let capacity = N & !(VECTOR_WIDTH - 1);
        first..if end < capacity { end } else { capacity }
    }

    /// The slots that are taken.
    #[inline(always)]
    pub fn taken<const N: usize>(self) -> Range<usize> {
        let end = self.first + self.count;
        self.first..if end < N { end } else { N }
    }
}
