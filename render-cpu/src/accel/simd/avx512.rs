//! Sixteen lanes, for processors with AVX-512.
//!
//! Values are only made in functions with the features of [`SimdLevel::avx512`] (`with_avx512!`), which are entered where
//! the processor has been asked for them: that is the reason behind every `unsafe` in this file without another one.
//!
//! [`SimdLevel::avx512`]: halflight_kernel::simd::SimdLevel::avx512

use super::{SimdFloat, SimdMask, SimdWord};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Sub};

/// Numbers in a vector.
pub const LANES: usize = 16;

/// Defines functions with the features of the processors that have sixteen lanes.
macro_rules! with_avx512 {
    ($($(#[$attribute:meta])* $visibility:vis fn $name:ident $(<$(const $constant:ident: $kind:ty),*>)? ($($arguments:tt)*) $(-> $result:ty)? $body:block)*) => {$(
        $(#[$attribute])*
        #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq,avx512cd,avx2,fma,popcnt,bmi1,bmi2,lzcnt")]
        $visibility fn $name $(<$(const $constant: $kind),*>)? ($($arguments)*) $(-> $result)? $body
    )*};
}
pub(in crate::accel) use with_avx512;

/// Sixteen floats.
#[derive(Clone, Copy, Debug)]
pub struct F16(pub __m512);

/// Sixteen integers without a sign.
#[derive(Clone, Copy, Debug)]
pub struct W16(pub __m512i);

/// Sixteen floats in memory.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct FloatRow(pub [f32; LANES]);

/// Sixteen integers in memory.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct WordRow(pub [u32; LANES]);

impl FloatRow {
    /// The same in all lanes.
    pub const fn all(x: f32) -> FloatRow {
        FloatRow([x; LANES])
    }
}

impl WordRow {
    /// The same in all lanes.
    pub const fn all(x: u32) -> WordRow {
        WordRow([x; LANES])
    }
}

operator!(F16, Add, add, _mm512_add_ps);
operator!(F16, Sub, sub, _mm512_sub_ps);
operator!(F16, Mul, mul, _mm512_mul_ps);
operator!(F16, Div, div, _mm512_div_ps);
operator!(W16, Add, add, _mm512_add_epi32);
operator!(W16, Sub, sub, _mm512_sub_epi32);
operator!(W16, BitAnd, bitand, _mm512_and_si512);
operator!(W16, BitOr, bitor, _mm512_or_si512);
operator!(W16, BitXor, bitxor, _mm512_xor_si512);

impl Neg for F16 {
    type Output = F16;
    #[inline(always)]
    fn neg(self) -> F16 {
        // SAFETY: see the module.
        F16(unsafe { _mm512_xor_ps(self.0, _mm512_set1_ps(-0.0)) })
    }
}

impl SimdMask for u16 {
    #[inline(always)]
    fn all() -> u16 {
        u16::MAX
    }
    #[inline(always)]
    fn any(self) -> bool {
        self != 0
    }
}

impl SimdFloat for F16 {
    type Mask = u16;
    type Word = W16;

    #[inline(always)]
    fn splat(x: f32) -> F16 {
        // SAFETY: see the module.
        F16(unsafe { _mm512_set1_ps(x) })
    }
    #[inline(always)]
    fn min(self, other: F16) -> F16 {
        // SAFETY: see the module.
        F16(unsafe { _mm512_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: F16) -> F16 {
        // SAFETY: see the module.
        F16(unsafe { _mm512_max_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn abs(self) -> F16 {
        // SAFETY: see the module.
        F16(unsafe { _mm512_abs_ps(self.0) })
    }
    #[inline(always)]
    fn sqrt(self) -> F16 {
        // SAFETY: see the module.
        F16(unsafe { _mm512_sqrt_ps(self.0) })
    }
    #[inline(always)]
    fn mul_add(self, factor: F16, term: F16) -> F16 {
        // SAFETY: see the module.
        F16(unsafe { _mm512_fmadd_ps(self.0, factor.0, term.0) })
    }
    #[inline(always)]
    fn lt(self, other: F16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(mask, self.0, other.0) }
    }
    #[inline(always)]
    fn le(self, other: F16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(mask, self.0, other.0) }
    }
    #[inline(always)]
    fn gt(self, other: F16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(mask, self.0, other.0) }
    }
    #[inline(always)]
    fn ge(self, other: F16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_cmp_ps_mask::<_CMP_GE_OQ>(mask, self.0, other.0) }
    }
    #[inline(always)]
    fn eq(self, other: F16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_cmp_ps_mask::<_CMP_EQ_OQ>(mask, self.0, other.0) }
    }
    #[inline(always)]
    fn ne(self, other: F16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_cmp_ps_mask::<_CMP_NEQ_UQ>(mask, self.0, other.0) }
    }
    #[inline(always)]
    fn select(mask: u16, yes: F16, no: F16) -> F16 {
        // SAFETY: see the module.
        F16(unsafe { _mm512_mask_mov_ps(no.0, mask, yes.0) })
    }
}

impl SimdWord for W16 {
    type Mask = u16;

    #[inline(always)]
    fn splat(x: u32) -> W16 {
        // SAFETY: see the module.
        W16(unsafe { _mm512_set1_epi32(x as i32) })
    }
    #[inline(always)]
    fn lt(self, other: W16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_cmplt_epu32_mask(mask, self.0, other.0) }
    }
    #[inline(always)]
    fn ne(self, other: W16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_cmpneq_epu32_mask(mask, self.0, other.0) }
    }
    #[inline(always)]
    fn test(self, bits: W16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_test_epi32_mask(mask, self.0, bits.0) }
    }
    #[inline(always)]
    fn shr<const PLACES: u32>(self) -> W16 {
        // SAFETY: see the module.
        W16(unsafe { _mm512_srli_epi32::<PLACES>(self.0) })
    }
    #[inline(always)]
    fn select(mask: u16, yes: W16, no: W16) -> W16 {
        // SAFETY: see the module.
        W16(unsafe { _mm512_mask_mov_epi32(no.0, mask, yes.0) })
    }
}

impl F16 {
    /// From memory.
    #[inline(always)]
    pub fn load(row: &FloatRow) -> F16 {
        // SAFETY: sixteen aligned floats.
        F16(unsafe { _mm512_load_ps(row.0.as_ptr()) })
    }

    /// Three from memory.
    #[inline(always)]
    pub fn load3(rows: &[FloatRow; 3]) -> [F16; 3] {
        [
            F16::load(&rows[0]),
            F16::load(&rows[1]),
            F16::load(&rows[2]),
        ]
    }

    /// To memory.
    #[inline(always)]
    pub fn store(self, row: &mut FloatRow) {
        // SAFETY: sixteen aligned floats.
        unsafe { _mm512_store_ps(row.0.as_mut_ptr(), self.0) }
    }

    /// To memory in the lanes of a mask.
    #[inline(always)]
    pub fn store_masked(self, row: &mut FloatRow, mask: u16) {
        // SAFETY: sixteen aligned floats.
        unsafe { _mm512_mask_store_ps(row.0.as_mut_ptr(), mask, self.0) }
    }

    /// The lanes whose sign bit is set.
    #[inline(always)]
    pub fn signs(self) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_movepi32_mask(_mm512_castps_si512(self.0)) }
    }

    /// In each lane the number of the lane that `lanes` names there.
    #[inline(always)]
    pub fn permuted(self, lanes: W16) -> F16 {
        // SAFETY: see the module.
        F16(unsafe { _mm512_permutexvar_ps(lanes.0, self.0) })
    }
}

impl W16 {
    /// From memory.
    #[inline(always)]
    pub fn load(row: &WordRow) -> W16 {
        // SAFETY: sixteen aligned words.
        W16(unsafe { _mm512_load_si512(row.0.as_ptr().cast()) })
    }

    /// To memory.
    #[inline(always)]
    pub fn store(self, row: &mut WordRow) {
        // SAFETY: sixteen aligned words.
        unsafe { _mm512_store_si512(row.0.as_mut_ptr().cast(), self.0) }
    }

    /// To memory in the lanes of a mask.
    #[inline(always)]
    pub fn store_masked(self, row: &mut WordRow, mask: u16) {
        // SAFETY: sixteen aligned words.
        unsafe { _mm512_mask_store_epi32(row.0.as_mut_ptr().cast(), mask, self.0) }
    }

    /// The number of each lane.
    #[inline(always)]
    pub fn lane_numbers() -> W16 {
        // SAFETY: see the module.
        W16(unsafe { _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15) })
    }

    /// The lanes of a mask where self >= other.
    #[inline(always)]
    pub fn ge(self, other: W16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_cmpge_epu32_mask(mask, self.0, other.0) }
    }

    /// The lanes of a mask where both are equal.
    #[inline(always)]
    pub fn eq(self, other: W16, mask: u16) -> u16 {
        // SAFETY: see the module.
        unsafe { _mm512_mask_cmpeq_epu32_mask(mask, self.0, other.0) }
    }

    /// Shifted to the left.
    #[inline(always)]
    pub fn shl<const PLACES: u32>(self) -> W16 {
        // SAFETY: see the module.
        W16(unsafe { _mm512_slli_epi32::<PLACES>(self.0) })
    }

    /// Shifted to the left, each lane by its own number of bits.
    #[inline(always)]
    pub fn shl_by(self, places: W16) -> W16 {
        // SAFETY: see the module.
        W16(unsafe { _mm512_sllv_epi32(self.0, places.0) })
    }

    /// Without the bits of another.
    #[inline(always)]
    pub fn without(self, bits: W16) -> W16 {
        // SAFETY: see the module.
        W16(unsafe { _mm512_andnot_si512(bits.0, self.0) })
    }

    /// Zeros above the highest bit that is set.
    #[inline(always)]
    pub fn leading_zeros(self) -> W16 {
        // SAFETY: see the module.
        W16(unsafe { _mm512_lzcnt_epi32(self.0) })
    }

    /// Zero outside of a mask.
    #[inline(always)]
    pub fn masked(self, mask: u16) -> W16 {
        // SAFETY: see the module.
        W16(unsafe { _mm512_maskz_mov_epi32(mask, self.0) })
    }

    /// In each lane the number of the lane that `lanes` names there.
    #[inline(always)]
    pub fn permuted(self, lanes: W16) -> W16 {
        // SAFETY: see the module.
        W16(unsafe { _mm512_permutexvar_epi32(lanes.0, self.0) })
    }

    /// The same bits as floats.
    #[inline(always)]
    pub fn as_floats(self) -> F16 {
        // SAFETY: see the module.
        F16(unsafe { _mm512_castsi512_ps(self.0) })
    }
}

/// The columns of sixteen rows of four words each, of which a, b, c and d hold every fourth, from their first on.
#[inline(always)]
pub fn transposed([a, b, c, d]: [__m512i; 4]) -> [W16; 4] {
    // SAFETY: see the module.
    unsafe {
        let t0 = _mm512_unpacklo_epi32(a, b);
        let t1 = _mm512_unpackhi_epi32(a, b);
        let t2 = _mm512_unpacklo_epi32(c, d);
        let t3 = _mm512_unpackhi_epi32(c, d);
        [
            W16(_mm512_unpacklo_epi64(t0, t2)),
            W16(_mm512_unpackhi_epi64(t0, t2)),
            W16(_mm512_unpacklo_epi64(t1, t3)),
            W16(_mm512_unpackhi_epi64(t1, t3)),
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
pub(in crate::accel) use columns;
