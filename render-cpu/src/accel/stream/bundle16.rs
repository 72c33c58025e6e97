//! Sixteen rays that go the same way, together through the tree.
//!
//! Samples of a pixel begin with rays that meet the same nodes in the same order. They need no places of their own in the
//! tree ([`super::lockstep`]): a node's planes and a triangle's vertices are the same numbers for all of them and need not be
//! gathered (Wald, Slusallek, Benthin and Wagner 2001, "Interactive Rendering with Coherent Ray Tracing").
//! What each ray meets is the same to the bit.

use super::lanes16::*;
use super::node16::grid;
use super::root16::are_traceable;
use super::sixteen::{Sixteen, keep_first, sheared};
use super::spheres16::{self, test_spheres};
use super::triangles16;
use crate::accel::Group;
use crate::accel::build::MAX_WIDE_DEPTH;
use crate::accel::traverse::CpuTraverse;
use halflight_kernel::scene::RayBatch;
use obvhs::cwbvh::node::CwBvhNode;
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// The part of its length by which a direction may differ from that of the first ray along each axis: some pixels.
const DIRECTIONS: f32 = 0.01;

/// The part of the tree's extent by which an origin may.
const ORIGINS: f32 = 0.01;

/// Nodes that wait: of each node on the way down at most seven children, and all eight of the last.
const STACK_SIZE: usize = 7 * MAX_WIDE_DEPTH + 1;

avx512! {
    /// Whether sixteen rays of a batch, from `first` on, go the same way.
    pub fn is_bundle<const N: usize>(group: &Group, rays: &RayBatch<N>, first: usize) -> bool {
        if first + LANES > N {
            return false;
        }
        // SAFETY: sixteen numbers follow.
        let row = |row: &[f32; N]| unsafe { _mm512_loadu_ps(row.as_ptr().add(first)) };
        let direction = [row(&rays.direction.x), row(&rays.direction.y), row(&rays.direction.z)];
        for d in direction {
            let negative = _mm512_movepi32_mask(_mm512_castps_si512(d));
            if negative != 0 && negative != u16::MAX {
                return false;
            }
        }
        let same = |v: [__m512; 3], reach: f32| {
            let mut lanes = u16::MAX;
            for x in v {
                let first = _mm512_broadcastss_ps(_mm512_castps512_ps128(x));
                let distance = _mm512_abs_ps(_mm512_sub_ps(x, first));
                lanes = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(lanes, distance, splat(reach));
            }
            lanes == u16::MAX
        };
        let length = (0..3).fold(0.0f32, |length, k| {
            length.max(_mm512_cvtss_f32(direction[k]).abs())
        });
        if !same(direction, DIRECTIONS * length) {
            return false;
        }
        let origin = [row(&rays.origin.x), row(&rays.origin.y), row(&rays.origin.z)];
        let extent = group.nodes[0].e.map(|e| 255.0 * f32::from_bits(u32::from(e) << 23));
        let range = [row(&rays.t_min), row(&rays.t_max)];
        same(origin, ORIGINS * extent.into_iter().fold(0.0, f32::max))
            && are_traceable(origin, direction, range) == u16::MAX
    }

    /// The lanes of a mask that meet each child of a node, and the children that are met, as bits.
    fn meet(sixteen: &Sixteen, node: &CwBvhNode, lanes: u16) -> ([u16; 8], u32) {
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
        let range = [load(&sixteen.t_min), load(&sixteen.t_max)];
        let three = |rows: &[Floats; 3]| [load(&rows[0]), load(&rows[1]), load(&rows[2])];
        let [step, low, high] = grid(node, three(&sixteen.origin), three(&sixteen.inverse));
        let is_negative = sixteen.negative.map(|lanes| usize::from(lanes & 1));
        let near = [0, 1, 2].map(|k| &planes[k][is_negative[k]]);
        let far = [0, 1, 2].map(|k| &planes[k][1 - is_negative[k]]);
        let mut masks = [0; 8];
        let mut met = 0;
        for child in 0..8 {
            let (mut t0, mut t1) = (range[0], range[1]);
            for k in 0..3 {
                t0 = _mm512_max_ps(_mm512_fmadd_ps(splat(near[k][child]), step[k], low[k]), t0);
                t1 = _mm512_min_ps(_mm512_fmadd_ps(splat(far[k][child]), step[k], high[k]), t1);
            }
            let mask = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(lanes, t0, t1);
            masks[child] = mask;
            met |= u32::from(mask != 0 && node.child_meta[child] != 0) << child;
        }
        (masks, met)
    }
}

impl CpuTraverse<'_> {
    /// Traces the rays, which are a bundle; with `any` whichever hit comes first will do. Returns how many of the sixteen have met
    /// a node on average.
    #[target_feature(
        enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,popcnt,bmi1,bmi2,lzcnt"
    )]
    pub(in crate::accel) fn trace_bundle(
        &self,
        sixteen: &mut Sixteen,
        group: &Group,
        any: bool,
    ) -> f32 {
        let (mut nodes, mut visits) = (0u32, 0u32);
        let mut stack = [const { MaybeUninit::<(u32, u16)>::uninit() }; STACK_SIZE];
        stack[0].write((0, u16::MAX));
        let mut size = 1;
        let mut alive = u16::MAX;
        // What slots are exchanged with for their places, of which the last comes first.
        let order = (0..3).fold(7, |order, k| {
            order ^ (usize::from(sixteen.negative[k] & 1) << (2 - k))
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
            let (masks, met) = meet(sixteen, node, lanes);
            let inner = met & u32::from(node.imask);
            let leaves = met & !inner;
            if leaves != 0 {
                for place in (0..8).rev() {
                    let slot = place ^ order;
                    if leaves & (1 << slot) == 0 {
                        continue;
                    }
                    let meta = node.child_meta[slot];
                    let first = node.primitive_base_idx as usize + usize::from(meta & 31);
                    // Counted in unary.
                    for place in first..first + (meta >> 5).count_ones() as usize {
                        let met = self.test_place(sixteen, group, place, masks[slot] & alive, any);
                        if any {
                            alive &= !met;
                        }
                    }
                }
            }
            if inner != 0 {
                for place in 0..8 {
                    let slot = place ^ order;
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

    /// Tests a place for the lanes of a mask; those that have met something.
    #[inline]
    #[target_feature(
        enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,popcnt,bmi1,bmi2,lzcnt"
    )]
    fn test_place(
        &self,
        sixteen: &mut Sixteen,
        group: &Group,
        at: usize,
        lanes: u16,
        any: bool,
    ) -> u16 {
        let place = &group.places[at];
        let rays = sheared(sixteen);
        let name = word(place.primitive() as i32);
        if group.is_mixed && place.primitive() >= self.tables.triangles.len() as u32 {
            let spheres = spheres16::are_spheres(&self.tables, name, lanes);
            let met = test_spheres(sixteen, &self.tables, &rays, lane_numbers(), name, spheres);
            let places = Words::all(at as u32);
            let others = lanes & !spheres;
            return met | self.test_others(sixteen, group, &places, lane_numbers(), others, any);
        }
        let vertex = |k: usize| {
            let [x, y, z, _] = *place.row(k);
            [splat(x), splat(y), splat(z)]
        };
        let vertices = [vertex(0), vertex(1), vertex(2), vertex(3)];
        let partner = word(place.partner() as i32);
        let turns = word(place.row(2)[3].to_bits() as i32);
        let (found, names) =
            triangles16::nearest::<true>(&rays, &vertices, name, partner, turns, lanes);
        if found.mask == 0 {
            return 0;
        }
        keep_first(sixteen, found.mask, [found.t, found.b1, found.b2], names)
    }
}
