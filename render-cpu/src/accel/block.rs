//! A ray against eight triangles: [`halflight_kernel::scene::intersect::intersect_triangle`] with the same operations in the
//! same order, so that the hits are the same to the bit.
//!
//! Nearly all triangles go away by the signs of their edge functions. Where a block keeps any, the distances follow. On
//! processors without AVX2 the signs are left to the compiler's vectors and the rest to the kernel, one by one.

use super::node::Portable;
use super::packed::{BLOCK, TriangleBlock};
use glam::Vec3;
use halflight_kernel::scene::intersect::{ShearedRay, intersect_triangle};

/// What a block needs of a ray.
#[derive(Clone, Copy, Debug)]
pub struct BlockRay {
    /// The kernel's preparation.
    pub sheared: ShearedRay,
    /// Components that are x, y and z of the sheared space.
    rows: [usize; 3],
    /// The origin in that order.
    origin: [f32; 3],
    /// Where hits begin.
    pub t_min: f32,
}

impl BlockRay {
    /// Prepares a ray; its direction is not zero.
    #[inline(always)]
    pub fn new(origin: Vec3, direction: Vec3, t_min: f32) -> BlockRay {
        let sheared = ShearedRay::new(origin, direction);
        let axis = sheared.axis as usize;
        let rows = [(axis + 1) % 3, (axis + 2) % 3, axis];
        BlockRay {
            sheared,
            rows,
            origin: rows.map(|k| origin[k]),
            t_min,
        }
    }
}

/// A hit in a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockHit {
    /// Ray parameter.
    pub t: f32,
    /// Barycentric weight of the second vertex.
    pub b1: f32,
    /// Barycentric weight of the third vertex.
    pub b2: f32,
    /// Place in the block; [`BLOCK`] for a miss.
    pub place: usize,
}

impl BlockHit {
    /// No intersection.
    pub const MISS: BlockHit = BlockHit {
        t: f32::MAX,
        b1: 0.0,
        b2: 0.0,
        place: BLOCK,
    };
}

/// How the eight triangles are tested.
pub trait BlockTest {
    /// The nearest hit in (t_min, t_max) among the places whose bits are set in `places`.
    fn nearest(block: &TriangleBlock, ray: &BlockRay, places: u32, t_max: f32) -> BlockHit;
}

impl BlockTest for Portable {
    #[inline(always)]
    fn nearest(block: &TriangleBlock, ray: &BlockRay, places: u32, t_max: f32) -> BlockHit {
        let mut hit = BlockHit {
            t: t_max,
            ..BlockHit::MISS
        };
        let mut candidates = places & candidates(block, ray);
        while candidates != 0 {
            let place = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            let [p0, p1, p2] = block.vertices(place);
            let found = intersect_triangle(&ray.sheared, p0, p1, p2, ray.t_min, hit.t);
            if found.t < hit.t {
                hit = BlockHit {
                    t: found.t,
                    b1: found.b1,
                    b2: found.b2,
                    place,
                };
            }
        }
        hit
    }
}

/// The places, a bit each, where no two edge functions have opposite signs. Edges that are zero are left to the kernel.
#[inline(always)]
fn candidates(block: &TriangleBlock, ray: &BlockRay) -> u32 {
    let [rx, ry, rz] = ray.rows.map(|row| &block.axes[row]);
    let shear = ray.sheared.shear;
    let mut candidates = 0;
    for k in 0..BLOCK {
        let mut x = [0.0; 3];
        let mut y = [0.0; 3];
        for vertex in 0..3 {
            let z = rz[vertex][k] - ray.origin[2];
            x[vertex] = (rx[vertex][k] - ray.origin[0]) - shear.x * z;
            y[vertex] = (ry[vertex][k] - ray.origin[1]) - shear.y * z;
        }
        let u = x[2] * y[1] - y[2] * x[1];
        let v = x[0] * y[2] - y[0] * x[2];
        let w = x[1] * y[0] - y[1] * x[0];
        let below = (u < 0.0) | (v < 0.0) | (w < 0.0);
        let above = (u > 0.0) | (v > 0.0) | (w > 0.0);
        candidates |= (!(below & above) as u32) << k;
    }
    candidates
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::super::node::{Avx2, Portable, Sse2};
    use super::{BLOCK, BlockHit, BlockRay, BlockTest, TriangleBlock};
    use std::arch::x86_64::*;

    impl BlockTest for Sse2 {
        #[inline(always)]
        fn nearest(block: &TriangleBlock, ray: &BlockRay, places: u32, t_max: f32) -> BlockHit {
            Portable::nearest(block, ray, places, t_max)
        }
    }

    impl BlockTest for Avx2 {
        #[inline(always)]
        fn nearest(block: &TriangleBlock, ray: &BlockRay, places: u32, t_max: f32) -> BlockHit {
            // SAFETY: the traversal uses this type only where it has found both features.
            unsafe { eight(block, ray, places, t_max) }
        }
    }

    /// Eight floats; the operators are single instructions. Products are not fused with sums, because a fused edge
    /// function would lose watertightness.
    type Lanes = __m256;

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn splat(x: f32) -> Lanes {
        _mm256_set1_ps(x)
    }

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn load(row: &[f32; BLOCK]) -> Lanes {
        // SAFETY: a row is eight floats.
        unsafe { _mm256_loadu_ps(row.as_ptr()) }
    }

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn at(lanes: Lanes, place: usize) -> f32 {
        let mut floats = [0.0; BLOCK];
        // SAFETY: there is room for eight floats.
        unsafe { _mm256_storeu_ps(floats.as_mut_ptr(), lanes) };
        floats[place & (BLOCK - 1)]
    }

    /// p x q in the plane.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn cross(px: Lanes, py: Lanes, qx: Lanes, qy: Lanes) -> Lanes {
        _mm256_sub_ps(_mm256_mul_ps(px, qy), _mm256_mul_ps(py, qx))
    }

    /// a x + b y + c z, summed from the left.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn dot(p: [Lanes; 3], q: [Lanes; 3]) -> Lanes {
        let [x, y, z] = [0, 1, 2].map(|k| _mm256_mul_ps(p[k], q[k]));
        _mm256_add_ps(_mm256_add_ps(x, y), z)
    }

    /// The edge function p x q, where rounding has lost it from the difference of the vertices.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn nonzero_edge(edge: Lanes, px: Lanes, py: Lanes, qx: Lanes, qy: Lanes) -> Lanes {
        let difference = cross(
            _mm256_add_ps(px, qx),
            _mm256_add_ps(py, qy),
            _mm256_sub_ps(qx, px),
            _mm256_sub_ps(qy, py),
        );
        let is_zero = _mm256_cmp_ps::<_CMP_EQ_OQ>(edge, _mm256_setzero_ps());
        _mm256_blendv_ps(edge, _mm256_mul_ps(splat(0.5), difference), is_zero)
    }

    /// The places where no two edges have opposite signs. Minima and maxima take their second operand where one is a
    /// NaN; such triangles are missed either way.
    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn one_sided(u: Lanes, v: Lanes, w: Lanes) -> u32 {
        let zero = _mm256_setzero_ps();
        let least = _mm256_min_ps(u, _mm256_min_ps(v, w));
        let most = _mm256_max_ps(u, _mm256_max_ps(v, w));
        let below = _mm256_cmp_ps::<_CMP_LT_OQ>(least, zero);
        let above = _mm256_cmp_ps::<_CMP_GT_OQ>(most, zero);
        !(_mm256_movemask_ps(_mm256_and_ps(below, above)) as u32)
    }

    #[inline]
    #[target_feature(enable = "avx2,fma")]
    fn eight(block: &TriangleBlock, ray: &BlockRay, places: u32, t_max: f32) -> BlockHit {
        let [rx, ry, rz] = ray.rows.map(|row| &block.axes[row]);
        let [ox, oy, oz] = ray.origin.map(|o| splat(o));
        let shear = ray.sheared.shear;
        let (sx, sy) = (splat(shear.x), splat(shear.y));
        let vertex = |k: usize| {
            let z = _mm256_sub_ps(load(&rz[k]), oz);
            let x = _mm256_sub_ps(_mm256_sub_ps(load(&rx[k]), ox), _mm256_mul_ps(sx, z));
            let y = _mm256_sub_ps(_mm256_sub_ps(load(&ry[k]), oy), _mm256_mul_ps(sy, z));
            (x, y, z)
        };
        let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (vertex(0), vertex(1), vertex(2));
        let (mut u, mut v, mut w) = (
            cross(cx, cy, bx, by),
            cross(ax, ay, cx, cy),
            cross(bx, by, ax, ay),
        );
        let mut hits = places & one_sided(u, v, w);
        if hits == 0 {
            return BlockHit::MISS;
        }
        let is_zero = |edge| _mm256_cmp_ps::<_CMP_EQ_OQ>(edge, _mm256_setzero_ps());
        let zeros = _mm256_or_ps(is_zero(u), _mm256_or_ps(is_zero(v), is_zero(w)));
        if hits & _mm256_movemask_ps(zeros) as u32 != 0 {
            u = nonzero_edge(u, cx, cy, bx, by);
            v = nonzero_edge(v, ax, ay, cx, cy);
            w = nonzero_edge(w, bx, by, ax, ay);
            hits &= one_sided(u, v, w);
        }
        let determinant = _mm256_add_ps(_mm256_add_ps(u, v), w);
        let size = _mm256_andnot_ps(splat(-0.0), determinant);
        let is_solid = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GT_OQ>(size, _mm256_setzero_ps()),
            _mm256_cmp_ps::<_CMP_LT_OQ>(size, splat(f32::MAX)),
        );

        // Where the plane is met, clamped to the range of the vertices along the ray.
        let [p0, p1, p2] = [0, 1, 2].map(|k| [0, 1, 2].map(|axis| load(&block.axes[axis][k])));
        let e1 = [0, 1, 2].map(|k| _mm256_sub_ps(p1[k], p0[k]));
        let e2 = [0, 1, 2].map(|k| _mm256_sub_ps(p2[k], p0[k]));
        let n = [
            _mm256_sub_ps(_mm256_mul_ps(e1[1], e2[2]), _mm256_mul_ps(e2[1], e1[2])),
            _mm256_sub_ps(_mm256_mul_ps(e1[2], e2[0]), _mm256_mul_ps(e2[2], e1[0])),
            _mm256_sub_ps(_mm256_mul_ps(e1[0], e2[1]), _mm256_mul_ps(e2[0], e1[1])),
        ];
        let origin = ray.sheared.origin.to_array();
        let offset = [0, 1, 2].map(|k| _mm256_sub_ps(p0[k], splat(origin[k])));
        let direction = ray.sheared.direction.to_array().map(|d| splat(d));
        let plane = _mm256_div_ps(dot(n, offset), dot(n, direction));
        let scale = splat(shear.z);
        let [za, zb, zc] = [az, bz, cz].map(|z| _mm256_mul_ps(z, scale));
        let nearest = _mm256_min_ps(_mm256_min_ps(za, zb), zc);
        let farthest = _mm256_max_ps(_mm256_max_ps(za, zb), zc);
        // A NaN from 0/0 is replaced by the bounds as well.
        let t = _mm256_min_ps(_mm256_max_ps(plane, nearest), farthest);
        let in_range = _mm256_and_ps(
            _mm256_cmp_ps::<_CMP_GT_OQ>(t, splat(ray.t_min)),
            _mm256_cmp_ps::<_CMP_LT_OQ>(t, splat(t_max)),
        );
        hits &= _mm256_movemask_ps(_mm256_and_ps(is_solid, in_range)) as u32;
        if hits == 0 {
            return BlockHit::MISS;
        }
        let mut place = hits.trailing_zeros() as usize;
        hits &= hits - 1;
        while hits != 0 {
            let other = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            if at(t, other) < at(t, place) {
                place = other;
            }
        }
        let scale = 1.0 / at(determinant, place);
        BlockHit {
            t: at(t, place),
            b1: at(v, place) * scale,
            b2: at(w, place) * scale,
            place,
        }
    }
}
