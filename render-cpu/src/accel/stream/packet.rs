//! Packets: sixteen rays that start and point alike, together through the tree.
//!
//! Samples of a pixel begin with rays that meet the same nodes in the same order. They need no nodes of their own
//! ([`super::lockstep`]): a node's planes and a triangle's vertices are the same numbers for all of them and need not be
//! gathered (Wald, Slusallek, Benthin and Wagner 2001, "Interactive Rendering with Coherent Ray Tracing").
//! What each ray meets is the same to the bit.

use super::leaves::test_entry;
use super::rays::RayLanes;
use super::root::are_traceable;
use crate::accel::build::MAX_WIDE_DEPTH;
use crate::accel::simd::SimdFloat;
use crate::accel::simd::avx512::{F16, LANES, with_avx512};
use crate::accel::simd::boxes::PlaneDistances;
use crate::accel::single::walk::World;
use crate::accel::trees::Group;
use halflight_kernel::scene::RayBatch;
use obvhs::cwbvh::node::CwBvhNode;
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// By how much of its length a direction may differ from that of the first ray along each axis: some pixels.
const DIRECTION_SPREAD: f32 = 0.01;

/// By how much of the tree's extent an origin may.
const ORIGIN_SPREAD: f32 = 0.01;

/// Nodes on the stack: at most seven children of each node down to the current one, and all eight of that.
const STACK_SIZE: usize = 7 * MAX_WIDE_DEPTH + 1;

with_avx512! {
    /// Whether sixteen rays of a stream, from `first` on, are a packet.
    #[inline]
    pub fn is_packet<const N: usize>(group: &Group, rays: &RayBatch<N>, first: usize) -> bool {
        if first + LANES > N {
            return false;
        }
        // SAFETY: sixteen numbers follow.
        let row = |row: &[f32; N]| F16(unsafe { _mm512_loadu_ps(row.as_ptr().add(first)) });
        let direction = [row(&rays.direction.x), row(&rays.direction.y), row(&rays.direction.z)];
        for d in direction {
            let negative = d.signs();
            if negative != 0 && negative != u16::MAX {
                return false;
            }
        }
        let are_near = |v: [F16; 3], reach: f32| {
            let mut lanes = u16::MAX;
            for x in v {
                let first = F16(_mm512_broadcastss_ps(_mm512_castps512_ps128(x.0)));
                lanes = (x - first).abs().le(F16::splat(reach), lanes);
            }
            lanes == u16::MAX
        };
        let length = (0..3).fold(0.0f32, |length, k| {
            length.max(_mm512_cvtss_f32(direction[k].0).abs())
        });
        if !are_near(direction, DIRECTION_SPREAD * length) {
            return false;
        }
        let origin = [row(&rays.origin.x), row(&rays.origin.y), row(&rays.origin.z)];
        let extent = group.nodes[0].e.map(|e| 255.0 * f32::from_bits(u32::from(e) << 23));
        let range = [row(&rays.t_min), row(&rays.t_max)];
        are_near(origin, ORIGIN_SPREAD * extent.into_iter().fold(0.0, f32::max))
            && are_traceable(origin, direction, range, u16::MAX) == u16::MAX
    }

    /// The lanes of a mask that meet each child of a node, and the children that are met, as bits.
    #[inline]
    fn hit_children(rays: &RayLanes, node: &CwBvhNode, lanes: u16) -> ([u16; 8], u32) {
        let floats = |bytes: &[u8; 8]| {
            let mut floats = [0.0; 8];
            // SAFETY: eight bytes and eight floats.
            unsafe {
                let words = _mm256_cvtepu8_epi32(_mm_loadl_epi64(bytes.as_ptr().cast()));
                _mm256_storeu_ps(floats.as_mut_ptr(), _mm256_cvtepi32_ps(words));
            }
            floats
        };
        let planes = [
            [floats(&node.child_min_x), floats(&node.child_max_x)],
            [floats(&node.child_min_y), floats(&node.child_max_y)],
            [floats(&node.child_min_z), floats(&node.child_max_z)],
        ];
        let range = [F16::load(&rays.t_min), F16::load(&rays.t_max)];
        let (origin, inverse) = (F16::load3(&rays.origin), F16::load3(&rays.inverse));
        let distances = PlaneDistances::of_node(node, origin, inverse);
        let is_negative = rays.negative.map(|lanes| usize::from(lanes & 1));
        let near = [0, 1, 2].map(|k| &planes[k][is_negative[k]]);
        let far = [0, 1, 2].map(|k| &planes[k][1 - is_negative[k]]);
        let mut masks = [0; 8];
        let mut met = 0;
        for child in 0..8 {
            let near = near.map(|planes| F16::splat(planes[child]));
            let far = far.map(|planes| F16::splat(planes[child]));
            let [first, last] = distances.interval(near, far, range);
            let mask = first.le(last, lanes);
            masks[child] = mask;
            met |= u32::from(mask != 0 && node.child_meta[child] != 0) << child;
        }
        (masks, met)
    }

    /// Traces the rays, which are a packet; with `any` whichever hit comes first will do. Returns how many of the sixteen have
    /// met a node on average.
    pub fn trace_packet(world: &World<'_>, group: &Group, rays: &mut RayLanes, any: bool) -> f32 {
        let (mut nodes, mut visits) = (0u32, 0u32);
        let mut stack = [const { MaybeUninit::<(u32, u16)>::uninit() }; STACK_SIZE];
        stack[0].write((0, u16::MAX));
        let mut size = 1;
        let mut alive = u16::MAX;
        // The exclusive-or mask by which slots are ordered, of which the last comes first.
        let order = (0..3).fold(7, |order, k| {
            order ^ (usize::from(rays.negative[k] & 1) << (2 - k))
        });
        while size > 0 {
            size -= 1;
            // SAFETY: what lies below the size has been written.
            let (index, lanes) = unsafe { stack[size].assume_init() };
            let lanes = lanes & alive;
            if lanes == 0 {
                continue;
            }
            nodes += 1;
            visits += lanes.count_ones();
            let node = &group.nodes[index as usize];
            let (masks, met) = hit_children(rays, node, lanes);
            let inner = met & u32::from(node.imask);
            let leaves = met & !inner;
            if leaves != 0 {
                for rank in (0..8).rev() {
                    let slot = rank ^ order;
                    if leaves & (1 << slot) == 0 {
                        continue;
                    }
                    let meta = node.child_meta[slot];
                    let first = node.primitive_base_idx as usize + usize::from(meta & 31);
                    // Counted in unary.
                    for entry in first..first + (meta >> 5).count_ones() as usize {
                        let met = test_entry(world, group, rays, entry, masks[slot] & alive, any);
                        if any {
                            alive &= !met;
                        }
                    }
                }
            }
            if inner != 0 {
                for rank in 0..8 {
                    let slot = rank ^ order;
                    if inner & (1 << slot) != 0 {
                        let before = u32::from(node.imask) & ((1 << slot) - 1);
                        let index = node.child_base_idx + before.count_ones();
                        stack[size].write((index, masks[slot]));
                        size += 1;
                    }
                }
            }
        }
        visits as f32 / nodes as f32
    }
}
