//! Sums of floats that do not depend on the order of their terms.
//!
//! Floating-point addition is not associative: what many threads add to one pixel comes out differently from run to run.
//! Integer addition is associative, so the sums here are fixed-point integers, wide enough for every term (after Kulisch;
//! Demmel and Nguyen 2015, "Parallel Reproducible Summation", survey the alternatives). Any order, any number of
//! threads, and any division into parts that are merged later give the same bits, which tests check against big integers.
//!
//! | | unit | width | exact for | largest rounding of a term |
//! |---|---|---|---|---|
//! | [`ExactSum`], of x | 2^-56 | 128 bits | abs(x) >= 2^-33 = 1.2e-10, and 0 | 2^-57 = 7e-18 |
//! | [`ExactSquareSum`], of x^2 | 2^-80 | 192 bits | abs(x) >= 2^-17 = 7.6e-6, and 0 | 2^-81 = 4e-25 |
//!
//! Smaller terms are rounded to the nearest unit, halves away from zero, before they are added; a term's rounding is a
//! function of the term alone, so that the sum still does not depend on the order.
//!
//! # Range
//! Terms beyond [`LIMIT`] = 2^40 in magnitude count as plus or minus that limit, NaNs and infinities add nothing: the caller
//! counts them if that matters. With these limits fewer than 2^31 terms cannot overflow ([`ExactSquareSum`]: 2^32); with terms
//! of magnitude m the bound is 2^71 / m (2^112 / m^2). Beyond it sums wrap around.
//!
//! # Cost
//! A term takes a shift and two additions with carry, its square a multiplication, a shift and three additions. Records are
//! plain data: 16 bytes for a sum, 24 for a sum of squares, 40 for both ([`ExactMoments`]).

use bytemuck::{Pod, Zeroable};

/// Terms of greater magnitude count as this: 2^40.
pub const LIMIT: f32 = 1_099_511_627_776.0;

/// Bits behind the binary point of a sum.
const FRACTION: i32 = 56;

/// Bits behind the binary point of a sum of squares.
const SQUARE_FRACTION: i32 = 80;

/// Exponent of the unit in which [`decompose`] gives the mantissa of a float whose biased exponent is zero.
const BIAS: i32 = 150;

/// A sum of floats; 16 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct ExactSum {
    /// Two's complement in units of 2^-56, the lower word first.
    words: [u64; 2],
}

/// A sum of squares of floats; 24 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct ExactSquareSum {
    /// In units of 2^-80, the lowest word first.
    words: [u64; 3],
}

/// What mean and variance are made of; 40 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct ExactMoments {
    /// Sum of the terms.
    pub sum: ExactSum,
    /// Sum of their squares.
    pub squares: ExactSquareSum,
}

/// Mantissa and biased exponent of a term's magnitude, m 2^(e - 150), after the limits of the module.
#[inline(always)]
fn decompose(x: f32) -> (u64, i32) {
    let bits = x.to_bits() & 0x7fff_ffff;
    let is_finite = bits < f32::INFINITY.to_bits();
    let bits = if is_finite {
        bits.min(LIMIT.to_bits())
    } else {
        0
    };
    let exponent = (bits >> 23) as i32;
    let fraction = bits & 0x007f_ffff;
    if exponent == 0 {
        (u64::from(fraction), 1)
    } else {
        (u64::from(fraction | 0x0080_0000), exponent)
    }
}

/// n / 2^places to the nearest integer, halves upwards; n < 2^48.
#[inline(always)]
fn rounded_shift(n: u64, places: i32) -> u64 {
    let places = places.min(49);
    (n + (1 << (places - 1))) >> places
}

impl ExactSum {
    /// The sum of no terms.
    pub const ZERO: ExactSum = ExactSum { words: [0; 2] };

    /// Adds a term.
    #[inline]
    pub fn add(&mut self, x: f32) {
        let (mantissa, exponent) = decompose(x);
        let shift = exponent - BIAS + FRACTION;
        let magnitude = if shift >= 0 {
            i128::from(mantissa) << shift
        } else {
            i128::from(rounded_shift(mantissa, -shift))
        };
        let term = if x.is_sign_negative() {
            -magnitude
        } else {
            magnitude
        };
        self.set(self.fixed().wrapping_add(term));
    }

    /// Adds the terms of another sum.
    #[inline]
    pub fn merge(&mut self, other: &ExactSum) {
        self.set(self.fixed().wrapping_add(other.fixed()));
    }

    /// The sum, rounded to the nearest f64.
    pub fn value(&self) -> f64 {
        self.fixed() as f64 * exp2(-FRACTION)
    }

    /// The sum in units of 2^-56.
    #[inline]
    pub fn fixed(&self) -> i128 {
        (u128::from(self.words[1]) << 64 | u128::from(self.words[0])) as i128
    }

    #[inline]
    fn set(&mut self, fixed: i128) {
        self.words = [fixed as u64, (fixed >> 64) as u64];
    }
}

impl ExactSquareSum {
    /// The sum of no terms.
    pub const ZERO: ExactSquareSum = ExactSquareSum { words: [0; 3] };

    /// Adds the square of a term.
    #[inline]
    pub fn add(&mut self, x: f32) {
        let (mantissa, exponent) = decompose(x);
        let square = mantissa * mantissa;
        let shift = 2 * (exponent - BIAS) + SQUARE_FRACTION;
        if shift < 0 {
            self.add_words([rounded_shift(square, -shift), 0, 0]);
            return;
        }
        // A square of 48 bits, shifted by at most 114, covers two neighbouring words.
        let wide = u128::from(square) << (shift & 63);
        let (low, high) = (wide as u64, (wide >> 64) as u64);
        self.add_words(if shift < 64 {
            [low, high, 0]
        } else {
            [0, low, high]
        });
    }

    /// Adds the terms of another sum.
    #[inline]
    pub fn merge(&mut self, other: &ExactSquareSum) {
        self.add_words(other.words);
    }

    /// The sum, rounded to the nearest f64.
    pub fn value(&self) -> f64 {
        to_f64(&self.words) * exp2(-SQUARE_FRACTION)
    }

    /// The sum in units of 2^-80, the lowest word first.
    pub fn fixed(&self) -> [u64; 3] {
        self.words
    }

    #[inline(always)]
    fn add_words(&mut self, other: [u64; 3]) {
        let mut carry = false;
        for (word, other) in self.words.iter_mut().zip(other) {
            let (sum, first) = word.overflowing_add(other);
            let (sum, second) = sum.overflowing_add(u64::from(carry));
            *word = sum;
            carry = first | second;
        }
    }
}

impl ExactMoments {
    /// Of no terms.
    pub const ZERO: ExactMoments = ExactMoments {
        sum: ExactSum::ZERO,
        squares: ExactSquareSum::ZERO,
    };

    /// Adds a term.
    #[inline]
    pub fn add(&mut self, x: f32) {
        self.sum.add(x);
        self.squares.add(x);
    }

    /// Adds the terms of others.
    #[inline]
    pub fn merge(&mut self, other: &ExactMoments) {
        self.sum.merge(&other.sum);
        self.squares.merge(&other.squares);
    }

    /// Mean of `count` samples, of which the terms are those that are not zero; zero without samples.
    pub fn mean(&self, count: u64) -> f64 {
        if count == 0 {
            return 0.0;
        }
        self.sum.value() / count as f64
    }

    /// Estimated variance of that mean, (S_2 - S_1^2 / n) / (n (n - 1)); zero below two samples, where nothing is
    /// known of it. The difference is taken between integers, so that nothing cancels however small the variance is beside
    /// the square of the mean.
    pub fn variance_of_mean(&self, count: u64) -> f64 {
        if count < 2 {
            return 0.0;
        }
        // n S_2 - S_1^2 in units of 2^-112.
        let scaled = {
            let [a, b, c] = self.squares.words;
            [a << 32, a >> 32 | b << 32, b >> 32 | c << 32, c >> 32]
        };
        let magnitude = self.sum.fixed().unsigned_abs();
        let magnitude = [magnitude as u64, (magnitude >> 64) as u64];
        let difference = difference(
            product::<5>(&scaled, &[count]),
            product::<5>(&magnitude, &magnitude),
        );
        let n = count as f64;
        to_f64(&difference) * exp2(-2 * FRACTION) / (n * n * (n - 1.0))
    }
}

const _: () = assert!(SQUARE_FRACTION + 32 == 2 * FRACTION);

/// 2^n for an exponent of a normal number.
fn exp2(n: i32) -> f64 {
    f64::from_bits(((n + 1023) as u64) << 52)
}

/// The product of two numbers, lowest words first, of which `N` words hold all.
fn product<const N: usize>(a: &[u64], b: &[u64]) -> [u64; N] {
    let mut result = [0; N];
    for (i, &x) in a.iter().enumerate() {
        let mut carry = 0u128;
        for (j, slot) in result[i..].iter_mut().enumerate() {
            let y = b.get(j).copied().unwrap_or(0);
            let sum = u128::from(x) * u128::from(y) + u128::from(*slot) + carry;
            *slot = sum as u64;
            carry = sum >> 64;
        }
    }
    result
}

/// a - b, or zero where b is greater: rounded squares can come out a little too small.
fn difference<const N: usize>(a: [u64; N], b: [u64; N]) -> [u64; N] {
    let mut result = [0; N];
    let mut borrow = false;
    for k in 0..N {
        let (x, first) = a[k].overflowing_sub(b[k]);
        let (x, second) = x.overflowing_sub(u64::from(borrow));
        result[k] = x;
        borrow = first | second;
    }
    if borrow { [0; N] } else { result }
}

/// The nearest f64 to a number, lowest word first.
fn to_f64(words: &[u64]) -> f64 {
    let Some(top) = words.iter().rposition(|&word| word != 0) else {
        return 0.0;
    };
    let zeros = words[top].leading_zeros();
    let below = if top > 0 { words[top - 1] } else { 0 };
    let two = (u128::from(words[top]) << 64 | u128::from(below)) << zeros;
    // The leading 64 bits decide the rounding together with whether anything follows.
    let rest = two as u64 != 0 || words[..top.saturating_sub(1)].iter().any(|&word| word != 0);
    let leading = (two >> 64) as u64 | u64::from(rest);
    leading as f64 * exp2(64 * top as i32 - zeros as i32)
}
