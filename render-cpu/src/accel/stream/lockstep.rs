//! Sixteen rays in lockstep, each at its own node of the tree, and the stream that feeds them.
//!
//! A step takes one node for each of sixteen rays, without a branch on what they are (as graphics hardware does: Aila and
//! Laine 2009, "Understanding the Efficiency of Ray Traversal on GPUs"); a ray that is done is replaced by the next of the
//! stream. What a node leaves of its children is kept as bits (Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray
//! Traversal on GPUs Through Compressed Wide BVHs"), and leaf entries wait in a queue until there are sixteen of them,
//! whichever rays they are for.

use super::child_order::{CHILDREN, FIRST_CHILD, first_child, first_words, in_order, orders};
use super::leaf_queue::LeafQueue;
use super::leaves::test_queued;
use super::nodes::{byte_shuffles, hit_children};
use super::packet::{is_packet, trace_packet};
use super::rays::{RayLanes, expand_words};
use super::root::{NO_NODE, PreparedRays, begin_all};
use crate::accel::build::MAX_WIDE_DEPTH;
use crate::accel::simd::SimdWord;
use crate::accel::simd::avx512::{LANES, W16, WordRow, with_avx512};
use crate::accel::single::walk::World;
use crate::accel::trees::Group;
use halflight_kernel::scene::{Hit, HitBatch, RayBatch};
use std::arch::x86_64::*;
use std::ops::Range;

/// Idle lanes that are worth looking for new rays.
const REFILL: u32 = 3;

/// Rays of a packet that have to meet a node on average for the next ones to be traced as a packet too. Of 5, 6, 8 and 10
/// the fastest.
const MIN_OCCUPANCY: f32 = 5.0;

/// The state of sixteen walks.
#[repr(C, align(64))]
struct Walks {
    rays: RayLanes,
    queue: LeafQueue,
    /// The exclusive-or mask by which slots are ordered for a direction, see [`super::child_order`].
    order: WordRow,
    /// First word of the node that comes next.
    node: WordRow,
    /// Nodes that wait: the first child of some node and which of its children are left ([`CHILDREN`]) and are nodes (the
    /// lowest eight bits).
    base: [WordRow; MAX_WIDE_DEPTH],
    bits: [WordRow; MAX_WIDE_DEPTH],
    size: WordRow,
    /// See [`byte_shuffles`].
    bytes: [WordRow; 4],
    /// Lanes that have a ray.
    live: u16,
    /// Lanes that have nodes left.
    busy: u16,
}

impl Walks {
    const NONE: Walks = Walks {
        rays: RayLanes::NONE,
        queue: LeafQueue::EMPTY,
        order: WordRow::all(0),
        node: WordRow::all(0),
        base: [WordRow::all(0); MAX_WIDE_DEPTH],
        bits: [WordRow::all(0); MAX_WIDE_DEPTH],
        size: WordRow::all(0),
        bytes: [WordRow::all(0); 4],
        live: 0,
        busy: 0,
    };
}

/// Traces the first `count` rays; with `ANY` any hit will do.
#[target_feature(
    enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,popcnt,bmi1,bmi2,lzcnt"
)]
pub fn trace<const ANY: bool, const N: usize>(
    world: &World<'_>,
    rays: &RayBatch<N>,
    count: usize,
    hits: &mut HitBatch<N>,
) {
    let count = count.min(N);
    let group = &world.groups[0];
    if group.nodes.is_empty() {
        for i in 0..count {
            hits.set(i, &Hit::MISS);
        }
        return;
    }
    let mut prepared = PreparedRays::new();
    begin_all(group, rays, count, &mut prepared);
    let mut walks = Walks::NONE;
    walks.bytes = byte_shuffles();
    let mut next = 0;
    // How many rays of the last packets have met a node on average.
    let mut occupancy = LANES as f32;
    while next < count {
        let is_packet = |first: usize, occupancy: f32| {
            occupancy >= MIN_OCCUPANCY && first + LANES <= count && is_packet(group, rays, first)
        };
        if is_packet(next, occupancy) {
            walks.rays.load(u16::MAX, rays, &prepared, next);
            let latest = trace_packet(world, group, &mut walks.rays, ANY);
            walks.rays.store_row(next, hits);
            next += LANES;
            occupancy = 0.75 * occupancy + 0.25 * latest;
            continue;
        }
        let first = next;
        loop {
            next = (next + LANES).min(count);
            if next == count || is_packet(next, occupancy) {
                break;
            }
        }
        let source = Source {
            rays,
            prepared: &prepared,
            left: first..next,
        };
        walk_range::<ANY, N>(world, group, &mut walks, source, hits);
    }
}

/// The rays of a batch that are yet to be traced.
struct Source<'a, const N: usize> {
    rays: &'a RayBatch<N>,
    prepared: &'a PreparedRays<N>,
    /// Their numbers.
    left: Range<usize>,
}

/// Traces the rays of a range, each at its own node.
#[target_feature(
    enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,popcnt,bmi1,bmi2,lzcnt"
)]
fn walk_range<const ANY: bool, const N: usize>(
    world: &World<'_>,
    group: &Group,
    walks: &mut Walks,
    mut source: Source<'_, N>,
    hits: &mut HitBatch<N>,
) {
    loop {
        let is_exhausted = source.left.start >= source.left.end;
        let idle = !walks.busy;
        // Lanes whose entries wait keep their rays.
        let free = if walks.queue.len() == 0 {
            idle
        } else if (idle & walks.live) != 0 || (idle.count_ones() >= REFILL && !is_exhausted) {
            idle & !walks.queue.lanes()
        } else {
            0
        };
        if (free.count_ones() >= REFILL && !is_exhausted) || free == u16::MAX {
            walks.rays.store::<ANY, N>(free & walks.live, hits);
            walks.live &= !free;
            if is_exhausted && walks.live == 0 {
                return;
            }
            begin(walks, group, free, &mut source);
        }
        if walks.busy != 0 {
            step(walks, group);
        }
        while walks.queue.len() >= LANES || (walks.busy == 0 && walks.queue.len() > 0) {
            let met = test_queued(world, group, &mut walks.rays, &mut walks.queue, ANY);
            if ANY {
                walks.busy &= !met;
            }
        }
    }
}

with_avx512! {
    /// Begins the walks of the next rays in the lanes of a mask, behind the root.
    #[inline]
    fn begin<const N: usize>(
        walks: &mut Walks,
        group: &Group,
        free: u16,
        source: &mut Source<'_, N>,
    ) {
        let prepared = source.prepared;
        let left = source.left.len().min(LANES);
        let fresh = _pdep_u32((1u32 << left) - 1, u32::from(free)) as u16;
        if fresh == 0 {
            return;
        }
        let first = source.left.start;
        source.left.start += fresh.count_ones() as usize;
        walks.rays.load(fresh, source.rays, prepared, first);
        orders(walks.rays.negative).store(&mut walks.order);
        let root = &group.nodes[0];
        let none = W16::splat(NO_NODE);
        let node = expand_words(none, fresh, &prepared.node, first);
        let has_node = node.ne(none, u16::MAX);
        node.masked(has_node).store_masked(&mut walks.node, fresh);
        let bits = expand_words(W16::splat(0), fresh, &prepared.bits, first);
        W16::splat(root.child_base_idx).store_masked(&mut walks.base[0], fresh);
        bits.store_masked(&mut walks.bits[0], fresh);
        let has_more = bits.test(bits, u16::MAX);
        W16::splat(1).masked(has_more).store_masked(&mut walks.size, fresh);
        walks.live |= fresh;
        walks.busy |= has_node;
        let entries = expand_words(W16::splat(0), fresh, &prepared.entries, first);
        enqueue_leaves(&mut walks.queue, W16::splat(root.primitive_base_idx), entries, fresh);
    }

    /// A node of each busy lane.
    #[inline]
    fn step(walks: &mut Walks, group: &Group) {
        let busy = walks.busy;
        let met = hit_children(&walks.rays, &group.nodes, &walks.node, &walks.bytes, busy);
        let children = in_order(met.bits.shr::<CHILDREN>(), walks.rays.negative);
        advance(walks, met.child_base, children.shl::<CHILDREN>() | met.is_inner);
        let entries = met.bits & W16::splat(FIRST_CHILD - 1);
        enqueue_leaves(&mut walks.queue, met.entry_base, entries, busy);
    }

    /// Goes to a child of the last node, or to one that waits.
    #[inline]
    fn advance(walks: &mut Walks, child_base: W16, children: W16) {
        let busy = walks.busy;
        let (mut base, mut bits) = (child_base, children);
        let mut size = W16::load(&walks.size);
        let least = W16::splat(FIRST_CHILD);
        let has_none = bits.lt(least, busy);
        let pops = size.test(size, has_none);
        if pops != 0 {
            size = W16::select(pops, size - W16::splat(1), size);
            let at = stack_entry(size).0;
            // SAFETY: what lies below `size` has been written.
            unsafe {
                base = W16(_mm512_mask_i32gather_epi32::<4>(base.0, pops, at, walks.base.as_ptr().cast()));
                bits = W16(_mm512_mask_i32gather_epi32::<4>(bits.0, pops, at, walks.bits.as_ptr().cast()));
            }
        }
        walks.busy = busy & !(has_none & !pops);
        let (index, rest) = first_child(base, bits, W16::load(&walks.order));
        let pushes = rest.ge(least, walks.busy);
        if pushes != 0 {
            let at = stack_entry(size).0;
            // SAFETY: a node is pushed at most once per level, and there are as many entries as levels.
            unsafe {
                _mm512_mask_i32scatter_epi32::<4>(walks.base.as_mut_ptr().cast(), pushes, at, base.0);
                _mm512_mask_i32scatter_epi32::<4>(walks.bits.as_mut_ptr().cast(), pushes, at, rest.0);
            }
            size = W16::select(pushes, size + W16::splat(1), size);
        }
        size.store(&mut walks.size);
        first_words(index).masked(walks.busy).store(&mut walks.node);
    }

    /// Index into a stack, by words, of each lane's entry of a number.
    #[inline]
    fn stack_entry(number: W16) -> W16 {
        number.shl::<4>() + W16::lane_numbers()
    }

    /// Appends the leaf entries whose bits are set in `leaves`, from each node's first on.
    #[inline]
    fn enqueue_leaves(queue: &mut LeafQueue, entry_base: W16, leaves: W16, busy: u16) {
        let mut leaves = leaves;
        let mut left = leaves.test(leaves, busy);
        while left != 0 {
            let lowest = leaves & (W16::splat(0) - leaves);
            let number = W16::splat(31) - lowest.leading_zeros();
            queue.push(left, entry_base + number);
            leaves = leaves ^ lowest;
            left = leaves.test(leaves, left);
        }
    }
}
