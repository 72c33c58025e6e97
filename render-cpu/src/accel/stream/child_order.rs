//! The children of a node as bits, in the order in which rays meet them, and which one comes next.
//!
//! A word describes what a ray has met of a node's children: the entries of its leaves in the lower 24 bits and the children
//! that are nodes above. Child slots are filled so that the signs of a direction alone decide the order of the slots
//! ([`crate::accel::build::slots`]): slot s comes at position s ^ order of eight.

use crate::accel::simd::SimdWord;
use crate::accel::simd::avx512::{W16, with_avx512};
use std::arch::x86_64::*;

/// Where the bits of children that are nodes begin.
pub const CHILDREN: u32 = 24;

/// The first of them.
pub const FIRST_CHILD: u32 = 1 << CHILDREN;

/// Words of a node.
const NODE_WORDS: u32 = 20;

with_avx512! {
    /// The exclusive-or mask by which slots are ordered for each direction: the first has the highest bit.
    #[inline]
    pub fn orders(negative: [u16; 3]) -> W16 {
        let mut order = W16::splat(7);
        for k in 0..3 {
            order = W16::select(negative[k], order ^ W16::splat(4 >> k), order);
        }
        order
    }

    /// Indices of the first words of nodes.
    #[inline]
    pub fn first_words(nodes: W16) -> W16 {
        const { assert!(NODE_WORDS == 16 + 4) };
        nodes.shl::<4>() + nodes.shl::<2>()
    }

    /// Slots' bits in the order in which a ray comes through them, the highest first: bit s goes to s ^ order, see [`orders`].
    #[inline]
    pub fn in_order(bits: W16, negative: [u16; 3]) -> W16 {
        let mut v = bits;
        macro_rules! swap {
            ($axis:literal, $shift:literal, $low:literal) => {
                let low = v.shr::<$shift>() & W16::splat($low);
                let high = (v & W16::splat($low)).shl::<$shift>();
                v = W16::select(!negative[$axis], low | high, v);
            };
        }
        swap!(0, 4, 0x0f);
        swap!(1, 2, 0x33);
        swap!(2, 1, 0x55);
        v
    }

    /// The first child in the order among those whose bits are set, of which there is at least one, and the bits without it;
    /// `base` is the first child that is a node. The lowest eight bits say which of the children are nodes.
    #[inline]
    pub fn first_child(base: W16, bits: W16, order: W16) -> (W16, W16) {
        let bit = W16::splat(31) - bits.leading_zeros();
        let child = (bit - W16::splat(CHILDREN)) ^ order;
        // Children that are nodes lie side by side.
        let before = W16::splat(1).shl_by(child) - W16::splat(1);
        let inner = bits & before & W16::splat(255);
        (base + bit_counts(inner), bits.without(W16::splat(1).shl_by(bit)))
    }

    /// Number of bits of the lowest byte of every word, of which the others are zero.
    #[inline]
    fn bit_counts(v: W16) -> W16 {
        let table = _mm512_broadcast_i32x4(_mm_setr_epi8(
            0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4,
        ));
        let low = W16(_mm512_shuffle_epi8(table, (v & W16::splat(15)).0));
        // The other bytes count the bits of a zero each.
        let high = W16(_mm512_shuffle_epi8(table, v.shr::<4>().0));
        low + high
    }
}

#[cfg(test)]
#[path = "../../../tests/common/skip.rs"]
mod skip;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::simd::avx512::{LANES, WordRow};
    use crate::processor::simd_level;

    with_avx512! {
        fn children_of(bits: u32, inner: u32, negative: u32) -> Vec<u32> {
            let signs = [0, 1, 2].map(|k| if negative >> k & 1 != 0 { u16::MAX } else { 0 });
            let children = in_order(W16::splat(bits), signs).shl::<CHILDREN>() | W16::splat(inner);
            let mut left = children;
            let mut found = vec![];
            while left.ge(W16::splat(FIRST_CHILD), u16::MAX) != 0 {
                let (index, rest) = first_child(W16::splat(1000), left, orders(signs));
                let mut row = WordRow::all(0);
                index.store(&mut row);
                assert_eq!(row.0, [row.0[0]; LANES]);
                found.push(row.0[0]);
                left = rest;
            }
            found
        }
    }

    #[test]
    fn children_come_in_the_order_of_the_direction() {
        let has_avx512 = simd_level().has_avx512().then_some(());
        let has_avx512 = has_avx512.ok_or("the processor has no AVX-512");
        if skip::available(has_avx512, "HALFLIGHT_REQUIRE_AVX512").is_none() {
            return;
        }
        for inner in [0xffu32, 0b1011_0110, 0b1000_0001] {
            for bits in 0..256u32 {
                let bits = bits & inner;
                for negative in 0..8u32 {
                    // SAFETY: the processor has the features.
                    let found = unsafe { children_of(bits, inner, negative) };
                    // Bits of a slot: z the lowest, set for negative directions.
                    let octant = (negative & 1) << 2 | (negative & 2) | negative >> 2;
                    let expected: Vec<u32> = (0..8)
                        .map(|rank| rank ^ octant)
                        .filter(|slot| bits >> slot & 1 != 0)
                        .map(|slot| 1000 + (inner & ((1 << slot) - 1)).count_ones())
                        .collect();
                    assert_eq!(found, expected, "{bits:b} of {inner:b}, {negative:b}");
                }
            }
        }
    }
}
