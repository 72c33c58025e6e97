//! Nodes and triangles with eight lanes.
//!
//! The arithmetic is that of [`super::node`] and of [`super::block`], hits included to the bit. What a ray brings to every
//! test (its origin and shear in all lanes, which bytes of a node are near planes) is prepared once.

use super::block::{BlockHit, BlockRay};
use super::lanes::Lanes;
use super::node::{Children, Grid, NodeRay};
use crate::accel::build::packed::Place;
use glam::Vec3;
use obvhs::cwbvh::node::CwBvhNode;
use std::arch::x86_64::*;
use std::mem::offset_of;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// Eight lanes at once. Only for processors with AVX2 and FMA: the traverser looks for both before it uses this type, and
/// that is the reason of every `unsafe` in this file.
#[derive(Clone, Copy, Debug)]
pub struct Avx2;

/// Eight floats; each operator is one instruction. Products are not fused with sums, because fused edge functions would
/// lose watertightness.
#[derive(Clone, Copy, Debug)]
struct F8(__m256);

macro_rules! operator {
    ($name:ident, $method:ident, $instruction:ident) => {
        impl $name for F8 {
            type Output = F8;
            #[inline(always)]
            fn $method(self, other: F8) -> F8 {
                // SAFETY: the processor has AVX2.
                F8(unsafe { $instruction(self.0, other.0) })
            }
        }
    };
}
operator!(Add, add, _mm256_add_ps);
operator!(Sub, sub, _mm256_sub_ps);
operator!(Mul, mul, _mm256_mul_ps);
operator!(Div, div, _mm256_div_ps);
operator!(BitAnd, bitand, _mm256_and_ps);
operator!(BitOr, bitor, _mm256_or_ps);

impl F8 {
    #[inline(always)]
    fn splat(x: f32) -> F8 {
        // SAFETY: the processor has AVX2.
        F8(unsafe { _mm256_set1_ps(x) })
    }

    #[inline(always)]
    fn to_array(self) -> [f32; 8] {
        // SAFETY: both are eight floats.
        unsafe { std::mem::transmute(self.0) }
    }

    /// The lesser; `other` where one is a NaN.
    #[inline(always)]
    fn min(self, other: F8) -> F8 {
        // SAFETY: the processor has AVX2.
        F8(unsafe { _mm256_min_ps(self.0, other.0) })
    }

    /// The greater; `other` where one is a NaN.
    #[inline(always)]
    fn max(self, other: F8) -> F8 {
        // SAFETY: the processor has AVX2.
        F8(unsafe { _mm256_max_ps(self.0, other.0) })
    }

    /// All bits of the lanes that compare so.
    #[inline(always)]
    fn compare<const PREDICATE: i32>(self, other: F8) -> F8 {
        // SAFETY: the processor has AVX2.
        F8(unsafe { _mm256_cmp_ps::<PREDICATE>(self.0, other.0) })
    }

    /// `other` where the mask is set.
    #[inline(always)]
    fn replaced(self, other: F8, mask: F8) -> F8 {
        // SAFETY: the processor has AVX2.
        F8(unsafe { _mm256_blendv_ps(self.0, other.0, mask.0) })
    }

    /// The sign bits.
    #[inline(always)]
    fn signs(self) -> u32 {
        // SAFETY: the processor has AVX2.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
}

/// A ray prepared for eight lanes.
#[derive(Clone, Copy, Debug)]
pub struct WideRay {
    node: NodeRay,
    block: BlockRay,
    /// Where in a node the near planes of each axis begin; the far ones are in the other of the two places.
    near: [usize; 3],
    /// The origin in sheared order.
    origin: [F8; 3],
    /// Shear of x and y.
    shear: [F8; 2],
}

/// Where the ray meets the planes at eight bytes of a node.
///
/// # Safety
/// `offset` and the seven bytes after it lie in the node; the processor has AVX2 and FMA.
#[inline(always)]
unsafe fn plane_distances(node: &CwBvhNode, offset: usize, step: f32, base: f32) -> __m256 {
    let bytes = std::ptr::from_ref(node).cast::<u8>();
    // SAFETY: what is asked of the caller.
    unsafe {
        let eight = _mm_loadl_epi64(bytes.add(offset).cast());
        let q = _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(eight));
        _mm256_fmadd_ps(q, _mm256_set1_ps(step), _mm256_set1_ps(base))
    }
}

/// How far behind the lower planes the near ones lie.
#[inline(always)]
fn upper(inverse: f32) -> usize {
    ((inverse.to_bits() >> 31) as usize) * 8
}

/// The planes of an axis: the lower ones come first, the upper ones eight bytes on.
const LOWER: [usize; 3] = [
    offset_of!(CwBvhNode, child_min_x),
    offset_of!(CwBvhNode, child_min_y),
    offset_of!(CwBvhNode, child_min_z),
];
const _: () = {
    assert!(offset_of!(CwBvhNode, child_max_x) == LOWER[0] + 8 && LOWER[0].is_multiple_of(16));
    assert!(offset_of!(CwBvhNode, child_max_y) == LOWER[1] + 8 && LOWER[1].is_multiple_of(16));
    assert!(offset_of!(CwBvhNode, child_max_z) == LOWER[2] + 8 && LOWER[2].is_multiple_of(16));
};

impl Lanes for Avx2 {
    type Ray = WideRay;

    #[inline(always)]
    fn ray(origin: Vec3, direction: Vec3, t_min: f32) -> WideRay {
        let node = NodeRay::new(origin, direction, t_min);
        let block = BlockRay::new(origin, direction, t_min);
        let inverse = node.inverse;
        let [ox, oy, oz] = block.origin;
        WideRay {
            node,
            block,
            near: [
                LOWER[0] + upper(inverse.x),
                LOWER[1] + upper(inverse.y),
                LOWER[2] + upper(inverse.z),
            ],
            origin: [F8::splat(ox), F8::splat(oy), F8::splat(oz)],
            shear: [
                F8::splat(block.sheared.shear.x),
                F8::splat(block.sheared.shear.y),
            ],
        }
    }

    #[inline(always)]
    fn children(node: &CwBvhNode, ray: &WideRay, t_max: f32) -> Children {
        let Grid { step, low, high } = Grid::new(node, &ray.node);
        // SAFETY: `near` holds offsets of `LOWER`, plus eight or not; the processor has AVX2 and FMA.
        unsafe {
            // Offsets of lower planes are multiples of sixteen: the other ones are eight on or back.
            let [nx, ny, nz] = ray.near;
            let t0 = _mm256_max_ps(
                _mm256_max_ps(
                    plane_distances(node, nx, step.x, low.x),
                    plane_distances(node, ny, step.y, low.y),
                ),
                _mm256_max_ps(
                    plane_distances(node, nz, step.z, low.z),
                    _mm256_set1_ps(ray.node.t_min),
                ),
            );
            let t1 = _mm256_min_ps(
                _mm256_min_ps(
                    plane_distances(node, nx ^ 8, step.x, high.x),
                    plane_distances(node, ny ^ 8, step.y, high.y),
                ),
                _mm256_min_ps(
                    plane_distances(node, nz ^ 8, step.z, high.z),
                    _mm256_set1_ps(t_max),
                ),
            );
            let hit = _mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(t0, t1));
            let meta = _mm256_cvtepu8_epi32(_mm_loadl_epi64(node.child_meta.as_ptr().cast()));
            let shift = _mm256_and_si256(meta, _mm256_set1_epi32(31));
            let bits = _mm256_sllv_epi32(_mm256_srli_epi32::<5>(meta), shift);
            let bits = _mm256_and_si256(bits, hit);
            let four = _mm_or_si128(
                _mm256_castsi256_si128(bits),
                _mm256_extracti128_si256::<1>(bits),
            );
            let two = _mm_or_si128(four, _mm_shuffle_epi32::<0b_01_00_11_10>(four));
            let one = _mm_or_si128(two, _mm_shuffle_epi32::<0b_10_11_00_01>(two));
            Children {
                near: F8(t0).to_array(),
                hits: _mm_cvtsi128_si32(one) as u32,
            }
        }
    }

    #[inline(always)]
    fn nearest(places: &[Place], mask: u32, ray: &WideRay, t_max: f32) -> BlockHit {
        let mut hit = BlockHit::MISS;
        let mut left = mask;
        while left != 0 {
            // Both triangles of four of them, the first again where there are fewer.
            let first = &places[left.trailing_zeros() as usize];
            let mut four = [first; 4];
            let mut count = 0;
            while left != 0 && count < 4 {
                four[count] = &places[left.trailing_zeros() as usize];
                left &= left - 1;
                count += 1;
            }
            nearest_of(&four, (1 << count) - 1, ray, t_max, &mut hit);
        }
        hit
    }
}

/// Columns of rows.
#[inline(always)]
fn columns(rows: [&[f32; 4]; 8]) -> [F8; 4] {
    // SAFETY: the processor has AVX2, and rows are four floats.
    unsafe {
        let two = |k: usize| {
            let low = _mm_loadu_ps(rows[k].as_ptr());
            let high = _mm_loadu_ps(rows[k + 4].as_ptr());
            _mm256_insertf128_ps::<1>(_mm256_castps128_ps256(low), high)
        };
        let (a, b, c, d) = (two(0), two(1), two(2), two(3));
        let t0 = _mm256_castps_pd(_mm256_unpacklo_ps(a, b));
        let t1 = _mm256_castps_pd(_mm256_unpackhi_ps(a, b));
        let t2 = _mm256_castps_pd(_mm256_unpacklo_ps(c, d));
        let t3 = _mm256_castps_pd(_mm256_unpackhi_ps(c, d));
        [
            F8(_mm256_castpd_ps(_mm256_unpacklo_pd(t0, t2))),
            F8(_mm256_castpd_ps(_mm256_unpackhi_pd(t0, t2))),
            F8(_mm256_castpd_ps(_mm256_unpacklo_pd(t1, t3))),
            F8(_mm256_castpd_ps(_mm256_unpackhi_pd(t1, t3))),
        ]
    }
}

/// Keeps the first hit of those of the triangles of the places whose bits are set in `mask`, if it comes before `hit`.
#[inline(always)]
fn nearest_of(places: &[&Place; 4], mask: u32, ray: &WideRay, t_max: f32, hit: &mut BlockHit) {
    let corners: [[&[f32; 4]; 3]; 8] = std::array::from_fn(|k| places[k % 4].corners(k / 4));
    let [x0, y0, z0, _] = columns(corners.map(|[a, _, _]| a));
    let [x1, y1, z1, _] = columns(corners.map(|[_, b, _]| b));
    let [x2, y2, z2, _] = columns(corners.map(|[_, _, c]| c));
    let mask = mask * 0b1_0001;
    let (ax, ay, az) = vertex([x0, y0, z0], ray);
    let (bx, by, bz) = vertex([x1, y1, z1], ray);
    let (cx, cy, cz) = vertex([x2, y2, z2], ray);
    let (mut u, mut v, mut w) = (cx * by - cy * bx, ax * cy - ay * cx, bx * ay - by * ax);
    let mut hits = mask & one_sided(u, v, w);
    if hits == 0 {
        return;
    }
    let zero = F8::splat(0.0);
    let zeros = u.compare::<_CMP_EQ_OQ>(zero)
        | v.compare::<_CMP_EQ_OQ>(zero)
        | w.compare::<_CMP_EQ_OQ>(zero);
    if hits & zeros.signs() != 0 {
        u = nonzero_edge(u, cx, cy, bx, by);
        v = nonzero_edge(v, ax, ay, cx, cy);
        w = nonzero_edge(w, bx, by, ax, ay);
        hits &= one_sided(u, v, w);
    }
    let determinant = u + v + w;
    let size = determinant & F8::splat(f32::from_bits(0x7fff_ffff));
    let is_solid =
        size.compare::<_CMP_GT_OQ>(zero) & size.compare::<_CMP_LT_OQ>(F8::splat(f32::MAX));

    // Where the plane is met, clamped to the range of the vertices along the ray.
    let p0 = [x0, y0, z0];
    let e1 = [x1 - x0, y1 - y0, z1 - z0];
    let e2 = [x2 - x0, y2 - y0, z2 - z0];
    let n = [
        e1[1] * e2[2] - e2[1] * e1[2],
        e1[2] * e2[0] - e2[2] * e1[0],
        e1[0] * e2[1] - e2[0] * e1[1],
    ];
    let sheared = &ray.block.sheared;
    let (o, d) = (sheared.origin, sheared.direction);
    let offset = [
        p0[0] - F8::splat(o.x),
        p0[1] - F8::splat(o.y),
        p0[2] - F8::splat(o.z),
    ];
    let direction = [F8::splat(d.x), F8::splat(d.y), F8::splat(d.z)];
    let plane = dot(n, offset) / dot(n, direction);
    let scale = F8::splat(-sheared.shear.z);
    let (za, zb, zc) = (az * scale, bz * scale, cz * scale);
    // A NaN from 0/0 is replaced by the bounds as well.
    let t = plane.max(za.min(zb).min(zc)).min(za.max(zb).max(zc));
    let in_range = t.compare::<_CMP_GT_OQ>(F8::splat(ray.block.t_min))
        & t.compare::<_CMP_LT_OQ>(F8::splat(t_max));
    hits &= (is_solid & in_range).signs();
    let t = t.to_array();
    while hits != 0 {
        let k = hits.trailing_zeros() as usize & 7;
        hits &= hits - 1;
        let primitive = match k {
            0..4 => places[k].primitive(),
            _ => places[k - 4].partner(),
        };
        if hit.is_behind(t[k], primitive) {
            let scale = 1.0 / determinant.to_array()[k];
            *hit = BlockHit {
                t: t[k],
                b1: v.to_array()[k] * scale,
                b2: w.to_array()[k] * scale,
                primitive,
            };
        }
    }
}

/// A vertex of each triangle in sheared space, relative to the origin and with its signs turned, which changes no edge
/// function.
#[inline(always)]
fn vertex(p: [F8; 3], ray: &WideRay) -> (F8, F8, F8) {
    let [rx, ry, rz] = ray.block.rows;
    let z = ray.origin[2] - p[rz];
    let x = (ray.origin[0] - p[rx]) - ray.shear[0] * z;
    let y = (ray.origin[1] - p[ry]) - ray.shear[1] * z;
    (x, y, z)
}

/// x + y + z of the products, from the left.
#[inline(always)]
fn dot(p: [F8; 3], q: [F8; 3]) -> F8 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

/// The edge function p x q, where rounding has lost it from the difference of the vertices.
#[inline(always)]
fn nonzero_edge(edge: F8, px: F8, py: F8, qx: F8, qy: F8) -> F8 {
    let difference = (px + qx) * (qy - py) - (py + qy) * (qx - px);
    let is_zero = edge.compare::<_CMP_EQ_OQ>(F8::splat(0.0));
    edge.replaced(F8::splat(0.5) * difference, is_zero)
}

/// The places where no two edges have opposite signs. A NaN may hide one of them; such triangles are missed either way.
#[inline(always)]
fn one_sided(u: F8, v: F8, w: F8) -> u32 {
    let zero = F8::splat(0.0);
    let below = u.min(v.min(w)).compare::<_CMP_LT_OQ>(zero);
    let above = u.max(v.max(w)).compare::<_CMP_GT_OQ>(zero);
    !(below & above).signs()
}
