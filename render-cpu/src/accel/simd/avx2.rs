//! Eight lanes, for processors with AVX2 and FMA.
//!
//! Values are only made where the processor has both, which the traverser asks before it takes a walk that uses them: that
//! is the reason behind every `unsafe` in this file.

use super::{SimdFloat, SimdMask, SimdWord};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Eight floats.
#[derive(Clone, Copy, Debug)]
pub struct F8(pub __m256);

/// Eight integers.
#[derive(Clone, Copy, Debug)]
pub struct W8(pub __m256i);

/// Eight lanes, of which those are chosen whose bits are all set; the bits of the others are zero.
#[derive(Clone, Copy, Debug)]
pub struct M8(pub __m256);

operator!(F8, Add, add, _mm256_add_ps);
operator!(F8, Sub, sub, _mm256_sub_ps);
operator!(F8, Mul, mul, _mm256_mul_ps);
operator!(F8, Div, div, _mm256_div_ps);
operator!(M8, BitAnd, bitand, _mm256_and_ps);
operator!(M8, BitOr, bitor, _mm256_or_ps);

impl Neg for F8 {
    type Output = F8;
    #[inline(always)]
    fn neg(self) -> F8 {
        // SAFETY: see the module.
        F8(unsafe { _mm256_xor_ps(self.0, _mm256_set1_ps(-0.0)) })
    }
}

impl Not for M8 {
    type Output = M8;
    #[inline(always)]
    fn not(self) -> M8 {
        // SAFETY: see the module.
        M8(unsafe { _mm256_xor_ps(self.0, M8::all().0) })
    }
}

impl F8 {
    /// The lanes.
    #[inline(always)]
    pub fn to_array(self) -> [f32; 8] {
        // SAFETY: both are eight floats.
        unsafe { std::mem::transmute(self.0) }
    }

    #[inline(always)]
    fn compare<const PREDICATE: i32>(self, other: F8, mask: M8) -> M8 {
        // SAFETY: see the module.
        M8(unsafe { _mm256_cmp_ps::<PREDICATE>(self.0, other.0) }) & mask
    }
}

impl SimdFloat for F8 {
    type Mask = M8;
    type Word = W8;

    #[inline(always)]
    fn splat(x: f32) -> F8 {
        // SAFETY: see the module.
        F8(unsafe { _mm256_set1_ps(x) })
    }
    #[inline(always)]
    fn min(self, other: F8) -> F8 {
        // SAFETY: see the module.
        F8(unsafe { _mm256_min_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn max(self, other: F8) -> F8 {
        // SAFETY: see the module.
        F8(unsafe { _mm256_max_ps(self.0, other.0) })
    }
    #[inline(always)]
    fn abs(self) -> F8 {
        // SAFETY: see the module.
        F8(unsafe { _mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0) })
    }
    #[inline(always)]
    fn sqrt(self) -> F8 {
        // SAFETY: see the module.
        F8(unsafe { _mm256_sqrt_ps(self.0) })
    }
    #[inline(always)]
    fn mul_add(self, factor: F8, term: F8) -> F8 {
        // SAFETY: see the module.
        F8(unsafe { _mm256_fmadd_ps(self.0, factor.0, term.0) })
    }
    #[inline(always)]
    fn lt(self, other: F8, mask: M8) -> M8 {
        self.compare::<_CMP_LT_OQ>(other, mask)
    }
    #[inline(always)]
    fn le(self, other: F8, mask: M8) -> M8 {
        self.compare::<_CMP_LE_OQ>(other, mask)
    }
    #[inline(always)]
    fn gt(self, other: F8, mask: M8) -> M8 {
        self.compare::<_CMP_GT_OQ>(other, mask)
    }
    #[inline(always)]
    fn ge(self, other: F8, mask: M8) -> M8 {
        self.compare::<_CMP_GE_OQ>(other, mask)
    }
    #[inline(always)]
    fn eq(self, other: F8, mask: M8) -> M8 {
        self.compare::<_CMP_EQ_OQ>(other, mask)
    }
    #[inline(always)]
    fn ne(self, other: F8, mask: M8) -> M8 {
        self.compare::<_CMP_NEQ_UQ>(other, mask)
    }
    #[inline(always)]
    fn select(mask: M8, yes: F8, no: F8) -> F8 {
        // SAFETY: see the module.
        F8(unsafe { _mm256_blendv_ps(no.0, yes.0, mask.0) })
    }
}

impl M8 {
    /// The lanes whose bits are set, the lowest first.
    #[inline(always)]
    pub fn from_bits(bits: u32) -> M8 {
        // SAFETY: see the module.
        unsafe {
            let lanes = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let chosen = _mm256_and_si256(_mm256_set1_epi32(bits as i32), lanes);
            M8(_mm256_castsi256_ps(_mm256_cmpeq_epi32(chosen, lanes)))
        }
    }

    /// A bit per lane, the lowest first.
    #[inline(always)]
    pub fn to_bits(self) -> u32 {
        // SAFETY: see the module.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
}

impl SimdMask for M8 {
    #[inline(always)]
    fn all() -> M8 {
        // SAFETY: see the module.
        M8(unsafe { _mm256_castsi256_ps(_mm256_set1_epi32(-1)) })
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.to_bits() != 0
    }
}

impl SimdWord for W8 {
    type Mask = M8;

    #[inline(always)]
    fn splat(x: u32) -> W8 {
        // SAFETY: see the module.
        W8(unsafe { _mm256_set1_epi32(x as i32) })
    }
    #[inline(always)]
    fn lt(self, other: W8, mask: M8) -> M8 {
        // Comparisons are of numbers with signs.
        // SAFETY: see the module.
        unsafe {
            let half = _mm256_set1_epi32(i32::MIN);
            let (a, b) = (
                _mm256_xor_si256(self.0, half),
                _mm256_xor_si256(other.0, half),
            );
            M8(_mm256_castsi256_ps(_mm256_cmpgt_epi32(b, a))) & mask
        }
    }
    #[inline(always)]
    fn ne(self, other: W8, mask: M8) -> M8 {
        // SAFETY: see the module.
        let equal = unsafe { _mm256_cmpeq_epi32(self.0, other.0) };
        // SAFETY: see the module.
        M8(unsafe { _mm256_andnot_ps(_mm256_castsi256_ps(equal), mask.0) })
    }
    #[inline(always)]
    fn test(self, bits: W8, mask: M8) -> M8 {
        // SAFETY: see the module.
        let both = W8(unsafe { _mm256_and_si256(self.0, bits.0) });
        both.ne(W8::splat(0), mask)
    }
    #[inline(always)]
    fn shr<const PLACES: u32>(self) -> W8 {
        // SAFETY: see the module.
        W8(unsafe { _mm256_srl_epi32(self.0, _mm_cvtsi32_si128(PLACES as i32)) })
    }
    #[inline(always)]
    fn select(mask: M8, yes: W8, no: W8) -> W8 {
        // SAFETY: see the module.
        unsafe {
            let (yes, no) = (_mm256_castsi256_ps(yes.0), _mm256_castsi256_ps(no.0));
            W8(_mm256_castps_si256(_mm256_blendv_ps(no, yes, mask.0)))
        }
    }
}
