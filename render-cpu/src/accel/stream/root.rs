//! The first step of the walks of a stream: the root, for sixteen rays in a row.
//!
//! Every ray begins at the same node, so that its planes are constants instead of rows of sixteen nodes, and what a ray brings
//! to all nodes is prepared for sixteen at once, however few of them a walk takes at a time.

use super::child_order::{CHILDREN, FIRST_CHILD, first_child, first_words, in_order, orders};
use crate::accel::simd::avx512::{F16, LANES, W16, with_avx512};
use crate::accel::simd::boxes::PlaneDistances;
use crate::accel::simd::triangles::{longest_axes, shears};
use crate::accel::simd::{SimdFloat, SimdWord};
use crate::accel::trees::Group;
use halflight_kernel::scene::RayBatch;
use obvhs::cwbvh::node::CwBvhNode;
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// Numbers of which those of rays that have begun are written.
pub type Row<T, const N: usize> = [MaybeUninit<T>; N];

/// What the walks of up to `N` rays begin with.
#[repr(C, align(64))]
pub struct PreparedRays<const N: usize> {
    /// 1 / direction, finite.
    pub inverse: [Row<f32, N>; 3],
    /// See [`crate::accel::simd::triangles::ShearedRays`].
    pub shear: [Row<f32, N>; 3],
    /// The longest axis of each direction.
    pub axis: Row<u32, N>,
    /// First words of the nodes that come next, [`NO_NODE`] where there are none.
    pub node: Row<u32, N>,
    /// Which children of the root are left, as in the walks' stacks; zero for none.
    pub bits: Row<u32, N>,
    /// Bits of the entries of the root's leaves.
    pub entries: Row<u32, N>,
}

/// No node.
pub const NO_NODE: u32 = u32::MAX;

impl<const N: usize> PreparedRays<N> {
    /// No rays.
    pub fn new() -> PreparedRays<N> {
        PreparedRays {
            inverse: [[MaybeUninit::uninit(); N]; 3],
            shear: [[MaybeUninit::uninit(); N]; 3],
            axis: [MaybeUninit::uninit(); N],
            node: [MaybeUninit::uninit(); N],
            bits: [MaybeUninit::uninit(); N],
            entries: [MaybeUninit::uninit(); N],
        }
    }
}

/// The root, as constants.
struct Root<'a> {
    node: &'a CwBvhNode,
    /// Lower and upper planes by axes and children.
    planes: [[[f32; 8]; 2]; 3],
    /// What each child adds to the children and entries that are met.
    bits: [u32; 8],
}

impl Root<'_> {
    fn new(group: &Group) -> Root<'_> {
        let node = &group.nodes[0];
        let floats = |bytes: [u8; 8]| bytes.map(f32::from);
        Root {
            node,
            planes: [
                [floats(node.child_min_x), floats(node.child_max_x)],
                [floats(node.child_min_y), floats(node.child_max_y)],
                [floats(node.child_min_z), floats(node.child_max_z)],
            ],
            bits: node
                .child_meta
                .map(|meta| u32::from(meta >> 5) << (meta & 31)),
        }
    }
}

with_avx512! {
    /// Begins the first `count <= N` rays.
    #[inline]
    pub fn begin_all<const N: usize>(
        group: &Group,
        rays: &RayBatch<N>,
        count: usize,
        prepared: &mut PreparedRays<N>,
    ) {
        debug_assert!(count <= N);
        let root = Root::new(group);
        let child_base = W16::splat(root.node.child_base_idx);
        let is_inner = W16::splat(u32::from(root.node.imask));
        for first in (0..count).step_by(LANES) {
            let lanes = ((1u32 << (count - first).min(LANES)) - 1) as u16;
            // SAFETY: what the mask lets through lies below `count`.
            let row = |row: &[f32; N]| F16(unsafe {
                _mm512_maskz_loadu_ps(lanes, row.as_ptr().add(first))
            });
            let origin = [row(&rays.origin.x), row(&rays.origin.y), row(&rays.origin.z)];
            let direction = [row(&rays.direction.x), row(&rays.direction.y), row(&rays.direction.z)];
            let range = [row(&rays.t_min), row(&rays.t_max)];
            let inverse = [inverse(direction[0]), inverse(direction[1]), inverse(direction[2])];
            let negative = [inverse[0].signs(), inverse[1].signs(), inverse[2].signs()];
            let traceable = are_traceable(origin, direction, range, lanes);
            let bits = hit_children(&root, origin, inverse, negative, range, traceable);

            let children = in_order(bits.shr::<CHILDREN>(), negative).shl::<CHILDREN>() | is_inner;
            let least = W16::splat(FIRST_CHILD);
            let has_child = children.ge(least, u16::MAX);
            let (index, rest) = first_child(child_base, children, orders(negative));
            let next = W16::select(has_child, first_words(index), W16::splat(NO_NODE));
            let has_rest = rest.ge(least, has_child);
            let (is_x, is_y) = longest_axes(direction);
            let shear = shears(direction, is_x, is_y);
            let axis = W16::select(is_y, W16::splat(1), W16::splat(2));
            let axis = W16::select(is_x, W16::splat(0), axis);
            // SAFETY: what the mask lets through lies below `count`.
            let keep = |row: &mut Row<u32, N>, v: W16| unsafe {
                _mm512_mask_storeu_epi32(row.as_mut_ptr().add(first).cast(), lanes, v.0);
            };
            for k in 0..3 {
                // SAFETY: as above.
                unsafe {
                    let at = prepared.inverse[k].as_mut_ptr().add(first).cast();
                    _mm512_mask_storeu_ps(at, lanes, inverse[k].0);
                    let at = prepared.shear[k].as_mut_ptr().add(first).cast();
                    _mm512_mask_storeu_ps(at, lanes, shear[k].0);
                }
            }
            keep(&mut prepared.axis, axis);
            keep(&mut prepared.node, next);
            keep(&mut prepared.bits, rest.masked(has_rest));
            keep(&mut prepared.entries, bits & W16::splat(FIRST_CHILD - 1));
        }
    }

    /// 1 / d, finite, so that no plane distance is zero times infinity.
    #[inline]
    fn inverse(d: F16) -> F16 {
        const TINY: f32 = 1e-18;
        let is_small = _mm512_cmp_ps_mask::<_CMP_NGT_UQ>(d.abs().0, F16::splat(TINY).0);
        let sign = _mm512_and_ps(F16::splat(-0.0).0, d.0);
        let x = F16(_mm512_mask_or_ps(d.0, is_small, F16::splat(TINY).0, sign));
        F16::splat(1.0) / x
    }

    /// The lanes of a mask whose rays can be traced ([`halflight_kernel::scene::intersect::is_traceable`]).
    #[inline]
    pub fn are_traceable(origin: [F16; 3], direction: [F16; 3], range: [F16; 2], lanes: u16) -> u16 {
        let distance = origin[0].abs() + origin[1].abs() + origin[2].abs();
        let length = direction[0].abs() + direction[1].abs() + direction[2].abs();
        let mut lanes = distance.lt(F16::splat(f32::MAX), lanes);
        lanes = length.lt(F16::splat(f32::MAX), lanes);
        lanes = length.gt(F16::splat(0.0), lanes);
        range[0].lt(range[1], lanes)
    }

    /// Bits of the root's children and entries that the rays of a mask meet, see [`super::child_order`].
    #[inline]
    fn hit_children(
        root: &Root<'_>,
        origin: [F16; 3],
        inverse: [F16; 3],
        negative: [u16; 3],
        range: [F16; 2],
        lanes: u16,
    ) -> W16 {
        let distances = PlaneDistances::of_node(root.node, origin, inverse);
        let mut bits = W16::splat(0);
        for child in 0..8 {
            let mut near = origin;
            let mut far = origin;
            for k in 0..3 {
                let [lower, upper] = root.planes[k].map(|planes| F16::splat(planes[child]));
                near[k] = F16::select(negative[k], upper, lower);
                far[k] = F16::select(negative[k], lower, upper);
            }
            let [first, last] = distances.interval(near, far, range);
            let hit = first.le(last, lanes);
            bits = W16::select(hit, bits | W16::splat(root.bits[child]), bits);
        }
        bits
    }
}
