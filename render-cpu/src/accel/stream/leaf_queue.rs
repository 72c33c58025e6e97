//! Leaf entries that wait to be tested, each with the lane of its ray.

use crate::accel::simd::SimdWord;
use crate::accel::simd::avx512::{LANES, W16, with_avx512};
use std::arch::x86_64::*;

/// Entries: what may be left of a test, and all entries of sixteen roots and of sixteen other nodes, 24 each.
const CAPACITY: usize = LANES * 49;

/// Leaf entries and lanes, in the order in which they were met.
#[repr(C, align(64))]
pub struct LeafQueue {
    /// Sixteen times the index of the leaf entry, plus the lane.
    items: [u32; CAPACITY],
    len: usize,
}

impl LeafQueue {
    /// Nothing waits.
    pub const EMPTY: LeafQueue = LeafQueue {
        items: [0; CAPACITY],
        len: 0,
    };

    /// How many entries wait.
    pub fn len(&self) -> usize {
        self.len
    }

    with_avx512! {
        /// Appends a leaf entry of each of the lanes of a mask; there must be space for sixteen.
        #[inline]
        pub fn push(&mut self, lanes: u16, entries: W16) {
            let items = entries.shl::<4>() | W16::lane_numbers();
            debug_assert!(self.len + LANES <= CAPACITY);
            // SAFETY: there is room.
            unsafe {
                let to = self.items.as_mut_ptr().add(self.len);
                _mm512_storeu_si512(to.cast(), _mm512_maskz_compress_epi32(lanes, items.0));
            }
            self.len += lanes.count_ones() as usize;
        }

        /// The lanes of the entries that wait, of which there are fewer than sixteen.
        #[inline]
        pub fn lanes(&self) -> u16 {
            let mask = ((1u32 << self.len.min(LANES - 1)) - 1) as u16;
            // SAFETY: what the mask lets through has been written.
            let items = W16(unsafe { _mm512_maskz_loadu_epi32(mask, self.items.as_ptr().cast()) });
            let lanes = items & W16::splat(LANES as u32 - 1);
            _mm512_mask_reduce_or_epi32(mask, W16::splat(1).shl_by(lanes).0) as u16
        }

        /// Takes up to sixteen entries from the end, which moves none: the mask of those there are, all of them as in the
        /// queue, and where they lie in it, for sixteen from there on can be read.
        #[inline]
        pub fn pop(&mut self) -> (u16, W16, *const u32) {
            let count = self.len.min(LANES);
            self.len -= count;
            let mask = ((1u32 << count) - 1) as u16;
            let from = self.items[self.len..].as_ptr();
            // SAFETY: what the mask lets through has been written.
            let items = W16(unsafe { _mm512_maskz_loadu_epi32(mask, from.cast()) });
            (mask, items, from)
        }
    }
}
