//! A ray against the eight children of a compressed node.
//!
//! Child k's box has its corners on the node's grid: plane q of axis a lies at p_a + q e_a, and the ray meets it at
//! t = (p_a - o_a) / d_a + q e_a / d_a. Both terms round relative to their own size, so that the near planes are moved back
//! and the far ones forth by that much: a box is never missed, and no ray slips between boxes that touch.
//!
//! The same test is written for eight lanes ([`super::avx2`]), for four (SSE2, every x86-64) and portably. They may
//! differ in the last bit of a distance, never in whether a primitive's box is found.

use glam::{Vec3, Vec3A};
use halflight_kernel::math::select;
use obvhs::cwbvh::node::CwBvhNode;

/// What nodes need of a ray.
#[derive(Clone, Copy, Debug)]
pub struct NodeRay {
    origin: Vec3A,
    /// 1 / direction, finite, so that no plane distance is zero times infinity.
    pub(super) inverse: Vec3A,
    is_negative: [bool; 3],
    pub(super) t_min: f32,
}

impl NodeRay {
    /// Prepares a ray.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3, t_min: f32) -> NodeRay {
        let inverse = direction.map(|x| 1.0 / select(x.abs() > 1e-18, x, 1e-18f32.copysign(x)));
        let is_negative = [inverse.x < 0.0, inverse.y < 0.0, inverse.z < 0.0];
        NodeRay {
            origin: origin.into(),
            inverse: inverse.into(),
            is_negative,
            t_min,
        }
    }
}

/// Plane distances of a node: t = q step + low for near planes and q step + high for far ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub step: Vec3A,
    pub low: Vec3A,
    pub high: Vec3A,
}

impl Grid {
    #[inline(always)]
    pub fn new(node: &CwBvhNode, ray: &NodeRay) -> Grid {
        let step = node.compute_extent() * ray.inverse;
        let base = (Vec3A::from(node.p) - ray.origin) * ray.inverse;
        // Four roundings of each term, doubled.
        let error = (base.abs() + step.abs() * 255.0) * 5e-7;
        Grid {
            step,
            low: base - error,
            high: base + error,
        }
    }
}

/// The planes of all children.
struct Planes {
    grid: Grid,
    /// Near planes of x, y, z, then far ones: a byte per child.
    bytes: [u64; 6],
}

impl Planes {
    #[inline(always)]
    fn new(node: &CwBvhNode, ray: &NodeRay) -> Planes {
        let order = |negative: bool, min: [u8; 8], max: [u8; 8]| {
            let (min, max) = (u64::from_le_bytes(min), u64::from_le_bytes(max));
            if negative { (max, min) } else { (min, max) }
        };
        let [nx, ny, nz] = ray.is_negative;
        let (x0, x1) = order(nx, node.child_min_x, node.child_max_x);
        let (y0, y1) = order(ny, node.child_min_y, node.child_max_y);
        let (z0, z1) = order(nz, node.child_min_z, node.child_max_z);
        Planes {
            grid: Grid::new(node, ray),
            bytes: [x0, y0, z0, x1, y1, z1],
        }
    }
}

/// The children that a ray meets.
#[derive(Clone, Copy, Debug)]
#[repr(align(32))]
pub struct Children {
    /// Entry distances; meaningless for children that are not hit.
    pub near: [f32; 8],
    /// What lies behind the boxes that the ray meets in (t_min, t_max): 24 entries of the node's leaves, then a bit per
    /// child that is a node. The format of the nodes is made for this: shifting the upper three bits of a child's
    /// `child_meta` by the lower five sets the child's bits.
    pub hits: u32,
}

impl Children {
    /// Leaf entries, from the node's first one on.
    #[inline(always)]
    pub fn entries(&self) -> u32 {
        self.hits & 0xff_ffff
    }

    /// Children that are nodes.
    #[inline(always)]
    pub fn inner(&self) -> u32 {
        self.hits >> 24
    }
}

/// The bits of a child in [`Children::hits`].
#[inline(always)]
fn bits(meta: u8) -> u32 {
    u32::from(meta >> 5) << (meta & 31)
}

/// The children that the ray meets in (t_min, t_max), on any processor.
#[inline(always)]
pub fn portable(node: &CwBvhNode, ray: &NodeRay, t_max: f32) -> Children {
    let planes = Planes::new(node, ray);
    let q = planes.bytes.map(|b| b.to_le_bytes().map(f32::from));
    let Grid { step, low, high } = planes.grid;
    let mut children = Children {
        near: [0.0; 8],
        hits: 0,
    };
    for k in 0..8 {
        let x0 = q[0][k] * step.x + low.x;
        let y0 = q[1][k] * step.y + low.y;
        let z0 = q[2][k] * step.z + low.z;
        let x1 = q[3][k] * step.x + high.x;
        let y1 = q[4][k] * step.y + high.y;
        let z1 = q[5][k] * step.z + high.z;
        let near = x0.max(y0).max(z0.max(ray.t_min));
        let far = x1.min(y1).min(z1.min(t_max));
        children.near[k] = near;
        if near <= far {
            children.hits |= bits(node.child_meta[k]);
        }
    }
    children
}

#[cfg(target_arch = "x86_64")]
pub use sse2::four_lanes;

#[cfg(target_arch = "x86_64")]
mod sse2 {
    use super::{Children, CwBvhNode, Grid, NodeRay, Planes, bits};
    use std::arch::x86_64::*;

    /// [`super::portable`] with four lanes twice, on every x86-64 processor.
    #[inline(always)]
    pub fn four_lanes(node: &CwBvhNode, ray: &NodeRay, t_max: f32) -> Children {
        // SAFETY: SSE2 belongs to x86-64.
        unsafe { eight(node, ray, t_max) }
    }

    #[inline]
    #[target_feature(enable = "sse2")]
    fn eight(node: &CwBvhNode, ray: &NodeRay, t_max: f32) -> Children {
        let planes = Planes::new(node, ray);
        let zero = _mm_setzero_si128();
        let words = planes
            .bytes
            .map(|b| _mm_unpacklo_epi8(_mm_cvtsi64_si128(b as i64), zero));
        let first = words.map(|w| _mm_cvtepi32_ps(_mm_unpacklo_epi16(w, zero)));
        let last = words.map(|w| _mm_cvtepi32_ps(_mm_unpackhi_epi16(w, zero)));
        let (near0, hit0) = four(&planes, first, ray.t_min, t_max);
        let (near1, hit1) = four(&planes, last, ray.t_min, t_max);
        let mut children = Children {
            near: [0.0; 8],
            hits: 0,
        };
        // SAFETY: the array holds eight.
        unsafe {
            _mm_storeu_ps(children.near.as_mut_ptr(), near0);
            _mm_storeu_ps(children.near.as_mut_ptr().add(4), near1);
        }
        let mut hit = hit0 | hit1 << 4;
        while hit != 0 {
            children.hits |= bits(node.child_meta[hit.trailing_zeros() as usize & 7]);
            hit &= hit - 1;
        }
        children
    }

    #[inline]
    #[target_feature(enable = "sse2")]
    fn four(planes: &Planes, q: [__m128; 6], t_min: f32, t_max: f32) -> (__m128, u32) {
        let at = |q: __m128, step: f32, base: f32| {
            _mm_add_ps(_mm_mul_ps(q, _mm_set1_ps(step)), _mm_set1_ps(base))
        };
        let Grid { step, low, high } = planes.grid;
        let near = _mm_max_ps(
            _mm_max_ps(at(q[0], step.x, low.x), at(q[1], step.y, low.y)),
            _mm_max_ps(at(q[2], step.z, low.z), _mm_set1_ps(t_min)),
        );
        let far = _mm_min_ps(
            _mm_min_ps(at(q[3], step.x, high.x), at(q[4], step.y, high.y)),
            _mm_min_ps(at(q[5], step.z, high.z), _mm_set1_ps(t_max)),
        );
        (near, _mm_movemask_ps(_mm_cmple_ps(near, far)) as u32)
    }
}
