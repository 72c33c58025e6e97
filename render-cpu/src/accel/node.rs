//! A ray against the eight children of a compressed node.
//!
//! Child k's box has its corners on the node's grid: plane q of axis a lies at p_a + q e_a, and the ray meets it at
//! t = (p_a - o_a) / d_a + q e_a / d_a. Both terms round relative to their own size, so that the near planes are moved back
//! and the far ones forth by that much: a box is never missed, and no ray slips between boxes that touch.
//!
//! The same test is written for eight lanes (AVX2), for four (SSE2, every x86-64) and portably. They may differ in the
//! last bit of a distance, never in whether a primitive's box is found.

use glam::{Vec3, Vec3A};
use obvhs::cwbvh::node::CwBvhNode;

/// What nodes need of a ray.
#[derive(Clone, Copy, Debug)]
pub struct NodeRay {
    origin: Vec3A,
    /// 1 / direction, finite, so that no plane distance is zero times infinity.
    inverse: Vec3A,
    is_negative: [bool; 3],
    t_min: f32,
}

impl NodeRay {
    /// Prepares a ray.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3, t_min: f32) -> NodeRay {
        let inverse = direction.map(|x| {
            if x.abs() > 1e-18 {
                1.0 / x
            } else {
                1e18f32.copysign(x)
            }
        });
        let is_negative = [direction.x < 0.0, direction.y < 0.0, direction.z < 0.0];
        NodeRay {
            origin: origin.into(),
            inverse: inverse.into(),
            is_negative,
            t_min,
        }
    }
}

/// Plane distances of a node: t = q step + low for near planes and q step + high for far ones.
struct Planes {
    step: Vec3A,
    low: Vec3A,
    high: Vec3A,
    /// Near planes of x, y, z, then far ones: a byte per child.
    bytes: [u64; 6],
}

impl Planes {
    #[inline(always)]
    fn new(node: &CwBvhNode, ray: &NodeRay) -> Planes {
        let step = node.compute_extent() * ray.inverse;
        let base = (Vec3A::from(node.p) - ray.origin) * ray.inverse;
        // Four roundings of each term, doubled.
        let error = (base.abs() + step.abs() * 255.0) * 5e-7;
        let order = |negative: bool, min: [u8; 8], max: [u8; 8]| {
            let (min, max) = (u64::from_le_bytes(min), u64::from_le_bytes(max));
            if negative { (max, min) } else { (min, max) }
        };
        let [nx, ny, nz] = ray.is_negative;
        let (x0, x1) = order(nx, node.child_min_x, node.child_max_x);
        let (y0, y1) = order(ny, node.child_min_y, node.child_max_y);
        let (z0, z1) = order(nz, node.child_min_z, node.child_max_z);
        Planes {
            step,
            low: base - error,
            high: base + error,
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
    /// A bit per child whose box the ray meets in (t_min, t_max).
    pub hit: u32,
}

/// How the eight boxes are tested.
pub trait NodeTest {
    /// The children that the ray meets in (t_min, t_max).
    fn children(node: &CwBvhNode, ray: &NodeRay, t_max: f32) -> Children;
}

/// Any processor.
#[derive(Clone, Copy, Debug)]
pub struct Portable;

impl NodeTest for Portable {
    #[inline(always)]
    fn children(node: &CwBvhNode, ray: &NodeRay, t_max: f32) -> Children {
        let planes = Planes::new(node, ray);
        let q = planes.bytes.map(|b| b.to_le_bytes().map(f32::from));
        let (step, low, high) = (planes.step, planes.low, planes.high);
        let mut children = Children {
            near: [0.0; 8],
            hit: 0,
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
            children.hit |= ((near <= far) as u32) << k;
        }
        children
    }
}

#[cfg(target_arch = "x86_64")]
pub use x86::{Avx2, Sse2};

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Children, CwBvhNode, NodeRay, NodeTest, Planes};
    use std::arch::x86_64::*;

    /// Four lanes twice, on every x86-64 processor.
    #[derive(Clone, Copy, Debug)]
    pub struct Sse2;

    impl NodeTest for Sse2 {
        #[inline(always)]
        fn children(node: &CwBvhNode, ray: &NodeRay, t_max: f32) -> Children {
            // SAFETY: SSE2 belongs to x86-64.
            unsafe { twice_four(node, ray, t_max) }
        }
    }

    #[inline]
    #[target_feature(enable = "sse2")]
    fn twice_four(node: &CwBvhNode, ray: &NodeRay, t_max: f32) -> Children {
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
            hit: hit0 | hit1 << 4,
        };
        // SAFETY: the array has room for eight.
        unsafe {
            _mm_storeu_ps(children.near.as_mut_ptr(), near0);
            _mm_storeu_ps(children.near.as_mut_ptr().add(4), near1);
        }
        children
    }

    #[inline]
    #[target_feature(enable = "sse2")]
    fn four(planes: &Planes, q: [__m128; 6], t_min: f32, t_max: f32) -> (__m128, u32) {
        let at = |q: __m128, step: f32, base: f32| {
            _mm_add_ps(_mm_mul_ps(q, _mm_set1_ps(step)), _mm_set1_ps(base))
        };
        let (step, low, high) = (planes.step, planes.low, planes.high);
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

    /// Eight lanes at once; only on processors with AVX2 and FMA.
    #[derive(Clone, Copy, Debug)]
    pub struct Avx2;

    impl NodeTest for Avx2 {
        #[inline(always)]
        fn children(node: &CwBvhNode, ray: &NodeRay, t_max: f32) -> Children {
            // SAFETY: the traversal uses this type only where it has found both features.
            unsafe { eight(node, ray, t_max) }
        }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn eight(node: &CwBvhNode, ray: &NodeRay, t_max: f32) -> Children {
        let planes = Planes::new(node, ray);
        let q = planes
            .bytes
            .map(|b| _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_cvtsi64_si128(b as i64))));
        let at = |q: __m256, step: f32, base: f32| {
            _mm256_fmadd_ps(q, _mm256_set1_ps(step), _mm256_set1_ps(base))
        };
        let (step, low, high) = (planes.step, planes.low, planes.high);
        let near = _mm256_max_ps(
            _mm256_max_ps(at(q[0], step.x, low.x), at(q[1], step.y, low.y)),
            _mm256_max_ps(at(q[2], step.z, low.z), _mm256_set1_ps(ray.t_min)),
        );
        let far = _mm256_min_ps(
            _mm256_min_ps(at(q[3], step.x, high.x), at(q[4], step.y, high.y)),
            _mm256_min_ps(at(q[5], step.z, high.z), _mm256_set1_ps(t_max)),
        );
        let mut children = Children {
            near: [0.0; 8],
            hit: _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(near, far)) as u32,
        };
        // SAFETY: the array has room for eight.
        unsafe { _mm256_storeu_ps(children.near.as_mut_ptr(), near) };
        children
    }
}
