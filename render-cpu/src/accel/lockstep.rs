//! Sixteen rays in lockstep, each at its own place in the tree, on processors with AVX-512.
//!
//! A single ray's walk waits: for a node, for the result of its test, for a guess about what comes next that was wrong. Here
//! a step takes one node for each of sixteen rays, without a branch on what they are (as graphics hardware does: Aila and
//! Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs"); a ray that is done makes room for the next of
//! the batch. What a node leaves of its children is kept as bits (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs"), and triangles and spheres wait in a queue until there are sixteen of them,
//! whichever rays they are for. Other primitives are left to the walk of single rays.
//!
//! Which hit is found does not depend on the order of the walk ([`halflight_kernel::scene::Traverse::closest_hit`]), so that
//! it is that of a single ray, to the bit.

use super::lanes16::*;
use super::root16::{NO_NODE, Starts, begin_all, plane_distances};
use super::sixteen::{Sixteen, enqueue, expand_words, hand_over, take, waiting};
use super::traverse::CpuTraverse;
use super::{Group, build::MAX_WIDE_DEPTH};
use halflight_kernel::scene::{Hit, HitBatch, RayBatch};
use std::arch::x86_64::*;

/// Idle lanes that are worth looking for new rays.
const REFILL: u32 = 3;

/// Where children's bits begin in [`Walks::bits`].
pub const CHILDREN: u32 = 24;

/// Plane q is the float [`OFFSET`] + q, of which q is the second byte.
const OFFSET: f32 = 32768.0;

/// Its second byte of every word.
const SECOND_BYTES: u64 = 0x2222_2222_2222_2222;

/// The first of them.
pub const FIRST_CHILD: i32 = 1 << CHILDREN;

/// The state of sixteen walks.
#[repr(C, align(64))]
struct Walks {
    rays: Sixteen,
    /// What slots are exchanged with for their places in the order of a direction, see [`super::collapse`].
    order: Words,
    /// First word of the node that comes next.
    node: Words,
    /// Nodes that wait: the first child of some node and which of its children are left ([`CHILDREN`]) and inner (the lowest
    /// eight bits).
    base: [Words; MAX_WIDE_DEPTH],
    bits: [Words; MAX_WIDE_DEPTH],
    size: Words,
    /// Shuffles that put each byte of words where the highest bits of a float's fraction are. They are read from here so that no
    /// compiler knows what they do and makes something else of them.
    bytes: [Words; 4],
    /// Lanes that have a ray.
    live: u16,
    /// Lanes that have nodes left.
    busy: u16,
}

impl Walks {
    const NONE: Walks = Walks {
        rays: Sixteen::NONE,
        order: Words::all(0),
        node: Words::all(0),
        base: [Words::all(0); MAX_WIDE_DEPTH],
        bits: [Words::all(0); MAX_WIDE_DEPTH],
        size: Words::all(0),
        bytes: [Words::all(0); 4],
        live: 0,
        busy: 0,
    };
}

impl CpuTraverse<'_> {
    /// Traces the first `count` rays; with `ANY` any hit will do.
    #[target_feature(
        enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,popcnt,bmi1,bmi2,lzcnt"
    )]
    pub(super) fn lockstep<const ANY: bool, const N: usize>(
        &self,
        rays: &RayBatch<N>,
        count: usize,
        hits: &mut HitBatch<N>,
    ) {
        let count = count.min(N);
        let group = &self.accel.groups[0];
        if group.nodes.is_empty() {
            for i in 0..count {
                hits.set(i, &Hit::MISS);
            }
            return;
        }
        let mut starts = Starts::new();
        begin_all(group, rays, count, &mut starts);
        let mut walks = Walks::NONE;
        for (k, words) in walks.bytes.iter_mut().enumerate() {
            let k = std::hint::black_box(k as u32);
            words.0 = std::array::from_fn(|lane| (4 * (lane as u32 % 4) + k) << 8);
        }
        let mut next = 0;
        loop {
            let idle = !walks.busy;
            // Lanes whose places wait keep their rays.
            let free = if walks.rays.queued() == 0 {
                idle
            } else if (idle & walks.live) != 0 || (idle.count_ones() >= REFILL && next < count) {
                idle & !waiting(&walks.rays)
            } else {
                0
            };
            if (free.count_ones() >= REFILL && next < count) || free == u16::MAX {
                hand_over(&walks.rays, free & walks.live, hits);
                walks.live &= !free;
                if next == count && walks.live == 0 {
                    return;
                }
                begin(&mut walks, group, free, rays, &starts, &mut next, count);
            }
            if walks.busy != 0 {
                step(&mut walks, group);
            }
            while walks.rays.queued() >= LANES || (walks.busy == 0 && walks.rays.queued() > 0) {
                let met = self.test_places(&mut walks.rays, group, ANY);
                if ANY {
                    walks.busy &= !met;
                }
            }
        }
    }
}

avx512! {
    /// Begins the walks of the next rays in the lanes of a mask, behind the root.
    fn begin<const N: usize>(
        walks: &mut Walks,
        group: &Group,
        free: u16,
        rays: &RayBatch<N>,
        starts: &Starts<N>,
        next: &mut usize,
        count: usize,
    ) {
        let left = (count - *next).min(LANES);
        let fresh = _pdep_u32((1u32 << left) - 1, u32::from(free)) as u16;
        if fresh == 0 {
            return;
        }
        let first = *next;
        *next += fresh.count_ones() as usize;
        take(&mut walks.rays, fresh, rays, starts, first);
        store_words(&mut walks.order, orders(walks.rays.negative));
        let root = &group.nodes[0];
        let none = word(NO_NODE as i32);
        let node = expand_words(none, fresh, &starts.node, first);
        let has_node = _mm512_cmpneq_epi32_mask(node, none);
        store_some_words(&mut walks.node, fresh, _mm512_maskz_mov_epi32(has_node, node));
        let bits = expand_words(_mm512_setzero_si512(), fresh, &starts.bits, first);
        store_some_words(&mut walks.base[0], fresh, word(root.child_base_idx as i32));
        store_some_words(&mut walks.bits[0], fresh, bits);
        let has_more = _mm512_test_epi32_mask(bits, bits);
        store_some_words(&mut walks.size, fresh, _mm512_maskz_mov_epi32(has_more, word(1)));
        walks.live |= fresh;
        walks.busy |= has_node;
        let places = expand_words(_mm512_setzero_si512(), fresh, &starts.places, first);
        enqueue_leaves(&mut walks.rays, word(root.primitive_base_idx as i32), places, fresh);
    }

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
    /// ([`Walks::bytes`]).
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

    /// A node of each busy lane.
    fn step(walks: &mut Walks, group: &Group) {
        let busy = walks.busy;
        let nodes: *const u32 = group.nodes.as_ptr().cast();
        macro_rules! quarter {
            ($q:literal) => {
                columns!(|lane| {
                    // SAFETY: `node` is the first of the twenty words of a node.
                    unsafe { _mm_loadu_si128(nodes.add(walks.node.0[lane] as usize + 4 * $q).cast()) }
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

        let range = [load(&walks.rays.t_min), load(&walks.rays.t_max)];
        let mut grid = [[range[0]; 3]; 3];
        let mut sides = [[[exponents; 3]; 2]; 2];
        for k in 0..3 {
            let inverse = load(&walks.rays.inverse[k]);
            let unit = _mm512_castsi512_ps(_mm512_slli_epi32::<23>(exponent[k]));
            let offset = _mm512_sub_ps(_mm512_castsi512_ps(corner[k]), load(&walks.rays.origin[k]));
            // Rounded at the size of the offset of the planes.
            let [step, low, high] = plane_distances::<4500>(unit, offset, inverse);
            grid[0][k] = step;
            grid[1][k] = _mm512_fmadd_ps(step, splat(-OFFSET), low);
            grid[2][k] = _mm512_fmadd_ps(step, splat(-OFFSET), high);
            let negative = walks.rays.negative[k];
            for half in 0..2 {
                let (lower, upper) = (planes[k][half], planes[k][2 + half]);
                sides[half][0][k] = _mm512_mask_mov_epi32(lower, negative, upper);
                sides[half][1][k] = _mm512_mask_mov_epi32(upper, negative, lower);
            }
        }
        let [step, low, high] = grid;
        let bytes = [
            load_words(&walks.bytes[0]),
            load_words(&walks.bytes[1]),
            load_words(&walks.bytes[2]),
            load_words(&walks.bytes[3]),
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
        let children = in_order(_mm512_srli_epi32::<CHILDREN>(met), walks.rays.negative);
        let children = _mm512_slli_epi32::<CHILDREN>(children);
        advance(walks, child_base, _mm512_or_si512(children, is_inner));
        let places = word(FIRST_CHILD - 1);
        enqueue_leaves(&mut walks.rays, place_base, _mm512_and_si512(met, places), busy);
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

    /// Goes to a child of the last node, or to one that waits.
    fn advance(walks: &mut Walks, child_base: __m512i, children: __m512i) {
        let busy = walks.busy;
        let (mut base, mut bits) = (child_base, children);
        let mut size = load_words(&walks.size);
        let least = word(FIRST_CHILD);
        let has_none = _mm512_mask_cmplt_epu32_mask(busy, bits, least);
        let pops = _mm512_mask_test_epi32_mask(has_none, size, size);
        let slot = |size: __m512i| _mm512_add_epi32(_mm512_slli_epi32::<4>(size), lane_numbers());
        if pops != 0 {
            size = _mm512_mask_sub_epi32(size, pops, size, word(1));
            let at = slot(size);
            // SAFETY: what lies below `size` has been written.
            unsafe {
                base = _mm512_mask_i32gather_epi32::<4>(base, pops, at, walks.base.as_ptr().cast());
                bits = _mm512_mask_i32gather_epi32::<4>(bits, pops, at, walks.bits.as_ptr().cast());
            }
        }
        walks.busy = busy & !(has_none & !pops);
        let (index, rest) = first_child(base, bits, load_words(&walks.order));
        let pushes = _mm512_mask_cmpge_epu32_mask(walks.busy, rest, least);
        if pushes != 0 {
            let at = slot(size);
            // SAFETY: a node is pushed at most once per level, and there are as many entries as levels.
            unsafe {
                _mm512_mask_i32scatter_epi32::<4>(walks.base.as_mut_ptr().cast(), pushes, at, base);
                _mm512_mask_i32scatter_epi32::<4>(walks.bits.as_mut_ptr().cast(), pushes, at, rest);
            }
            size = _mm512_mask_add_epi32(size, pushes, size, word(1));
        }
        store_words(&mut walks.size, size);
        store_words(&mut walks.node, _mm512_maskz_mov_epi32(walks.busy, first_words(index)));
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

    /// Appends the places whose bits are set in `leaves`, from each node's first on.
    fn enqueue_leaves(rays: &mut Sixteen, place_base: __m512i, leaves: __m512i, busy: u16) {
        let mut leaves = leaves;
        let mut left = _mm512_mask_test_epi32_mask(busy, leaves, leaves);
        while left != 0 {
            let lowest = _mm512_and_si512(leaves, _mm512_sub_epi32(word(0), leaves));
            let place = _mm512_sub_epi32(word(31), _mm512_lzcnt_epi32(lowest));
            enqueue(rays, left, _mm512_add_epi32(place_base, place));
            leaves = _mm512_xor_si512(leaves, lowest);
            left = _mm512_mask_test_epi32_mask(left, leaves, leaves);
        }
    }
}
