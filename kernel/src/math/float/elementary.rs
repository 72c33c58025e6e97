//! Exponential, logarithm, power, sine, cosine and tangent, the same to the bit on every host and in shaders.
//!
//! Vulkan leaves these functions to the device (2^-11 for a sine, 3 ulp for an exponential), and two libraries of hosts
//! do not agree either. A path that passes rough glass takes their last bit to another end, so that images could only be
//! compared up to such paths. Here they are sums, products, comparisons and moves of bits, which IEEE 754 and Vulkan
//! (modules forbid the fusing of products with sums, decoration `NoContraction`, and devices round to nearest) round in one
//! way alone. Only [`pow`] and [`tan`] divide, which Vulkan allows to be off by 2.5 ulp: of `pow` that reaches the last bit at
//! most.
//!
//! Each function is a reduction to a small interval, in which no bit is lost (constants in two or three parts, after Cody
//! and Waite 1980, "Software Manual for the Elementary Functions"), and a polynomial whose coefficients minimise the
//! largest relative error of the result there (a weighted fit, each coefficient rounded to `f32` before the next ones are
//! fitted; below 5e-9). Its terms are paired (Estrin's scheme) where a processor would wait for Horner's.
//!
//! Numbers below the smallest normal one, which devices may take as zero: results are zero instead, the argument of [`ln`]
//! is looked at by its bits, and the base of [`pow`] is zero.
//!
//! Checked against `f64` functions: the errors in ulp that each function states, over its whole domain.

use super::basic::{abs, with_sign_of};

/// Added and taken away, it rounds a number below 2^22 to a whole one, which is then also the sum's low bits.
const ROUND: f32 = 12_582_912.0;

/// ln 2 in two parts; the first has fifteen bits, so that its products with exponents are exact.
const LN_2_HIGH: f32 = 0.693_145_75;
const LN_2_LOW: f32 = 1.428_606_8e-6;

/// Beyond this an exponential is infinite.
const EXP_MAX: f32 = 88.722_83;

/// Below this an exponential is not normal.
const EXP_MIN: f32 = -87.336_54;

/// Exponential; error below 1.3 ulp. Zero below -87.33654, where it would not be normal; infinite above 88.72283.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn exp(x: f32) -> f32 {
    exp_of_sum(x, 0.0)
}

/// exp(x - less) for a `less` that is far smaller than one.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn exp_of_sum(x: f32, less: f32) -> f32 {
    // x = n ln 2 + r.
    let t = x * core::f32::consts::LOG2_E + ROUND;
    let n = t - ROUND;
    let r = ((x - n * LN_2_HIGH) - n * LN_2_LOW) - less;
    let r2 = r * r;
    let low = r + r2 * (0.499_999_94 + r * 0.166_665_21);
    let high = r2 * r2 * ((0.041_668_262 + r * 0.008_368_67) + r2 * 0.001_382_100_4);
    let e = 1.0 + (low + high);
    // Times 2^n: the low bits of t move into the exponent, all others out.
    let power = f32::from_bits(e.to_bits().wrapping_add(t.to_bits() << 23));
    let power = if x < EXP_MIN { 0.0 } else { power };
    // Beyond it is an infinity, or the NaN.
    if x <= EXP_MAX {
        power
    } else {
        x * f32::INFINITY
    }
}

/// Natural logarithm; error below 1 ulp. -inf for zeros, a NaN below.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn ln(x: f32) -> f32 {
    let mut bits = x.to_bits();
    let mut exponent = 0.0;
    if bits.wrapping_sub(0x0080_0000) >= 0x7f00_0000 {
        if bits & 0x7fff_ffff == 0 {
            return -f32::INFINITY;
        }
        if bits >= 0x7f80_0000 {
            return if x > 0.0 { x } else { f32::NAN };
        }
        // Not normal: a whole multiple of 2^-149.
        bits = (bits as f32).to_bits();
        exponent = -149.0;
    }
    // x = 2^k (1 + f) with 1 + f from 2/3 to 4/3.
    let k = bits.wrapping_sub(0x3f2a_aaab) as i32 >> 23;
    let f = f32::from_bits(bits.wrapping_sub((k << 23) as u32)) - 1.0;
    let k = k as f32 + exponent;
    let f2 = f * f;
    let f4 = f2 * f2;
    let low = (0.333_332_15 - f * 0.249_998_02) + f2 * (0.200_104_46 - f * 0.166_803_09);
    let high = (0.140_053_08 - f * 0.121_866_68) + f2 * (0.139_868_9 - f * 0.128_813_76);
    let cubic = f2 * f * (low + f4 * high);
    k * LN_2_HIGH + (f + (k * LN_2_LOW + (cubic - 0.5 * f2)))
}

/// `x` to the power `y`, for finite `y`; error below 2 ulp. A base that is not positive, not normal or a NaN is taken as
/// zero. Results below 1.1755e-38 are zero.
///
/// It is exp(y ln x), where the logarithm and the product have twice the digits.
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn pow(x: f32, y: f32) -> f32 {
    if y == 0.0 {
        return 1.0;
    }
    let is_zero = !(x >= f32::MIN_POSITIVE);
    if is_zero || x > f32::MAX {
        return if is_zero == (y > 0.0) {
            0.0
        } else {
            f32::INFINITY
        };
    }
    let (high, low) = ln_in_parts(x);
    let product = y * high;
    if abs(product) > 100.0 {
        return exp(product);
    }
    // What the product has lost, by factors of twelve bits, negated.
    let (y0, h0) = (twelve_bits(y), twelve_bits(high));
    let (y1, h1) = (y - y0, high - h0);
    let less = (((product - y0 * h0) - y0 * h1) - y1 * h0) - (y1 * h1 + y * low);
    exp_of_sum(product, less)
}

/// The natural logarithm of a normal number as a sum; relative error 1e-10.
///
/// With s = f / (2 + f), ln(1 + f) = 2 artanh s = 2 s + s^3 (2/3 + 2/5 s^2 + ...).
#[inline]
fn ln_in_parts(x: f32) -> (f32, f32) {
    let bits = x.to_bits();
    // x = 2^k m with m from sqrt(1/2) to sqrt(2).
    let k = bits.wrapping_sub(0x3f35_04f3) as i32 >> 23;
    let m = f32::from_bits(bits.wrapping_sub((k << 23) as u32));
    let k = k as f32;
    let f = m - 1.0;
    // s in two parts: d + d_low is 2 + f, s0 d0 is exact.
    let d = m + 1.0;
    let d_low = m - (d - 1.0);
    let inverse = 1.0 / d;
    let s = f * inverse;
    let (s0, d0) = (twelve_bits(s), twelve_bits(d));
    let s1 = ((f - s0 * d0) - s0 * ((d - d0) + d_low)) * inverse;
    let z = s * s;
    let series = (0.666_666_63 + z * 0.400_009_72) + z * z * (0.284_987_78 + z * 0.242_795_83);
    let small = 2.0 * s1 + z * s * series;
    // The greater term first: k ln 2, unless it is zero.
    let whole = k * LN_2_HIGH;
    let sum = whole + 2.0 * s0;
    let rest = (2.0 * s0 - (sum - whole)) + (k * LN_2_LOW + small);
    let high = sum + rest;
    (high, rest - (high - sum))
}

/// The number without the lower half of its digits: products of two such are exact.
#[inline]
fn twelve_bits(x: f32) -> f32 {
    f32::from_bits(x.to_bits() & 0xffff_f000)
}

/// 2 / pi.
const TWO_OVER_PI: f32 = core::f32::consts::FRAC_2_PI;

/// pi / 2 in three parts; the first has eight bits, the second thirteen.
const HALF_PI_HIGH: f32 = 1.570_312_5;
const HALF_PI_MIDDLE: f32 = 4.838_109e-4;
const HALF_PI_LOW: f32 = 1.589_325_5e-8;

/// Angles beyond this are taken as this.
const ANGLE_MAX: f32 = 1e6;

/// Sine and cosine of radians; error below 1.6 ulp up to 4 pi (2.5 where they nearly vanish), below 1e-7 up to 3000.
///
/// From there to 1e6 the error is that of an angle whose last bit is wrong; larger ones, whose last bit is a sixteenth of
/// a radian, are taken as 1e6.
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn sin_cos(x: f32) -> (f32, f32) {
    let x = if x > ANGLE_MAX { ANGLE_MAX } else { x };
    let x = if x < -ANGLE_MAX { -ANGLE_MAX } else { x };
    // x = n pi / 2 + r.
    let t = x * TWO_OVER_PI + ROUND;
    let n = t - ROUND;
    let r = ((x - n * HALF_PI_HIGH) - n * HALF_PI_MIDDLE) - n * HALF_PI_LOW;
    rotate_quadrants(r, t.to_bits())
}

/// Sine and cosine of 2 pi x, for |x| up to 2^20; error below 2.5 ulp.
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn sin_cos_2pi(x: f32) -> (f32, f32) {
    let quarters = 4.0 * x;
    let t = quarters + ROUND;
    rotate_quadrants(
        (quarters - (t - ROUND)) * core::f32::consts::FRAC_PI_2,
        t.to_bits(),
    )
}

/// Sine and cosine of `quarter` pi / 2 + r, for `r` of at most pi / 4 in magnitude; only the low bits of `quarter` matter.
#[inline]
fn rotate_quadrants(r: f32, quarter: u32) -> (f32, f32) {
    let (sin, cos) = sin_cos_octant(r);
    // Quarter turns by bits: branches would be taken at random.
    let (sin, cos) = (sin.to_bits(), cos.to_bits());
    let exchange = (sin ^ cos) & 0u32.wrapping_sub(quarter & 1);
    (
        f32::from_bits(sin ^ exchange ^ (quarter & 2) << 30),
        f32::from_bits(cos ^ exchange ^ (quarter.wrapping_add(1) & 2) << 30),
    )
}

/// Sine and cosine of an angle of at most pi / 4 in magnitude; error below 1.5 ulp.
#[inline]
pub fn sin_cos_octant(r: f32) -> (f32, f32) {
    let z = r * r;
    let z2 = z * z;
    let sin = r + r * z * ((-0.166_666_56 + z * 0.008_332_189) - z2 * 1.951_828_6e-4);
    let cos = (1.0 - 0.5 * z) + z2 * ((0.041_666_646 - z * 0.001_388_731_1) + z2 * 2.443_256_4e-5);
    (sin, cos)
}

/// Sine of radians, as [`sin_cos`].
#[inline]
pub fn sin(x: f32) -> f32 {
    sin_cos(x).0
}

/// Cosine of radians, as [`sin_cos`].
#[inline]
pub fn cos(x: f32) -> f32 {
    sin_cos(x).1
}

/// Tangent of radians, as [`sin_cos`]; error below 4 ulp.
#[inline]
pub fn tan(x: f32) -> f32 {
    let (s, c) = sin_cos(x);
    s / c
}

/// Arc tangent of `y / x` in the right quadrant, in (-pi, pi]; relative error below 3e-7. Zero at the origin; the sign of
/// a zero `y` counts as positive.
///
/// An odd polynomial in the ratio of the smaller to the larger magnitude, which needs no table and no call; the
/// coefficients minimise the largest relative error over [0, 1].
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn atan2(y: f32, x: f32) -> f32 {
    let (a, b) = (abs(x), abs(y));
    let is_steep = b > a;
    let (small, large) = if is_steep { (a, b) } else { (b, a) };
    if !(large > 0.0) {
        return 0.0;
    }
    let t = small / large;
    let z = t * t;
    let z2 = z * z;
    let low = (1.0 - z * 0.333_330_72) + z2 * (0.199_926_2 - z * 0.142_036_44);
    let high = (0.106_409_29 - z * 0.075_042_814) + z2 * (0.042_691_343 - z * 0.016_068_509);
    let z4 = z2 * z2;
    let mut angle = t * (low + z4 * (high + z4 * 0.002_849_857_6));
    if is_steep {
        angle = core::f32::consts::FRAC_PI_2 - angle;
    }
    if x < 0.0 {
        angle = core::f32::consts::PI - angle;
    }
    with_sign_of(angle, y)
}

/// Arc tangent, as [`atan2`].
#[inline]
pub fn atan(x: f32) -> f32 {
    atan2(x, 1.0)
}
