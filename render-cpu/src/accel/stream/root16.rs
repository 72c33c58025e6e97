//! The first step of the walks of a batch: the root, for sixteen rays in a row.
//!
//! Every ray begins at the same node, so that its planes are constants instead of rows of sixteen nodes, and what a ray brings
//! to all nodes is prepared for sixteen at once, however few of them a walk takes at a time.

use super::lanes16::*;
use super::node16::{CHILDREN, FIRST_CHILD, first_child, first_words, grid, in_order, orders};
use super::triangles16::{longest_axes, shears};
use crate::accel::Group;
use halflight_kernel::scene::RayBatch;
use obvhs::cwbvh::node::CwBvhNode;
use std::arch::x86_64::*;
use std::mem::MaybeUninit;

/// Numbers of which those of rays that have begun are written.
type Row<T, const N: usize> = [MaybeUninit<T>; N];

/// What the walks of up to `N` rays begin with.
#[repr(C, align(64))]
pub struct Starts<const N: usize> {
    /// 1 / direction, finite.
    pub inverse: [Row<f32, N>; 3],
    /// See [`super::triangles16::ShearedRays`].
    pub shear: [Row<f32, N>; 3],
    /// The longest axis of each direction.
    pub axis: Row<u32, N>,
    /// First words of the nodes that come next, [`NO_NODE`] where there are none.
    pub node: Row<u32, N>,
    /// Which children of the root are left, as in the walks' stacks; zero for none.
    pub bits: Row<u32, N>,
    /// Bits of the root's places.
    pub places: Row<u32, N>,
}

/// No node.
pub const NO_NODE: u32 = u32::MAX;

impl<const N: usize> Starts<N> {
    /// Of no rays.
    pub fn new() -> Starts<N> {
        Starts {
            inverse: [[MaybeUninit::uninit(); N]; 3],
            shear: [[MaybeUninit::uninit(); N]; 3],
            axis: [MaybeUninit::uninit(); N],
            node: [MaybeUninit::uninit(); N],
            bits: [MaybeUninit::uninit(); N],
            places: [MaybeUninit::uninit(); N],
        }
    }
}

/// The root, as constants.
struct Root<'a> {
    node: &'a CwBvhNode,
    /// Lower and upper planes by axes and children.
    planes: [[[f32; 8]; 2]; 3],
    /// What each child adds to the children and places that are met.
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

avx512! {
    /// Begins the first `count <= N` rays.
    pub fn begin_all<const N: usize>(
        group: &Group,
        rays: &RayBatch<N>,
        count: usize,
        starts: &mut Starts<N>,
    ) {
        debug_assert!(count <= N);
        let root = Root::new(group);
        let node = &group.nodes[0];
        let child_base = word(node.child_base_idx as i32);
        let is_inner = word(i32::from(node.imask));
        for first in (0..count).step_by(LANES) {
            let lanes = ((1u32 << (count - first).min(LANES)) - 1) as u16;
            // SAFETY: what the mask lets through lies below `count`.
            let row = |row: &[f32; N]| unsafe {
                _mm512_maskz_loadu_ps(lanes, row.as_ptr().add(first))
            };
            let origin = [row(&rays.origin.x), row(&rays.origin.y), row(&rays.origin.z)];
            let direction = [row(&rays.direction.x), row(&rays.direction.y), row(&rays.direction.z)];
            let range = [row(&rays.t_min), row(&rays.t_max)];
            let inverse = [inverse(direction[0]), inverse(direction[1]), inverse(direction[2])];
            let negative = inverse.map(|v| _mm512_movepi32_mask(_mm512_castps_si512(v)));
            let traceable = lanes & are_traceable(origin, direction, range);
            let met = meet(&root, origin, inverse, negative, range, traceable);

            let children = in_order(_mm512_srli_epi32::<CHILDREN>(met), negative);
            let bits = _mm512_or_si512(_mm512_slli_epi32::<CHILDREN>(children), is_inner);
            let has_child = _mm512_cmpge_epu32_mask(bits, word(FIRST_CHILD));
            let (index, rest) = first_child(child_base, bits, orders(negative));
            let next = _mm512_mask_mov_epi32(word(NO_NODE as i32), has_child, first_words(index));
            let has_rest = _mm512_mask_cmpge_epu32_mask(has_child, rest, word(FIRST_CHILD));
            let (is_x, is_y) = longest_axes(direction);
            let shear = shears(direction, is_x, is_y);
            let axis = _mm512_mask_mov_epi32(word(2), is_y, word(1));
            // SAFETY: what the mask lets through lies below `count`.
            let keep = |row: &mut Row<u32, N>, v: __m512i| unsafe {
                _mm512_mask_storeu_epi32(row.as_mut_ptr().add(first).cast(), lanes, v);
            };
            for k in 0..3 {
                // SAFETY: as above.
                unsafe {
                    let at = starts.inverse[k].as_mut_ptr().add(first).cast();
                    _mm512_mask_storeu_ps(at, lanes, inverse[k]);
                    let at = starts.shear[k].as_mut_ptr().add(first).cast();
                    _mm512_mask_storeu_ps(at, lanes, shear[k]);
                }
            }
            keep(&mut starts.axis, _mm512_mask_mov_epi32(axis, is_x, word(0)));
            keep(&mut starts.node, next);
            keep(&mut starts.bits, _mm512_maskz_mov_epi32(has_rest, rest));
            keep(&mut starts.places, _mm512_and_si512(met, word(FIRST_CHILD - 1)));
        }
    }

    /// 1 / d, finite, so that no plane distance is zero times infinity.
    fn inverse(d: __m512) -> __m512 {
        let tiny = splat(1e-18);
        let is_small = _mm512_cmp_ps_mask::<_CMP_NGT_UQ>(_mm512_abs_ps(d), tiny);
        let x = _mm512_mask_or_ps(d, is_small, tiny, _mm512_and_ps(splat(-0.0), d));
        _mm512_div_ps(splat(1.0), x)
    }

    /// The lanes of rays that can be traced ([`halflight_kernel::scene::intersect::is_traceable`]).
    pub fn are_traceable(origin: [__m512; 3], direction: [__m512; 3], range: [__m512; 2]) -> u16 {
        let size = |v: [__m512; 3]| {
            let [x, y, z] = v.map(|x| _mm512_abs_ps(x));
            _mm512_add_ps(_mm512_add_ps(x, y), z)
        };
        let (distance, length) = (size(origin), size(direction));
        _mm512_cmp_ps_mask::<_CMP_LT_OQ>(distance, splat(f32::MAX))
            & _mm512_cmp_ps_mask::<_CMP_LT_OQ>(length, splat(f32::MAX))
            & _mm512_cmp_ps_mask::<_CMP_GT_OQ>(length, _mm512_setzero_ps())
            & _mm512_cmp_ps_mask::<_CMP_LT_OQ>(range[0], range[1])
    }

    /// Bits of the root's children and places that the rays of a mask meet, see [`super::lockstep`].
    fn meet(
        root: &Root<'_>,
        origin: [__m512; 3],
        inverse: [__m512; 3],
        negative: [u16; 3],
        range: [__m512; 2],
        lanes: u16,
    ) -> __m512i {
        let [step, low, high] = grid(root.node, origin, inverse);
        let mut met = _mm512_setzero_si512();
        for child in 0..8 {
            let (mut t0, mut t1) = (range[0], range[1]);
            for k in 0..3 {
                let [lower, upper] = root.planes[k].map(|planes| splat(planes[child]));
                let near = _mm512_mask_mov_ps(lower, negative[k], upper);
                let far = _mm512_mask_mov_ps(upper, negative[k], lower);
                t0 = _mm512_max_ps(_mm512_fmadd_ps(near, step[k], low[k]), t0);
                t1 = _mm512_min_ps(_mm512_fmadd_ps(far, step[k], high[k]), t1);
            }
            let hit = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(lanes, t0, t1);
            met = _mm512_mask_or_epi32(met, hit, met, word(root.bits[child] as i32));
        }
        met
    }

}
