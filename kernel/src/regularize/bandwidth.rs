//! Bandwidths: how fast a mollifier shrinks over the samples of a progressive estimator.
//!
//! - Monte Carlo: `r_n = r_0 n^-lambda` is consistent for `0 < lambda < 1/d`, d the dimensions of the mollified delta
//!   distributions of a path together (Kaplanyan 2017, equation 6.5: `O(n^(-1/d)) < r_n < O(1)`; the line that ends
//!   the proof of lemma 1 prints n^(1/d), and the test of the mollified estimator settles it). The error falls
//!   fastest, as `n^(-4/(d+4))`, at `lambda = 1/(d+4)`: the balance of variance `r^-d / n` with squared bias `r^4`.
//!   That is 1/6 for one specular vertex, as the thesis has it; for two (d = 4) it is 1/8, not the thesis's 1/12,
//!   which is consistent but slower. The mean of r_n^2 cannot fall faster than 1/n, which the first samples leave:
//!   beyond lambda = 1/2 the bias gains nothing.
//! - Markov chains: `r_n = r_0 gamma^n`, not faster than the chain mixes (equation 6.7); gamma = 1 - 1e-4 in the
//!   thesis.
//! - Microfacet models: tau_N, the maximum that a regularised BSDF may have in iteration N, the value of the constant
//!   cone whose tangent shrinks as N^(-1/6) (Jendersie and Grosch 2019, equation 16), here without the cancellation of
//!   `1 - cos(atan(t))`: `t = sqrt(4 pi tau_0 - 1) / (2 pi tau_0 - 1) N^(-1/6)`, `q = sqrt(1 + t^2)`, `tau_N = q (1 +
//!   q) / (2 pi t^2)`.
//!
//! `n` and `N` count from 1. Radii in scene units, tau per steradian. Invariants (tests): bounds of the exponents by
//! the rate of a simulated estimator, tau_1 = tau_0, tau_N ~ tau_0 N^(1/3), agreement with equation 16 in double
//! precision.

use crate::math::float::{exp, ln_1p, pow, safe_sqrt, sqrt};
use core::f32::consts::PI;

/// Largest threshold: a roughness that `f32` directions resolve stays below it. It means "not regularised".
pub const TAU_MAX: f32 = 1e18;

/// Smallest threshold: the cone of that value is a hemisphere but for a rounding error.
pub const TAU_MIN: f32 = 1.0001 * 0.5 * core::f32::consts::FRAC_1_PI;

/// The exponent that a schedule must stay below, 1/d.
#[inline]
pub fn largest_exponent(dimensions: u32) -> f32 {
    1.0 / dimensions.max(1) as f32
}

/// The exponent of the fastest convergence, 1/(d + 4).
#[inline]
pub fn optimal_exponent(dimensions: u32) -> f32 {
    1.0 / (dimensions.max(1) + 4) as f32
}

/// Whether `r_0 n^-lambda` gives a consistent estimator for delta distributions of `dimensions` in total.
#[inline]
pub fn is_consistent(lambda: f32, dimensions: u32) -> bool {
    lambda > 0.0 && lambda < largest_exponent(dimensions)
}

/// `r_0 n^-lambda`.
#[inline]
pub fn power_law(initial: f32, n: u32, lambda: f32) -> f32 {
    initial * pow(n.max(1) as f32, -lambda)
}

/// `r_0 gamma^n` from `one_minus_gamma`, in [0, 1): gamma itself has lost the digits that make the rate.
#[inline]
pub fn geometric(initial: f32, one_minus_gamma: f32, n: u32) -> f32 {
    let g = one_minus_gamma.max(0.0).min(0.999_999);
    let log = ln_1p(-g);
    initial * exp(log * n as f32)
}

/// Tangent of the cone whose value is `tau`: `sqrt(4 pi tau - 1) / (2 pi tau - 1)`.
#[inline]
pub fn cone_tangent(tau: f32) -> f32 {
    let tau = tau.max(TAU_MIN).min(TAU_MAX);
    safe_sqrt(4.0 * PI * tau - 1.0) / (2.0 * PI * tau - 1.0)
}

/// Value of the cone whose half angle has the tangent `t > 0`; at most [`TAU_MAX`].
#[inline]
pub fn cone_value(t: f32) -> f32 {
    let q = sqrt(1.0 + t * t);
    // Two roots of t^2 instead of it: the square of a small tangent may underflow.
    let value = q / t * ((1.0 + q) / t) * (0.5 / PI);
    if value < TAU_MAX { value } else { TAU_MAX }
}

/// tau_N for `iteration` N with the exponent of one specular vertex, 1/6.
#[inline]
pub fn tau_schedule(tau0: f32, iteration: u32) -> f32 {
    tau_power_law(tau0, iteration, 1.0 / 6.0)
}

/// tau_N with the cone's tangent falling as N^-lambda; `tau0` is taken as [`TAU_MIN`] below that.
#[inline]
pub fn tau_power_law(tau0: f32, iteration: u32, lambda: f32) -> f32 {
    if !(tau0 < TAU_MAX) {
        return TAU_MAX;
    }
    cone_value(power_law(cone_tangent(tau0), iteration, lambda))
}
