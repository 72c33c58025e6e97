//! Runs of slots in the arrays of a wavefront.

use crate::simd::lanes::VECTOR_WIDTH;
use bytemuck::Zeroable;
use core::ops::Range;

/// A run of slots, of which a queue's begins at a multiple of [`VECTOR_WIDTH`]. Loops over lanes run over whole vectors
/// ([`Segment::padded`]); what they compute in slots that are not occupied is never read.
#[derive(Clone, Copy, Zeroable)]
pub(super) struct Segment {
    pub first: usize,
    pub count: usize,
}

impl Segment {
    /// No slot.
    pub const NONE: Segment = Segment { first: 0, count: 0 };

    /// The slots from `first` up to `end`, which is not less.
    pub fn between(first: usize, end: usize) -> Segment {
        Segment {
            first,
            count: end - first,
        }
    }

    /// The slots extended to whole vectors.
    #[inline(always)]
    pub fn padded<const N: usize>(self) -> Range<usize> {
        let first = self.first & !(VECTOR_WIDTH - 1);
        let end = (self.first + self.count + (VECTOR_WIDTH - 1)) & !(VECTOR_WIDTH - 1);
        let capacity = N & !(VECTOR_WIDTH - 1);
        first..if end < capacity { end } else { capacity }
    }

    /// The slots themselves.
    #[inline(always)]
    pub fn occupied<const N: usize>(self) -> Range<usize> {
        let end = self.first + self.count;
        self.first..if end < N { end } else { N }
    }
}
