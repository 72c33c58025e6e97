//! Sixteen rays against a sphere each: [`halflight_kernel::scene::intersect::intersect_quadric`] with the same operations in
//! the same order, so that the hits are the same to the bit.

use super::lanes16::*;
use super::sixteen::{Sixteen, keep};
use super::triangles16::{Hits, ShearedRays};
use halflight_kernel::scene::{Quadric, Tables, quadric_kind};
use std::arch::x86_64::*;
use std::mem::offset_of;

avx512! {
    /// Indices into the quadrics of primitives behind the triangles.
    fn indices(tables: &Tables<'_>, primitives: __m512i) -> __m512i {
        _mm512_sub_epi32(primitives, word(tables.triangles.len() as i32))
    }

    /// Which of the primitives of a mask, all behind the triangles, are spheres.
    pub fn are_spheres(tables: &Tables<'_>, primitives: __m512i, mask: u16) -> u16 {
        let quadrics = tables.quadrics;
        let index = indices(tables, primitives);
        let mask = _mm512_mask_cmplt_epu32_mask(mask, index, word(quadrics.len() as i32));
        let stride = (size_of::<Quadric>() / size_of::<u32>()) as i32;
        let at = _mm512_mullo_epi32(index, word(stride));
        let kinds = quadrics.as_ptr().cast::<u8>().wrapping_add(offset_of!(Quadric, kind));
        // SAFETY: the lanes of the mask read the kind of a quadric each.
        let kind = unsafe {
            _mm512_mask_i32gather_epi32::<4>(word(-1), mask, at, kinds.cast())
        };
        _mm512_mask_cmpeq_epi32_mask(mask, kind, word(quadric_kind::SPHERE as i32))
    }

    /// Rows of the maps from world to object of the quadrics of a mask, of which there is at least one.
    pub fn maps(tables: &Tables<'_>, primitives: __m512i, mask: u16) -> [[__m512; 4]; 3] {
        let mut at = Words::all(0);
        store_words(&mut at, _mm512_maskz_mov_epi32(mask, indices(tables, primitives)));
        macro_rules! row {
            ($row:literal) => {{
                let [x, y, z, w] = columns!(|lane| {
                    let quadric = &tables.quadrics[at.0[lane] as usize];
                    // SAFETY: a row is four floats.
                    unsafe { _mm_loadu_si128(quadric.to_object[4 * $row..].as_ptr().cast()) }
                });
                let float = |v: __m512i| _mm512_castsi512_ps(v);
                [float(x), float(y), float(z), float(w)]
            }};
        }
        [row!(0), row!(1), row!(2)]
    }

    /// The hits in (t_min, t_max), the two numbers of `range`, among the lanes of `mask`, by the rows of the maps from world to
    /// object.
    pub fn hits(
        origin: [__m512; 3],
        direction: [__m512; 3],
        to_object: [[__m512; 4]; 3],
        range: [__m512; 2],
        mask: u16,
    ) -> Hits {
        let zero = _mm512_setzero_ps();
        let one = splat(1.0);
        let row = |k: usize, v: [__m512; 3]| {
            let [x, y, z, _] = to_object[k];
            dot([x, y, z], v)
        };
        let point = |k: usize| _mm512_add_ps(row(k, origin), to_object[k][3]);
        let o = [point(0), point(1), point(2)];
        let d = [row(0, direction), row(1, direction), row(2, direction)];
        let a = dot(d, d);
        let b = _mm512_xor_ps(dot(o, d), splat(-0.0));
        let along = _mm512_div_ps(b, a);
        let at = |k: usize| _mm512_add_ps(o[k], _mm512_mul_ps(d[k], along));
        let closest = [at(0), at(1), at(2)];
        let c = _mm512_sub_ps(dot(o, o), one);
        let discriminant = _mm512_sub_ps(one, dot(closest, closest));
        let mut hit = _mm512_mask_cmp_ps_mask::<_CMP_GE_OQ>(mask, discriminant, zero);
        hit = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(hit, a, zero);
        let square = _mm512_mul_ps(a, discriminant);
        let is_positive = _mm512_cmp_ps_mask::<_CMP_GT_OQ>(square, zero);
        let s = _mm512_sqrt_ps(_mm512_maskz_mov_ps(is_positive, square));
        let is_negative = _mm512_cmp_ps_mask::<_CMP_LT_OQ>(b, zero);
        let q = _mm512_mask_sub_ps(_mm512_add_ps(b, s), is_negative, b, s);
        let is_not_zero = _mm512_cmp_ps_mask::<_CMP_NEQ_UQ>(q, zero);
        let t0 = _mm512_maskz_div_ps(is_not_zero, c, q);
        let t1 = _mm512_div_ps(q, a);
        // The other where one is not a number.
        let is_lost = _mm512_cmp_ps_mask::<_CMP_UNORD_Q>(t1, t1);
        let t1 = _mm512_mask_mov_ps(t1, is_lost, t0);
        let (near, far) = (_mm512_min_ps(t0, t1), _mm512_max_ps(t0, t1));
        let is_inside = |t: __m512, mask: u16| {
            let above = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(mask, t, range[0]);
            _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(above, t, range[1])
        };
        let is_near = is_inside(near, hit);
        let is_far = is_inside(far, hit);
        Hits {
            mask: is_near | is_far,
            t: _mm512_mask_mov_ps(far, is_near, near),
            b1: zero,
            b2: zero,
        }
    }

    /// Tests the spheres of a mask among the primitives that wait for `rays`, those of the lanes `owners`; the rays' lanes that
    /// have met one.
    pub fn test_spheres(
        sixteen: &mut Sixteen,
        tables: &Tables<'_>,
        rays: &ShearedRays,
        owners: __m512i,
        primitives: __m512i,
        spheres: u16,
    ) -> u16 {
        if spheres == 0 {
            return 0;
        }
        let to_object = maps(tables, primitives, spheres);
        let range = [rays.t_min, rays.t_max];
        let found = hits(rays.origin, rays.direction, to_object, range, spheres);
        keep(sixteen, owners, &found, primitives)
    }
}
