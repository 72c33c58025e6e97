//! A single ray with eight lanes: the eight children of a node, or eight triangles, at once.
//!
//! Boxes and triangles are tested as everywhere ([`crate::accel::simd`]), hits are those of [`super::triangles`] to the bit.
//! What a ray brings to every test (its origin and shear in all lanes, which bytes of a node are near planes) is prepared
//! once.

use super::instruction_set::InstructionSet;
use super::node::{Children, Grid, NodeRay};
use super::triangles::{TriangleHit, TriangleRay};
use crate::accel::build::leaf_entry::LeafEntry;
use crate::accel::simd::avx2::{F8, M8};
use crate::accel::simd::boxes::PlaneDistances;
use crate::accel::simd::triangles::{
    PlaneHit, Sheared, ShearedRays, edge_function, have_no_opposite_signs, nonzero_edge,
    sheared_vertex,
};
use crate::accel::simd::{SimdFloat, SimdMask};
use glam::{Vec3, Vec3A};
use obvhs::cwbvh::node::CwBvhNode;
use std::arch::x86_64::*;
use std::mem::offset_of;

/// Eight lanes at once. Only for processors with AVX2 and FMA: the traverser looks for both before it uses this type, and
/// that is the reason of every `unsafe` in this file without another one.
#[derive(Clone, Copy, Debug)]
pub struct Avx2;

/// A ray prepared for eight lanes.
#[derive(Clone, Copy, Debug)]
pub struct WideRay {
    node: NodeRay,
    triangles: TriangleRay,
    /// Where in a node the near planes of each axis begin; the far ones are eight bytes on or back.
    near: [usize; 3],
    /// The origin in sheared order.
    origin: [F8; 3],
    /// Shear of x and y.
    shear: [F8; 2],
}

/// The planes at eight bytes of a node.
///
/// # Safety
/// `offset` and the seven bytes after it lie in the node; the processor has AVX2 and FMA.
#[inline(always)]
unsafe fn planes(node: &CwBvhNode, offset: usize) -> F8 {
    let bytes = std::ptr::from_ref(node).cast::<u8>();
    // SAFETY: what is asked of the caller.
    unsafe {
        let eight = _mm_loadl_epi64(bytes.add(offset).cast());
        F8(_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(eight)))
    }
}

/// The components in all lanes.
#[inline(always)]
fn splat3(v: Vec3A) -> [F8; 3] {
    [F8::splat(v.x), F8::splat(v.y), F8::splat(v.z)]
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

impl InstructionSet for Avx2 {
    type Ray = WideRay;

    #[inline(always)]
    fn ray(origin: Vec3, direction: Vec3, t_min: f32) -> WideRay {
        let node = NodeRay::new(origin, direction, t_min);
        let triangles = TriangleRay::new(origin, direction, t_min);
        let inverse = node.inverse;
        let [ox, oy, oz] = triangles.origin;
        WideRay {
            node,
            triangles,
            near: [
                LOWER[0] + upper(inverse.x),
                LOWER[1] + upper(inverse.y),
                LOWER[2] + upper(inverse.z),
            ],
            origin: [F8::splat(ox), F8::splat(oy), F8::splat(oz)],
            shear: [
                F8::splat(triangles.sheared.shear.x),
                F8::splat(triangles.sheared.shear.y),
            ],
        }
    }

    #[inline(always)]
    fn children(node: &CwBvhNode, ray: &WideRay, t_max: f32) -> Children {
        let Grid { step, low, high } = Grid::new(node, &ray.node);
        let distances = PlaneDistances {
            step: splat3(step),
            low: splat3(low),
            high: splat3(high),
        };
        let [nx, ny, nz] = ray.near;
        // SAFETY: `near` holds offsets of `LOWER`, plus eight or not. Those are multiples of sixteen: the other planes are
        // eight bytes on or back.
        let (near, far) = unsafe {
            (
                [planes(node, nx), planes(node, ny), planes(node, nz)],
                [
                    planes(node, nx ^ 8),
                    planes(node, ny ^ 8),
                    planes(node, nz ^ 8),
                ],
            )
        };
        let range = [F8::splat(ray.node.t_min), F8::splat(t_max)];
        let [first, last] = distances.interval(near, far, range);
        let hit = first.le(last, M8::all());
        // SAFETY: see `Avx2`.
        unsafe {
            let hit = _mm256_castps_si256(hit.0);
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
                near: first.to_array(),
                hits: _mm_cvtsi128_si32(one) as u32,
            }
        }
    }

    #[inline(always)]
    fn nearest(entries: &[LeafEntry], mask: u32, ray: &WideRay, t_max: f32) -> TriangleHit {
        let mut hit = TriangleHit::MISS;
        let mut left = mask;
        while left != 0 {
            // Both triangles of four entries, the first again where there are fewer.
            let first = &entries[left.trailing_zeros() as usize];
            let mut four = [first; 4];
            let mut count = 0;
            while left != 0 && count < 4 {
                four[count] = &entries[left.trailing_zeros() as usize];
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
    // SAFETY: rows are four floats.
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

/// Keeps the first hit of those of the triangles of the entries whose bits are set in `mask`, if it comes before `hit`.
#[inline(always)]
fn nearest_of(
    entries: &[&LeafEntry; 4],
    mask: u32,
    ray: &WideRay,
    t_max: f32,
    hit: &mut TriangleHit,
) {
    let corners: [[&[f32; 4]; 3]; 8] = std::array::from_fn(|k| entries[k % 4].corners(k / 4));
    let [x0, y0, z0, _] = columns(corners.map(|[a, _, _]| a));
    let [x1, y1, z1, _] = columns(corners.map(|[_, b, _]| b));
    let [x2, y2, z2, _] = columns(corners.map(|[_, _, c]| c));
    let mask = M8::from_bits(mask * 0b1_0001);
    let (p0, p1, p2) = ([x0, y0, z0], [x1, y1, z1], [x2, y2, z2]);
    let (a, b, c) = (vertex(p0, ray), vertex(p1, ray), vertex(p2, ray));
    let mut edges = [
        edge_function(c, b),
        edge_function(a, c),
        edge_function(b, a),
    ];
    let mut passing = have_no_opposite_signs(edges, mask);
    if !passing.any() {
        return;
    }
    let zero = F8::splat(0.0);
    let zeros =
        edges[0].eq(zero, passing) | edges[1].eq(zero, passing) | edges[2].eq(zero, passing);
    if zeros.any() {
        edges[0] = nonzero_edge(edges[0], c, b);
        edges[1] = nonzero_edge(edges[1], a, c);
        edges[2] = nonzero_edge(edges[2], b, a);
        passing = have_no_opposite_signs(edges, passing);
    }
    let sheared = &ray.triangles.sheared;
    let [sx, sy] = ray.shear;
    let rays = ShearedRays {
        origin: splat3(sheared.origin.into()),
        direction: splat3(sheared.direction.into()),
        shear: [sx, sy, F8::splat(sheared.shear.z)],
        // The vertices are in sheared order already.
        is_x: M8::from_bits(0),
        is_y: M8::from_bits(0),
        t_min: F8::splat(ray.triangles.t_min),
        t_max: F8::splat(t_max),
    };
    let plane = PlaneHit::new(&rays, edges, [p0, p1, p2], [a.z, b.z, c.z], passing);
    let mut hits = plane.mask.to_bits();
    let t = plane.t.to_array();
    while hits != 0 {
        let k = hits.trailing_zeros() as usize & 7;
        hits &= hits - 1;
        let primitive = match k {
            0..4 => entries[k].primitive(),
            _ => entries[k - 4].partner(),
        };
        if hit.is_behind(t[k], primitive) {
            let scale = 1.0 / plane.determinant.to_array()[k];
            *hit = TriangleHit {
                t: t[k],
                b1: edges[1].to_array()[k] * scale,
                b2: edges[2].to_array()[k] * scale,
                primitive,
            };
        }
    }
}

/// A vertex of each triangle in sheared space.
#[inline(always)]
fn vertex(p: [F8; 3], ray: &WideRay) -> Sheared<F8> {
    let [rx, ry, rz] = ray.triangles.rows;
    let relative = [
        ray.origin[0] - p[rx],
        ray.origin[1] - p[ry],
        ray.origin[2] - p[rz],
    ];
    sheared_vertex(relative, ray.shear)
}
