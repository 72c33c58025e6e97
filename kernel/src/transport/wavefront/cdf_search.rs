//! Binary searches in cumulative distributions, in lanes.

use super::segment::Segment;
use crate::math::distribution::{halved, interval};
use crate::simd::multiversioned;
use bytemuck::Zeroable;

/// A search for each of `N` slots, see [`crate::math::distribution`].
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct SearchLanes<const N: usize> {
    /// First words of the tables.
    pub offset: [u32; N],
    /// The random numbers.
    pub u: [f32; N],
    /// The range of indices that is left.
    pub low: [u32; N],
    pub high: [u32; N],
}

impl<const N: usize> SearchLanes<N> {
    /// Begins a search at slot `k < N`.
    #[inline(always)]
    pub fn set(&mut self, k: usize, offset: u32, u: f32, low: u32, high: u32) {
        self.offset[k] = offset;
        self.u[k] = u;
        self.low[k] = low;
        self.high[k] = high;
    }

    /// The index found at slot `k < N`, the random number rescaled to [0, 1) within its interval, and its probability.
    #[inline(always)]
    pub fn found(&self, data: &[f32], k: usize) -> (u32, f32, f32) {
        let index = self.low[k];
        let (stretched, pmf) = interval(data, self.offset[k], index, self.u[k]);
        (index, stretched, pmf)
    }
}

multiversioned! {
    /// Runs the searches of a segment to their ends.
    pub(super) fn search<; const N: usize>(
        data: &[f32],
        segment: Segment,
        lanes: &mut SearchLanes<N>,
    ) {
        let mut widest = 0;
        for k in segment.padded::<N>() {
            widest |= lanes.high[k].wrapping_sub(lanes.low[k]);
        }
        // A range of n indices is reduced to one by as many halvings as n has bits.
        for _ in 0..32 - widest.leading_zeros() {
            for k in segment.padded::<N>() {
                let (low, high) = (lanes.low[k], lanes.high[k]);
                let (lower, upper) = halved(data, lanes.offset[k], low, high, lanes.u[k]);
                lanes.low[k] = if low < high { lower } else { low };
                lanes.high[k] = if low < high { upper } else { high };
            }
        }
    }
}
