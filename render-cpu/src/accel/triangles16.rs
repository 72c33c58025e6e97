//! Sixteen rays against a triangle each: [`halflight_kernel::scene::intersect::intersect_triangle`] with the same operations
//! in the same order, so that the hits are the same to the bit.

use super::lanes16::{avx512, cross2, dot, minus, permute, splat};
use std::arch::x86_64::*;

/// What triangles need of rays.
#[derive(Clone, Copy)]
pub struct ShearedRays {
    /// Starts.
    pub origin: [__m512; 3],
    /// Directions.
    pub direction: [__m512; 3],
    /// Shear of x and y, scale of z.
    pub shear: [__m512; 3],
    /// Lanes whose direction is longest along x.
    pub is_x: u16,
    /// Lanes whose direction is longest along y.
    pub is_y: u16,
    /// Where hits begin.
    pub t_min: __m512,
    /// Where they end.
    pub t_max: __m512,
}

/// Hits of some lanes.
#[derive(Clone, Copy)]
pub struct Hits {
    /// The lanes.
    pub mask: u16,
    /// Ray parameters.
    pub t: __m512,
    /// Barycentric weights of the second vertices.
    pub b1: __m512,
    /// Barycentric weights of the third vertices.
    pub b2: __m512,
}

avx512! {
    /// The lanes in which a direction is longest along x, and those in which it is along y.
    pub fn longest_axes(direction: [__m512; 3]) -> (u16, u16) {
        let a = [
            _mm512_abs_ps(direction[0]),
            _mm512_abs_ps(direction[1]),
            _mm512_abs_ps(direction[2]),
        ];
        let is_x = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(a[0], a[1])
            & _mm512_cmp_ps_mask::<_CMP_GE_OQ>(a[0], a[2]);
        let is_y = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(a[1], a[2]) & !is_x;
        (is_x, is_y)
    }

    /// Shear of x and y per unit of z and the scale 1 / d_z of z, in the order of each lane's longest axis.
    pub fn shears(direction: [__m512; 3], is_x: u16, is_y: u16) -> [__m512; 3] {
        let [x, y, z] = permute(direction, is_x, is_y);
        [
            _mm512_div_ps(x, z),
            _mm512_div_ps(y, z),
            _mm512_div_ps(splat(1.0), z),
        ]
    }

    /// The hits in (t_min, t_max) among the lanes of `mask`.
    pub fn hits(
        rays: &ShearedRays,
        [p0, p1, p2]: [[__m512; 3]; 3],
        mask: u16,
    ) -> Hits {
        let zero = _mm512_setzero_ps();
        // Relative to the origin with signs turned, which changes no edge function.
        let vertex = |p: [__m512; 3]| {
            let [x, y, z] = permute(minus(rays.origin, p), rays.is_x, rays.is_y);
            (
                _mm512_sub_ps(x, _mm512_mul_ps(rays.shear[0], z)),
                _mm512_sub_ps(y, _mm512_mul_ps(rays.shear[1], z)),
                z,
            )
        };
        let (ax, ay, az) = vertex(p0);
        let (bx, by, bz) = vertex(p1);
        let (cx, cy, cz) = vertex(p2);
        let mut u = cross2(cx, cy, bx, by);
        let mut v = cross2(ax, ay, cx, cy);
        let mut w = cross2(bx, by, ax, ay);
        let mut hit = one_sided(u, v, w, mask);
        let mut hits = Hits { mask: 0, t: zero, b1: zero, b2: zero };
        if hit == 0 {
            return hits;
        }
        let zeros = _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(hit, u, zero)
            | _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(hit, v, zero)
            | _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(hit, w, zero);
        if zeros != 0 {
            u = nonzero_edge(u, cx, cy, bx, by);
            v = nonzero_edge(v, ax, ay, cx, cy);
            w = nonzero_edge(w, bx, by, ax, ay);
            hit = one_sided(u, v, w, hit);
        }
        let determinant = _mm512_add_ps(_mm512_add_ps(u, v), w);
        let size = _mm512_abs_ps(determinant);
        hit = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(hit, size, zero);
        hit = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(hit, size, splat(f32::MAX));

        // Where the plane is met, clamped to the range of the vertices along the ray.
        let (e1, e2) = (minus(p1, p0), minus(p2, p0));
        let n = [
            _mm512_sub_ps(_mm512_mul_ps(e1[1], e2[2]), _mm512_mul_ps(e2[1], e1[2])),
            _mm512_sub_ps(_mm512_mul_ps(e1[2], e2[0]), _mm512_mul_ps(e2[2], e1[0])),
            _mm512_sub_ps(_mm512_mul_ps(e1[0], e2[1]), _mm512_mul_ps(e2[0], e1[1])),
        ];
        let plane = _mm512_div_ps(dot(n, minus(p0, rays.origin)), dot(n, rays.direction));
        let scale = _mm512_xor_ps(rays.shear[2], splat(-0.0));
        let (za, zb, zc) = (
            _mm512_mul_ps(az, scale),
            _mm512_mul_ps(bz, scale),
            _mm512_mul_ps(cz, scale),
        );
        // A NaN from 0/0 is replaced by the bounds as well.
        let t = _mm512_min_ps(
            _mm512_max_ps(plane, _mm512_min_ps(_mm512_min_ps(za, zb), zc)),
            _mm512_max_ps(_mm512_max_ps(za, zb), zc),
        );
        hit = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(hit, t, rays.t_min);
        hits.mask = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(hit, t, rays.t_max);
        let scale = _mm512_div_ps(splat(1.0), determinant);
        hits.t = t;
        hits.b1 = _mm512_mul_ps(v, scale);
        hits.b2 = _mm512_mul_ps(w, scale);
        hits
    }

    /// The lanes where no two edges have opposite signs. A NaN may hide one of them; such triangles are missed either way.
    fn one_sided(u: __m512, v: __m512, w: __m512, mask: u16) -> u16 {
        let zero = _mm512_setzero_ps();
        let least = _mm512_min_ps(u, _mm512_min_ps(v, w));
        let greatest = _mm512_max_ps(u, _mm512_max_ps(v, w));
        let below = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(least, zero);
        mask & !_mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(below, greatest, zero)
    }

    /// The edge function p x q, where rounding has lost it from the difference of the vertices.
    fn nonzero_edge(edge: __m512, px: __m512, py: __m512, qx: __m512, qy: __m512) -> __m512 {
        let difference = _mm512_sub_ps(
            _mm512_mul_ps(_mm512_add_ps(px, qx), _mm512_sub_ps(qy, py)),
            _mm512_mul_ps(_mm512_add_ps(py, qy), _mm512_sub_ps(qx, px)),
        );
        let is_zero = _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(edge, _mm512_setzero_ps());
        _mm512_mask_mul_ps(edge, is_zero, splat(0.5), difference)
    }
}
