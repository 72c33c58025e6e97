//! Sixteen numbers at a time (AVX-512).
//!
//! Functions here and in the walks that use them carry the features of [`SimdLevel::avx512`], which is how the walks are
//! entered: their callers have looked for them.
//!
//! [`SimdLevel::avx512`]: halflight_kernel::simd::SimdLevel::avx512

use std::arch::x86_64::*;

/// Numbers in a vector.
pub const LANES: usize = 16;

/// Defines functions with the features of the processors that have sixteen lanes.
macro_rules! avx512 {
    ($($(#[$attribute:meta])* $visibility:vis fn $name:ident $(<$(const $constant:ident: $kind:ty),*>)? ($($arguments:tt)*) $(-> $result:ty)? $body:block)*) => {$(
        $(#[$attribute])*
        #[inline]
        #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,popcnt,bmi1,bmi2,lzcnt")]
        $visibility fn $name $(<$(const $constant: $kind),*>)? ($($arguments)*) $(-> $result)? $body
    )*};
}
pub(crate) use avx512;

/// Sixteen floats in memory.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Floats(pub [f32; LANES]);

/// Sixteen integers in memory.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Words(pub [u32; LANES]);

impl Floats {
    /// The same in all lanes.
    pub const fn all(x: f32) -> Floats {
        Floats([x; LANES])
    }
}

impl Words {
    /// The same in all lanes.
    pub const fn all(x: u32) -> Words {
        Words([x; LANES])
    }
}

avx512! {
    /// From memory.
    pub fn load(row: &Floats) -> __m512 {
        // SAFETY: sixteen aligned floats.
        unsafe { _mm512_load_ps(row.0.as_ptr()) }
    }

    /// To memory.
    pub fn store(row: &mut Floats, v: __m512) {
        // SAFETY: sixteen aligned floats.
        unsafe { _mm512_store_ps(row.0.as_mut_ptr(), v) }
    }

    /// To memory in the lanes of a mask.
    pub fn store_some(row: &mut Floats, mask: u16, v: __m512) {
        // SAFETY: sixteen aligned floats.
        unsafe { _mm512_mask_store_ps(row.0.as_mut_ptr(), mask, v) }
    }

    /// From memory.
    pub fn load_words(row: &Words) -> __m512i {
        // SAFETY: sixteen aligned words.
        unsafe { _mm512_load_si512(row.0.as_ptr().cast()) }
    }

    /// To memory.
    pub fn store_words(row: &mut Words, v: __m512i) {
        // SAFETY: sixteen aligned words.
        unsafe { _mm512_store_si512(row.0.as_mut_ptr().cast(), v) }
    }

    /// To memory in the lanes of a mask.
    pub fn store_some_words(row: &mut Words, mask: u16, v: __m512i) {
        // SAFETY: sixteen aligned words.
        unsafe { _mm512_mask_store_epi32(row.0.as_mut_ptr().cast(), mask, v) }
    }

    /// The same number in all lanes.
    pub fn splat(x: f32) -> __m512 {
        _mm512_set1_ps(x)
    }

    /// The same integer in all lanes.
    pub fn word(x: i32) -> __m512i {
        _mm512_set1_epi32(x)
    }

    /// The number of each lane.
    pub fn lane_numbers() -> __m512i {
        _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
    }

    /// Differences by components.
    pub fn minus(a: [__m512; 3], b: [__m512; 3]) -> [__m512; 3] {
        [
            _mm512_sub_ps(a[0], b[0]),
            _mm512_sub_ps(a[1], b[1]),
            _mm512_sub_ps(a[2], b[2]),
        ]
    }

    /// x + y + z of the products, from the left.
    pub fn dot(a: [__m512; 3], b: [__m512; 3]) -> __m512 {
        _mm512_add_ps(
            _mm512_add_ps(_mm512_mul_ps(a[0], b[0]), _mm512_mul_ps(a[1], b[1])),
            _mm512_mul_ps(a[2], b[2]),
        )
    }

    /// p x q in the plane.
    pub fn cross2(px: __m512, py: __m512, qx: __m512, qy: __m512) -> __m512 {
        _mm512_sub_ps(_mm512_mul_ps(px, qy), _mm512_mul_ps(py, qx))
    }

    /// Components in the cyclic order that puts each lane's axis last: x where `is_x`, y where `is_y`, z elsewhere.
    pub fn permute(v: [__m512; 3], is_x: u16, is_y: u16) -> [__m512; 3] {
        [
            _mm512_mask_mov_ps(_mm512_mask_mov_ps(v[0], is_y, v[2]), is_x, v[1]),
            _mm512_mask_mov_ps(_mm512_mask_mov_ps(v[1], is_y, v[0]), is_x, v[2]),
            _mm512_mask_mov_ps(_mm512_mask_mov_ps(v[2], is_y, v[1]), is_x, v[0]),
        ]
    }

    /// The columns of sixteen rows of four words each, of which a, b, c and d hold every fourth, from their first on.
    pub fn transposed([a, b, c, d]: [__m512i; 4]) -> [__m512i; 4] {
        let t0 = _mm512_unpacklo_epi32(a, b);
        let t1 = _mm512_unpackhi_epi32(a, b);
        let t2 = _mm512_unpacklo_epi32(c, d);
        let t3 = _mm512_unpackhi_epi32(c, d);
        [
            _mm512_unpacklo_epi64(t0, t2),
            _mm512_unpackhi_epi64(t0, t2),
            _mm512_unpacklo_epi64(t1, t3),
            _mm512_unpackhi_epi64(t1, t3),
        ]
    }
}

/// Columns of sixteen rows of four words each, a row per lane.
///
/// Loads of rows and shuffles take a third of the time of gathering single words, and less where rows are not in the first
/// cache. A macro, because a closure would not always be inlined.
macro_rules! columns {
    (|$lane:ident| $row:expr) => {
        transposed([
            columns!(@ $lane, $row, 0),
            columns!(@ $lane, $row, 1),
            columns!(@ $lane, $row, 2),
            columns!(@ $lane, $row, 3),
        ])
    };
    (@ $lane:ident, $row:expr, $first:literal) => {{
        let v = _mm512_castsi128_si512({ let $lane: usize = $first; $row });
        let v = _mm512_inserti32x4::<1>(v, { let $lane: usize = $first + 4; $row });
        let v = _mm512_inserti32x4::<2>(v, { let $lane: usize = $first + 8; $row });
        _mm512_inserti32x4::<3>(v, { let $lane: usize = $first + 12; $row })
    }};
}
pub(crate) use columns;
