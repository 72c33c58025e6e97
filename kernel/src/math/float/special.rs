//! Functions beyond the elementary ones: `exp(x) - 1` and `ln(1 + x)` near zero, the error function and its relatives, and
//! quantiles of the Gamma distribution.
//!
//! Polynomials whose error bounds each function states; tests compare them with `f64` functions over their domains.

use super::basic::{abs, sqrt, with_sign_of};
use super::elementary::{exp, ln, pow};

/// A polynomial by Horner's rule, coefficients from that of `x^0` on. Written out, because a shader compiler would store
/// a table anew at each use.
macro_rules! polynomial {
    (@ $x:ident; $c:literal) => { $c };
    (@ $x:ident; $c:literal, $($more:literal),+) => { $c + $x * polynomial!(@ $x; $($more),+) };
    ($x:expr; $($c:literal),+) => {{
        let x: f32 = $x;
        polynomial!(@ x; $($c),+)
    }};
}

/// `exp(x) - 1` without its cancellation near zero, for `x <= 80`; relative error below 3e-7.
///
/// A polynomial of Taylor coefficients below 0.35, where the next term is the error.
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn exp_m1(x: f32) -> f32 {
    if abs(x) < 0.35 {
        x * polynomial!(x; 1.0, 0.5, 0.166_666_67, 0.041_666_667, 0.008_333_333_5, 0.001_388_888_9, 0.000_198_412_7)
    } else {
        exp(x) - 1.0
    }
}

/// `ln(1 + x)` without its cancellation near zero, for `x > -1`; relative error below 3e-7.
///
/// `2 artanh(s)` with `s = x / (2 + x)` below 0.35; `1 + x` would lose the digits of a small `x`.
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn ln_1p(x: f32) -> f32 {
    if abs(x) < 0.35 {
        let s = x / (2.0 + x);
        2.0 * s
            * polynomial!(s * s; 1.0, 0.333_333_34, 0.2, 0.142_857_15, 0.111_111_11, 0.090_909_09)
    } else {
        ln(1.0 + x)
    }
}

/// Error function, `2 / sqrt(pi)` times the integral of `exp(-t^2)` from 0 to `x`; relative error below 3e-7.
///
/// Odd polynomial below 1, complement of [`erfc_scaled`] above. Coefficients: truncated Chebyshev series.
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn erf(x: f32) -> f32 {
    let a = abs(x);
    if a < 1.0 {
        x * polynomial!(2.0 * x * x - 1.0; 0.965468764, -0.1405361, 0.0198518056, -0.0022854195, 0.000219359456, -1.7669081e-05)
    } else {
        with_sign_of(1.0 - exp(-a * a) * erfc_scaled(a), x)
    }
}

/// `exp(x^2) erfc(x)` for `x >= 0` (negative `x` is taken as 0), the complementary error function without its
/// underflow; relative error below 4e-7.
///
/// `(1 + 2 x) exp(x^2) erfc(x)` is a polynomial in `(x - 2) / (x + 2)` (the form of Shepherd and Laframboise 1981,
/// "Chebyshev approximation of (1 + 2x) exp(x^2) erfc x in 0 <= x < infinity"; coefficients fitted anew).
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn erfc_scaled(x: f32) -> f32 {
    let x = if x > 0.0 { x } else { 0.0 };
    polynomial!((x - 2.0) / (x + 2.0); 1.27697837, -0.0927630812, -0.166031092, 0.164035842, -0.0542119592, -0.00794272125, 0.00868915953, 0.00104314461, -0.0013957069, -0.00018365444, 0.000160803582)
        / (1.0 + 2.0 * x)
}

/// Inverse of [`erf`]; relative error below 4e-6. `x` is clamped to the largest `f32` below 1 in magnitude, so that
/// the result stays within 3.84.
///
/// Two polynomials over `w = -ln(1 - x^2)`, in `w` below 5 and in its square root above (the form of Giles 2012,
/// "Approximating the erfinv function"; coefficients fitted anew).
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn erf_inv(x: f32) -> f32 {
    const LIMIT: f32 = 0.999_999_94;
    let x = x.max(-LIMIT).min(LIMIT);
    let w = -ln((1.0 - x) * (1.0 + x));
    if w < 5.0 {
        x * polynomial!(0.4 * w - 1.0; 1.50140905, 0.616601884, -0.0260998029, -0.0195898227, 0.00848476216, -0.000428089028, -0.000774483196, 0.000209060585)
    } else {
        // sqrt(w) from sqrt(5) to sqrt(17) onto -1 to 1.
        x * polynomial!(1.059_862_3 * sqrt(w) - 3.369_924_1; 3.01313066, 0.947698712, 0.00554032065, -0.00370629947, 0.00258871447, -0.00185979938, 0.000685121631)
    }
}

/// `Gamma(1 + x)` for `x` in [0, 10]; relative error below 1e-6.
///
/// Recurrence down to [0, 1], there the polynomial 6.1.36 of Abramowitz and Stegun 1964.
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn gamma_1p(x: f32) -> f32 {
    let mut x = x.max(0.0).min(10.0);
    let mut product = 1.0;
    while x > 1.0 {
        product *= x;
        x -= 1.0;
    }
    product
        * polynomial!(x; 1.0, -0.577191652, 0.988205891, -0.897056937, 0.918206857, -0.756704078, 0.482199394, -0.193527818, 0.035868343)
}

/// `x^shape` at the quantile `u` of the Gamma distribution of unit scale, `shape` in [0.2, 5]: the power stays in range
/// where `x` does not. `u` is in [0, 1), cut at 1 - 6e-8. Relative error below 2e-5 in the density's bulk (tested
/// against f64).
///
/// Wilson and Hilferty's start, or the power law of small quantiles, then Halley's method on the incomplete Gamma
/// function: its series below `shape + 1`, its continued fraction above (Abramowitz and Stegun 1964, 6.5.29, 6.5.31).
pub fn inverse_gamma_distribution(shape: f32, u: f32) -> f32 {
    let k = shape.max(0.2).min(5.0);
    let gamma = gamma_1p(k);
    let upper = (1.0 - u).max(6e-8);
    // P(x) = x^k / Gamma(1 + k) (1 - k x / (k + 1) + ...).
    let power = u.max(0.0) * gamma;
    let small = pow(power, 1.0 / k);
    if small < 1e-5 {
        return power;
    }
    let mut x = if small < 0.15 * (k + 1.0) {
        small * (1.0 + small / (k + 1.0))
    } else if k < 1.0 && upper < 0.5 {
        // The tail is x^(k - 1) exp(-x) / Gamma(k).
        let tail = -ln(upper * gamma / k);
        tail.max(0.3)
    } else {
        let z = core::f32::consts::SQRT_2 * erf_inv(2.0 * u - 1.0);
        let c = 1.0 / (9.0 * k);
        let root = 1.0 - c + z * sqrt(c);
        let x = k * root * root * root;
        if x > 0.1 * small { x } else { small }
    };
    for _ in 0..6 {
        // The density times x, x^k exp(-x) / Gamma(k).
        let scaled = pow(x, k) * exp(-x) * k / gamma;
        let error = if x < k + 1.0 {
            gamma_series(k, x) * scaled - u
        } else {
            upper - gamma_fraction(k, x) * scaled
        };
        if scaled <= 0.0 {
            break;
        }
        let newton = error / scaled;
        // Relative steps; Halley's correction is limited where the start is far.
        let halley = 1.0 - 0.5 * (newton * (k - 1.0 - x)).max(-1.0).min(1.0);
        let step = (newton / halley).max(-1.0).min(0.7);
        x *= 1.0 - step;
        if abs(step) < 1e-5 {
            break;
        }
    }
    pow(x, k)
}

/// `P(k, x) Gamma(k) / (x^k exp(-x))` for `x < k + 1`.
#[inline]
fn gamma_series(k: f32, x: f32) -> f32 {
    let mut term = 1.0 / k;
    let mut sum = term;
    for n in 1..32 {
        term *= x / (k + n as f32);
        sum += term;
        if term < 1e-7 * sum {
            break;
        }
    }
    sum
}

/// `Q(k, x) Gamma(k) / (x^k exp(-x))` for `x >= k + 1`, by the modified Lentz method.
#[inline]
fn gamma_fraction(k: f32, x: f32) -> f32 {
    let mut b = x + 1.0 - k;
    let mut c = 1e30_f32;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..32 {
        let a = -(i as f32) * (i as f32 - k);
        b += 2.0;
        d = 1.0 / (a * d + b);
        c = b + a / c;
        let factor = c * d;
        h *= factor;
        if abs(factor - 1.0) < 1e-7 {
            break;
        }
    }
    h
}
