//! Sixteen rays in lockstep, each at its own place in the tree, on processors with AVX-512.
//!
//! A single ray's walk waits: for a node, for the result of its test, for a guess about what comes next that was wrong. Here
//! a step takes one node for each of sixteen rays, without a branch on what they are (as graphics hardware does: Aila and
//! Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs"); a ray that is done makes room for the next of
//! the batch. What a node leaves of its children is kept as bits (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs"), and triangles and spheres wait in a queue until there are sixteen of them,
//! whichever rays they are for. Other primitives are left to the walk of single rays. Rays in a row that go the same way, as those
//! of a pixel's samples do, stay together instead ([`super::bundle16`]).
//!
//! Which hit is found does not depend on the order of the walk ([`halflight_kernel::scene::Traverse::closest_hit`]), so that
//! it is that of a single ray, to the bit.

use super::bundle16::is_bundle;
use super::lanes16::*;
use super::node16::*;
use super::root16::{NO_NODE, Starts, begin_all};
use super::sixteen::{Sixteen, enqueue, expand_words, hand_over, hand_over_row, take, waiting};
use crate::accel::traverse::CpuTraverse;
use crate::accel::{Group, build::MAX_WIDE_DEPTH};
use halflight_kernel::scene::{Hit, HitBatch, RayBatch};
use std::arch::x86_64::*;
use std::ops::Range;

/// Idle lanes that are worth looking for new rays.
const REFILL: u32 = 3;

/// Rays of a bundle that have to meet a node on average for the next ones to be worth the try. Of 5, 6, 8 and 10 the fastest.
const TOGETHER: f32 = 5.0;

/// The state of sixteen walks.
#[repr(C, align(64))]
struct Walks {
    rays: Sixteen,
    /// What slots are exchanged with for their places in the order of a direction, see [`crate::accel::build::collapse`].
    order: Words,
    /// First word of the node that comes next.
    node: Words,
    /// Nodes that wait: the first child of some node and which of its children are left ([`CHILDREN`]) and inner (the lowest
    /// eight bits).
    base: [Words; MAX_WIDE_DEPTH],
    bits: [Words; MAX_WIDE_DEPTH],
    size: Words,
    /// See [`byte_shuffles`].
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
    pub(in crate::accel) fn lockstep<const ANY: bool, const N: usize>(
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
        walks.bytes = byte_shuffles();
        let mut next = 0;
        // How many rays of the last bundles have met a node on average, while they stay together.
        let mut together = LANES as f32;
        while next < count {
            let is_bundle = |first: usize, together: f32| {
                together >= TOGETHER && first + LANES <= count && is_bundle(group, rays, first)
            };
            if is_bundle(next, together) {
                take(&mut walks.rays, u16::MAX, rays, &starts, next);
                let latest = self.trace_bundle(&mut walks.rays, group, ANY);
                hand_over_row(&walks.rays, next, hits);
                next += LANES;
                together = 0.75 * together + 0.25 * latest;
                continue;
            }
            let first = next;
            loop {
                next = (next + LANES).min(count);
                if next == count || is_bundle(next, together) {
                    break;
                }
            }
            self.walk_apart::<ANY, N>(&mut walks, group, rays, &starts, first..next, hits);
        }
    }

    /// Traces the rays of a range, each at its own place.
    #[target_feature(
        enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,popcnt,bmi1,bmi2,lzcnt"
    )]
    fn walk_apart<const ANY: bool, const N: usize>(
        &self,
        walks: &mut Walks,
        group: &Group,
        rays: &RayBatch<N>,
        starts: &Starts<N>,
        range: Range<usize>,
        hits: &mut HitBatch<N>,
    ) {
        let (mut next, count) = (range.start, range.end);
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
                hand_over::<ANY, N>(&walks.rays, free & walks.live, hits);
                walks.live &= !free;
                if next == count && walks.live == 0 {
                    return;
                }
                begin(walks, group, free, rays, starts, &mut next, count);
            }
            if walks.busy != 0 {
                step(walks, group);
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

    /// A node of each busy lane.
    fn step(walks: &mut Walks, group: &Group) {
        let busy = walks.busy;
        let met = children(&walks.rays, &group.nodes, &walks.node, &walks.bytes, busy);
        let children = in_order(_mm512_srli_epi32::<CHILDREN>(met.bits), walks.rays.negative);
        let children = _mm512_slli_epi32::<CHILDREN>(children);
        advance(walks, met.child_base, _mm512_or_si512(children, met.is_inner));
        let places = _mm512_and_si512(met.bits, word(FIRST_CHILD - 1));
        enqueue_leaves(&mut walks.rays, met.place_base, places, busy);
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
