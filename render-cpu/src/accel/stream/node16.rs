//! Sixteen rays against the children of a node each.
//!
//! Nodes are read as five rows of four words, which are turned into columns whichever nodes they are. A byte of a plane becomes the
//! second byte of the float 32768 + q by one shuffle into a constant, which takes the place of taking the byte out and of
//! a conversion; the rounding that comes with the larger number is part of the error by which boxes grow.

use super::lanes16::*;
use super::sixteen::Sixteen;
use obvhs::cwbvh::node::CwBvhNode;
use std::arch::x86_64::*;

/// Where children's bits begin among those of a node.
pub const CHILDREN: u32 = 24;

/// The first of them.
pub const FIRST_CHILD: i32 = 1 << CHILDREN;

/// Plane q is the float [`OFFSET`] + q, of which q is the second byte.
const OFFSET: f32 = 32768.0;

/// Its second byte of every word.
const SECOND_BYTES: u64 = 0x2222_2222_2222_2222;

/// What rays meet of their nodes.
#[derive(Clone, Copy)]
pub struct Met {
    /// A bit for each place, and from [`CHILDREN`] on one for each child that is a node.
    pub bits: __m512i,
    /// Which children are nodes, as bits.
    pub is_inner: __m512i,
    /// First nodes below.
    pub child_base: __m512i,
    /// First places.
    pub place_base: __m512i,
}

/// Shuffles that put each byte of words where the second is. Whoever tests nodes keeps them where no compiler knows what they do
/// and makes something else of them.
pub fn byte_shuffles() -> [Words; 4] {
    std::array::from_fn(|byte| {
        let byte = std::hint::black_box(byte as u32);
        Words(std::array::from_fn(|lane| {
            (4 * (lane as u32 % 4) + byte) << 8
        }))
    })
}

avx512! {
    /// What slots are exchanged with for their places in the order of each direction: the first has the highest bit.
    pub fn orders(negative: [u16; 3]) -> __m512i {
        let mut order = word(7);
        for k in 0..3 {
            order = _mm512_mask_xor_epi32(order, negative[k], order, word(4 >> k));
        }
        order
    }

    /// First words of nodes: twenty each.
    pub fn first_words(nodes: __m512i) -> __m512i {
        _mm512_add_epi32(_mm512_slli_epi32::<4>(nodes), _mm512_slli_epi32::<2>(nodes))
    }

    /// Byte `C` of every word.
    fn byte<const C: u32>(v: __m512i) -> __m512i {
        // Two of them by shuffles, because other work takes the other ports.
        const NONE: i8 = -1;
        match C {
            0 => _mm512_and_si512(v, word(255)),
            1 => _mm512_shuffle_epi8(v, _mm512_broadcast_i32x4(_mm_setr_epi8(
                1, NONE, NONE, NONE, 5, NONE, NONE, NONE, 9, NONE, NONE, NONE, 13, NONE, NONE, NONE,
            ))),
            2 => _mm512_shuffle_epi8(v, _mm512_broadcast_i32x4(_mm_setr_epi8(
                2, NONE, NONE, NONE, 6, NONE, NONE, NONE, 10, NONE, NONE, NONE, 14, NONE, NONE, NONE,
            ))),
            _ => _mm512_srli_epi32::<24>(v),
        }
    }

    /// Number of bits of the lowest byte of every word, of which the others are zero.
    fn bit_counts(v: __m512i) -> __m512i {
        let table = _mm512_broadcast_i32x4(_mm_setr_epi8(
            0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4,
        ));
        let low = _mm512_shuffle_epi8(table, _mm512_and_si512(v, word(15)));
        // The other bytes count the bits of a zero each.
        let high = _mm512_shuffle_epi8(table, _mm512_srli_epi32::<4>(v));
        _mm512_add_epi32(low, high)
    }

    /// The lanes of `mask` that meet a child, by the near and the far planes' bytes, of which `bytes` makes floats
    /// ([`byte_shuffles`]).
    fn meets(
        near: [__m512i; 3],
        far: [__m512i; 3],
        bytes: __m512i,
        step: [__m512; 3],
        low: [__m512; 3],
        high: [__m512; 3],
        range: [__m512; 2],
        mask: u16,
    ) -> u16 {
        let at = |planes: __m512i, step: __m512, base: __m512| {
            let plane = _mm512_mask_shuffle_epi8(word(OFFSET.to_bits() as i32), SECOND_BYTES, planes, bytes);
            _mm512_fmadd_ps(_mm512_castsi512_ps(plane), step, base)
        };
        let t0 = _mm512_max_ps(
            _mm512_max_ps(at(near[0], step[0], low[0]), at(near[1], step[1], low[1])),
            _mm512_max_ps(at(near[2], step[2], low[2]), range[0]),
        );
        let t1 = _mm512_min_ps(
            _mm512_min_ps(at(far[0], step[0], high[0]), at(far[1], step[1], high[1])),
            _mm512_min_ps(at(far[2], step[2], high[2]), range[1]),
        );
        _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(mask, t0, t1)
    }

    /// What the rays of the lanes of a mask meet of the nodes with these first words. `bytes` are [`byte_shuffles`].
    pub fn children(
        rays: &Sixteen,
        nodes: &[CwBvhNode],
        first: &Words,
        bytes: &[Words; 4],
        busy: u16,
    ) -> Met {
        let nodes: *const u32 = nodes.as_ptr().cast();
        macro_rules! quarter {
            ($q:literal) => {
                columns!(|lane| {
                    // SAFETY: twenty words of a node follow: `first` comes from the nodes themselves, see [`first_words`].
                    unsafe { _mm_loadu_si128(nodes.add(first.0[lane] as usize + 4 * $q).cast()) }
                })
            };
        }
        let [px, py, pz, exponents] = quarter!(0);
        let [child_base, place_base, meta0, meta1] = quarter!(1);
        let planes = [quarter!(2), quarter!(3), quarter!(4)];
        let corner = [px, py, pz];
        let exponent = [
            byte::<0>(exponents),
            byte::<1>(exponents),
            byte::<2>(exponents),
        ];
        let is_inner = byte::<3>(exponents);

        let range = [load(&rays.t_min), load(&rays.t_max)];
        let mut grid = [[range[0]; 3]; 3];
        let mut sides = [[[exponents; 3]; 2]; 2];
        for k in 0..3 {
            let inverse = load(&rays.inverse[k]);
            let unit = _mm512_castsi512_ps(_mm512_slli_epi32::<23>(exponent[k]));
            let offset = _mm512_sub_ps(_mm512_castsi512_ps(corner[k]), load(&rays.origin[k]));
            // The error of a product by the offset is 32768 / 2^24 planes, that of 4500 planes a little more than both.
            let [step, low, high] = plane_distances::<4500>(unit, offset, inverse);
            grid[0][k] = step;
            grid[1][k] = _mm512_fmadd_ps(step, splat(-OFFSET), low);
            grid[2][k] = _mm512_fmadd_ps(step, splat(-OFFSET), high);
            let negative = rays.negative[k];
            for half in 0..2 {
                let (lower, upper) = (planes[k][half], planes[k][2 + half]);
                sides[half][0][k] = _mm512_mask_mov_epi32(lower, negative, upper);
                sides[half][1][k] = _mm512_mask_mov_epi32(upper, negative, lower);
            }
        }
        let [step, low, high] = grid;
        let bytes = [
            load_words(&bytes[0]),
            load_words(&bytes[1]),
            load_words(&bytes[2]),
            load_words(&bytes[3]),
        ];
        let mut met = _mm512_setzero_si512();
        macro_rules! child {
            ($half:literal, $byte:literal, $meta:ident) => {{
                let [near, far] = sides[$half];
                let hit = meets(near, far, bytes[$byte], step, low, high, range, busy);
                // A number in unary, to be shifted by the lowest five bits (see `CwBvhNode`): a bit for each place, or for
                // the child itself above those.
                let meta = byte::<$byte>($meta);
                let bits = _mm512_rolv_epi32(_mm512_srli_epi32::<5>(meta), meta);
                met = _mm512_mask_or_epi32(met, hit, met, bits);
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
        Met { bits: met, is_inner, child_base, place_base }
    }

    /// Slots' bits in the order in which a ray comes through them, the highest first: bit s goes to s ^ order, see [`orders`].
    pub fn in_order(bits: __m512i, negative: [u16; 3]) -> __m512i {
        let mut v = bits;
        macro_rules! swap {
            ($axis:literal, $shift:literal, $low:literal) => {
                let low = _mm512_and_si512(_mm512_srli_epi32::<$shift>(v), word($low));
                let high = _mm512_slli_epi32::<$shift>(_mm512_and_si512(v, word($low)));
                v = _mm512_mask_or_epi32(v, !negative[$axis], low, high);
            };
        }
        swap!(0, 4, 0x0f);
        swap!(1, 2, 0x33);
        swap!(2, 1, 0x55);
        v
    }

    /// The first child in the order among those whose bits are set, of which there is at least one, and the bits without it.
    pub fn first_child(base: __m512i, bits: __m512i, order: __m512i) -> (__m512i, __m512i) {
        let bit = _mm512_sub_epi32(word(31), _mm512_lzcnt_epi32(bits));
        let place = _mm512_sub_epi32(bit, word(CHILDREN as i32));
        let child = _mm512_xor_si512(place, order);
        // Children that are inner lie side by side.
        let before = _mm512_sub_epi32(_mm512_sllv_epi32(word(1), child), word(1));
        let inner = _mm512_and_si512(_mm512_and_si512(bits, before), word(255));
        let index = _mm512_add_epi32(base, bit_counts(inner));
        (index, _mm512_andnot_si512(_mm512_sllv_epi32(word(1), bit), bits))
    }

    /// Steps and bases ([`plane_distances`]) of the axes of one node for all rays.
    pub fn grid(node: &CwBvhNode, origin: [__m512; 3], inverse: [__m512; 3]) -> [[__m512; 3]; 3] {
        let corner = [node.p.x, node.p.y, node.p.z];
        let mut grid = [origin; 3];
        for k in 0..3 {
            let unit = splat(f32::from_bits(u32::from(node.e[k]) << 23));
            let offset = _mm512_sub_ps(splat(corner[k]), origin[k]);
            let [step, low, high] = plane_distances::<255>(unit, offset, inverse[k]);
            grid[0][k] = step;
            grid[1][k] = low;
            grid[2][k] = high;
        }
        grid
    }

    /// Plane q of an axis is met at q step + base, see [`crate::accel::single::node`]: the step and the base, rounded down and up, of a grid with
    /// planes `unit` apart whose corner is `offset` from the ray's origin. `PLANES` is how many planes away rounding takes place.
    fn plane_distances<const PLANES: i32>(unit: __m512, offset: __m512, inverse: __m512) -> [__m512; 3] {
        let step = _mm512_mul_ps(unit, inverse);
        let base = _mm512_mul_ps(offset, inverse);
        let size = _mm512_fmadd_ps(_mm512_abs_ps(step), splat(PLANES as f32), _mm512_abs_ps(base));
        let error = _mm512_mul_ps(size, splat(5e-7));
        [step, _mm512_sub_ps(base, error), _mm512_add_ps(base, error)]
    }
}
