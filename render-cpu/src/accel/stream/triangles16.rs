//! Sixteen rays against the one or two triangles of a place each ([`crate::accel::build::packed`]):
//! [`halflight_kernel::scene::intersect::intersect_triangle`] with the same operations in the same order, so that the hits are
//! the same to the bit.
//!
//! The edge functions of both triangles are found from the four vertices, those of the common edge from the same products.
//! All that follows is for one of them, the one that the ray passes through. Where it passes through both, which lie
//! at an angle then or meet at the ray, the other follows by itself.

use super::lanes16::{avx512, cross2, dot, minus, permute, splat, word};
use halflight_kernel::scene::NONE;
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

/// What rays pass through.
#[derive(Clone, Copy)]
struct Passing {
    /// Lanes that pass through the first triangle.
    first: u16,
    /// Lanes that pass through the second one.
    second: u16,
    /// Their edge functions.
    edges: [[__m512; 3]; 2],
    /// The vertices' distances back along the longest axis.
    depths: [__m512; 4],
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

impl Hits {
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn none() -> Hits {
        let zero = _mm512_setzero_ps();
        Hits {
            mask: 0,
            t: zero,
            b1: zero,
            b2: zero,
        }
    }
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

    /// The hits in (t_min, t_max) of the lanes of `mask` with the nearer of the triangles with these vertices, of two at the
    /// same distance the one with the lower primitive; and the primitives. `partners` are those of the second triangles or
    /// [`NONE`], `turns` what the third rows of the places hold. `SAME` says that the lanes have the same place, and makes a
    /// function for each of the two callers, which a compiler puts in their places.
    pub fn nearest<const SAME: bool>(
        rays: &ShearedRays,
        vertices: &[[__m512; 3]; 4],
        primitives: __m512i,
        partners: __m512i,
        turns: __m512i,
        mask: u16,
    ) -> (Hits, __m512i) {
        let pairs = _mm512_mask_cmpneq_epi32_mask(mask, partners, word(NONE as i32));
        let passing = pass(rays, vertices, mask, pairs);
        let either = passing.first | passing.second;
        let both = passing.first & passing.second;
        if either == 0 {
            return (Hits::none(), primitives);
        }
        let seconds = passing.second & !both;
        let mut found = hits(rays, vertices, &passing, turns, seconds, either);
        let mut names = _mm512_mask_mov_epi32(primitives, seconds, partners);
        if both != 0 {
            let other = hits(rays, vertices, &passing, turns, both, both);
            let is_nearer = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(other.t, found.t)
                | (_mm512_cmp_ps_mask::<_CMP_EQ_OQ>(other.t, found.t)
                    & _mm512_cmplt_epu32_mask(partners, names));
            let is_first = other.mask & (is_nearer | !found.mask);
            found.mask |= other.mask;
            found.t = _mm512_mask_mov_ps(found.t, is_first, other.t);
            found.b1 = _mm512_mask_mov_ps(found.b1, is_first, other.b1);
            found.b2 = _mm512_mask_mov_ps(found.b2, is_first, other.b2);
            names = _mm512_mask_mov_epi32(names, is_first, partners);
        }
        (found, names)
    }

    /// The lanes of `mask`, of which those of `pairs` have two triangles, whose rays pass through the first and through the
    /// second triangle with these vertices.
    fn pass(rays: &ShearedRays, vertices: &[[__m512; 3]; 4], mask: u16, pairs: u16) -> Passing {
        // Relative to the origin with signs turned, which changes no edge function.
        let vertex = |p: [__m512; 3]| {
            let [x, y, z] = permute(minus(rays.origin, p), rays.is_x, rays.is_y);
            (
                _mm512_sub_ps(x, _mm512_mul_ps(rays.shear[0], z)),
                _mm512_sub_ps(y, _mm512_mul_ps(rays.shear[1], z)),
                z,
            )
        };
        let (ax, ay, az) = vertex(vertices[0]);
        let (bx, by, bz) = vertex(vertices[1]);
        let (cx, cy, cz) = vertex(vertices[2]);
        let (dx, dy, dz) = vertex(vertices[3]);
        let (p, q) = (_mm512_mul_ps(ax, cy), _mm512_mul_ps(ay, cx));
        let mut first = [cross2(cx, cy, bx, by), _mm512_sub_ps(p, q), cross2(bx, by, ax, ay)];
        let mut second = [cross2(dx, dy, cx, cy), cross2(ax, ay, dx, dy), _mm512_sub_ps(q, p)];
        let (mut through_first, zero_first) = one_sided(first, mask);
        let (mut through_second, zero_second) = one_sided(second, pairs);
        if zero_first | zero_second != 0 {
            first[0] = nonzero_edge(first[0], cx, cy, bx, by);
            first[1] = nonzero_edge(first[1], ax, ay, cx, cy);
            first[2] = nonzero_edge(first[2], bx, by, ax, ay);
            second[0] = nonzero_edge(second[0], dx, dy, cx, cy);
            second[1] = nonzero_edge(second[1], ax, ay, dx, dy);
            second[2] = nonzero_edge(second[2], cx, cy, ax, ay);
            through_first |= not_two_sided(first, zero_first);
            through_second |= not_two_sided(second, zero_second);
        }
        Passing {
            first: through_first,
            second: through_second,
            edges: [first, second],
            depths: [az, bz, cz, dz],
        }
    }

    /// The hits in (t_min, t_max) of the lanes of `mask` with the second triangles where `seconds` is set, the first elsewhere;
    /// `turns` are those of the third rows of the places.
    fn hits(
        rays: &ShearedRays,
        vertices: &[[__m512; 3]; 4],
        passing: &Passing,
        turns: __m512i,
        seconds: u16,
        mask: u16,
    ) -> Hits {
        let choose = |a: __m512, b: __m512| _mm512_mask_mov_ps(a, seconds, b);
        let choose_point = |a: [__m512; 3], b: [__m512; 3]| {
            [choose(a[0], b[0]), choose(a[1], b[1]), choose(a[2], b[2])]
        };
        let [first, second] = passing.edges;
        let [mut u, mut v, mut w] = choose_point(first, second);
        let [a, b, c, d] = *vertices;
        let (mut p0, mut p1, mut p2) = (a, choose_point(b, c), choose_point(c, d));
        let turns = _mm512_mask_srli_epi32::<2>(turns, seconds, turns);
        let once = _mm512_mask_test_epi32_mask(mask, turns, word(1));
        let twice = _mm512_mask_test_epi32_mask(mask, turns, word(2));
        if once | twice != 0 {
            let turn = |a: &mut __m512, b: &mut __m512, c: &mut __m512| {
                let (x, y, z) = (*a, *b, *c);
                *a = _mm512_mask_mov_ps(_mm512_mask_mov_ps(x, once, z), twice, y);
                *b = _mm512_mask_mov_ps(_mm512_mask_mov_ps(y, once, x), twice, z);
                *c = _mm512_mask_mov_ps(_mm512_mask_mov_ps(z, once, y), twice, x);
            };
            turn(&mut u, &mut v, &mut w);
            turn(&mut p0[0], &mut p1[0], &mut p2[0]);
            turn(&mut p0[1], &mut p1[1], &mut p2[1]);
            turn(&mut p0[2], &mut p1[2], &mut p2[2]);
        }
        let zero = _mm512_setzero_ps();
        let determinant = _mm512_add_ps(_mm512_add_ps(u, v), w);
        let size = _mm512_abs_ps(determinant);
        let mut hit = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(mask, size, zero);
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
        let [za, zb, zc, zd] = passing.depths;
        let (za, zb, zc) = (
            _mm512_mul_ps(za, scale),
            _mm512_mul_ps(choose(zb, zc), scale),
            _mm512_mul_ps(choose(zc, zd), scale),
        );
        // A NaN from 0/0 is replaced by the bounds as well.
        let t = _mm512_min_ps(
            _mm512_max_ps(plane, _mm512_min_ps(_mm512_min_ps(za, zb), zc)),
            _mm512_max_ps(_mm512_max_ps(za, zb), zc),
        );
        hit = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(hit, t, rays.t_min);
        let scale = _mm512_div_ps(splat(1.0), determinant);
        Hits {
            mask: _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(hit, t, rays.t_max),
            t,
            b1: _mm512_mul_ps(v, scale),
            b2: _mm512_mul_ps(w, scale),
        }
    }

    /// The lanes of a mask where all edges have the same sign, and those where one may be zero and no two have opposite signs.
    fn one_sided([u, v, w]: [__m512; 3], mask: u16) -> (u16, u16) {
        let least = _mm512_min_ps(u, _mm512_min_ps(v, w));
        let greatest = _mm512_max_ps(u, _mm512_max_ps(v, w));
        // Zero also where it is too small for a number. Where it is not a number, the determinant is not finite.
        let product = _mm512_mul_ps(least, greatest);
        let zero = _mm512_setzero_ps();
        (
            _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(mask, product, zero),
            _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(mask, product, zero),
        )
    }

    /// The lanes of a mask where no two edges have opposite signs.
    fn not_two_sided([u, v, w]: [__m512; 3], mask: u16) -> u16 {
        let zero = _mm512_setzero_ps();
        let least = _mm512_min_ps(u, _mm512_min_ps(v, w));
        let greatest = _mm512_max_ps(u, _mm512_max_ps(v, w));
        let below = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(mask, least, zero);
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
