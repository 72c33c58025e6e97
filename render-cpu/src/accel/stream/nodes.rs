//! Sixteen rays against the children of a node each.
//!
//! Nodes are read as five rows of four words (see [`super`]), which are turned into columns whichever nodes they are. A byte
//! of a plane becomes the second byte of the float 32768 + q by one shuffle into a constant, instead of taking the byte
//! out and converting it; the rounding that comes with the larger number is part of the error by which boxes grow.

use super::rays::RayLanes;
use crate::accel::simd::avx512::{F16, LANES, W16, WordRow, columns, transposed, with_avx512};
use crate::accel::simd::boxes::PlaneDistances;
use crate::accel::simd::{SimdFloat, SimdWord};
use obvhs::cwbvh::node::CwBvhNode;
use std::arch::x86_64::*;

/// Plane q is the float [`OFFSET`] + q, of which q is the second byte.
const OFFSET: f32 = 32768.0;

/// The second byte of every word.
const SECOND_BYTES: u64 = 0x2222_2222_2222_2222;

/// What rays meet of their nodes.
#[derive(Clone, Copy)]
pub struct NodeHits {
    /// A bit for each leaf entry, and from [`super::child_order::CHILDREN`] on one for each child that is a node.
    pub bits: W16,
    /// Which children are nodes, as bits.
    pub is_inner: W16,
    /// First children that are nodes.
    pub child_base: W16,
    /// First entries of leaves.
    pub entry_base: W16,
}

/// Shuffles that put each of the four bytes of words where the second is. The walk keeps them in memory, opaque to the
/// optimiser, which would turn shuffles by constants into longer sequences.
pub fn byte_shuffles() -> [WordRow; 4] {
    std::array::from_fn(|byte| {
        let byte = std::hint::black_box(byte as u32);
        WordRow(std::array::from_fn(|lane| {
            (4 * (lane as u32 % 4) + byte) << 8
        }))
    })
}

const _: () = assert!(LANES == 16);

with_avx512! {
    /// Byte `C` of every word.
    #[inline]
    fn byte<const C: u32>(v: W16) -> W16 {
        // Two of them by shuffles, because other work takes the other ports.
        const NONE: i8 = -1;
        match C {
            0 => v & W16::splat(255),
            1 => W16(_mm512_shuffle_epi8(v.0, _mm512_broadcast_i32x4(_mm_setr_epi8(
                1, NONE, NONE, NONE, 5, NONE, NONE, NONE, 9, NONE, NONE, NONE, 13, NONE, NONE, NONE,
            )))),
            2 => W16(_mm512_shuffle_epi8(v.0, _mm512_broadcast_i32x4(_mm_setr_epi8(
                2, NONE, NONE, NONE, 6, NONE, NONE, NONE, 10, NONE, NONE, NONE, 14, NONE, NONE, NONE,
            )))),
            _ => v.shr::<24>(),
        }
    }

    /// The floats [`OFFSET`] + q of one byte q of every word, which `shuffle` moves ([`byte_shuffles`]).
    #[inline]
    fn planes(bytes: W16, shuffle: W16) -> F16 {
        let offset = W16::splat(OFFSET.to_bits());
        W16(_mm512_mask_shuffle_epi8(offset.0, SECOND_BYTES, bytes.0, shuffle.0)).as_floats()
    }

    /// What the rays of the lanes of a mask meet of the nodes with these first words. `bytes` are [`byte_shuffles`].
    #[inline]
    pub fn hit_children(
        rays: &RayLanes,
        nodes: &[CwBvhNode],
        first: &WordRow,
        bytes: &[WordRow; 4],
        lanes: u16,
    ) -> NodeHits {
        let nodes: *const u32 = nodes.as_ptr().cast();
        macro_rules! row {
            ($row:literal) => {
                columns!(|lane| {
                    // SAFETY: the words of a node follow: `first` comes from the nodes themselves.
                    unsafe { _mm_loadu_si128(nodes.add(first.0[lane] as usize + 4 * $row).cast()) }
                })
            };
        }
        let [px, py, pz, exponents] = row!(0);
        let [child_base, entry_base, meta0, meta1] = row!(1);
        let axes = [row!(2), row!(3), row!(4)];
        let corner = [px.as_floats(), py.as_floats(), pz.as_floats()];
        let unit = [
            byte::<0>(exponents).shl::<23>().as_floats(),
            byte::<1>(exponents).shl::<23>().as_floats(),
            byte::<2>(exponents).shl::<23>().as_floats(),
        ];
        let is_inner = byte::<3>(exponents);

        let range = [F16::load(&rays.t_min), F16::load(&rays.t_max)];
        let origin = F16::load3(&rays.origin);
        let offset = [corner[0] - origin[0], corner[1] - origin[1], corner[2] - origin[2]];
        // The error of a product by the offset is 32768 / 2^24 planes, that of 4500 planes a little more than both.
        let mut distances = PlaneDistances::new::<4500>(unit, offset, F16::load3(&rays.inverse));
        // By halves of four children: near and far planes' bytes of the axes.
        let mut sides = [[[exponents; 3]; 2]; 2];
        for k in 0..3 {
            let step = distances.step[k];
            distances.low[k] = step.mul_add(F16::splat(-OFFSET), distances.low[k]);
            distances.high[k] = step.mul_add(F16::splat(-OFFSET), distances.high[k]);
            let negative = rays.negative[k];
            for half in 0..2 {
                let (lower, upper) = (axes[k][half], axes[k][2 + half]);
                sides[half][0][k] = W16::select(negative, upper, lower);
                sides[half][1][k] = W16::select(negative, lower, upper);
            }
        }
        let shuffles = [
            W16::load(&bytes[0]),
            W16::load(&bytes[1]),
            W16::load(&bytes[2]),
            W16::load(&bytes[3]),
        ];
        let mut bits = W16::splat(0);
        macro_rules! child {
            ($half:literal, $byte:literal, $meta:ident) => {{
                let shuffle = shuffles[$byte];
                let [near, far] = sides[$half];
                let near = [planes(near[0], shuffle), planes(near[1], shuffle), planes(near[2], shuffle)];
                let far = [planes(far[0], shuffle), planes(far[1], shuffle), planes(far[2], shuffle)];
                let [first, last] = distances.interval(near, far, range);
                let hit = first.le(last, lanes);
                // A number in unary, to be shifted by the lowest five bits: a bit for each entry, or for the child itself
                // above those.
                let meta = byte::<$byte>($meta);
                let slot_bits = W16(_mm512_rolv_epi32(meta.shr::<5>().0, meta.0));
                bits = W16::select(hit, bits | slot_bits, bits);
            }};
        }
        child!(0, 0, meta0);
        child!(0, 1, meta0);
        child!(0, 2, meta0);
        child!(0, 3, meta0);
        child!(1, 0, meta1);
        child!(1, 1, meta1);
        child!(1, 2, meta1);
        child!(1, 3, meta1);
        NodeHits { bits, is_inner, child_base, entry_base }
    }
}
