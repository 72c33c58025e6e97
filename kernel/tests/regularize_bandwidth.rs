//! Bandwidths: tau_N against double precision, and the exponents of the thesis against simulated and summed errors.

mod common;

use common::Random;
use halflight_kernel::regularize::bandwidth::{
    TAU_MAX, TAU_MIN, geometric, is_consistent, largest_exponent, optimal_exponent, power_law,
    tau_schedule,
};
use halflight_kernel::regularize::mollifier::{self, PARABOLIC};
use proptest::prelude::*;
use std::f64::consts::PI;

/// Equation 16 of Jendersie and Grosch, as printed.
fn equation_16(tau0: f64, n: f64) -> f64 {
    let t = (4.0 * PI * tau0 - 1.0).sqrt() / (2.0 * PI * tau0 - 1.0) * n.powf(-1.0 / 6.0);
    1.0 / (2.0 * PI * (1.0 - t.atan().cos()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    /// Where equation 16 itself keeps eight digits in double precision (tau below 1e7).
    #[test]
    fn tau_is_that_of_equation_16(log_tau in -0.75_f64..5.0, log_n in 0.0_f64..6.0) {
        let tau0 = 10_f64.powf(log_tau) as f32;
        let n = 10_f64.powf(log_n) as u32;
        let want = equation_16(f64::from(tau0), f64::from(n));
        let got = f64::from(tau_schedule(tau0, n));
        // Near 1/(2 pi) the tangent's denominator 2 pi tau - 1 amplifies the rounding of tau.
        let condition = 1.0 + 1.0 / (2.0 * PI * f64::from(tau0) - 1.0);
        prop_assert!((got / want - 1.0).abs() < 2e-6 * condition, "{tau0} {n}: {got} {want}");
    }

    #[test]
    fn tau_starts_at_tau_0_and_grows(log_tau in -0.7_f64..15.0, n in 1_u32..1_000_000) {
        let tau0 = 10_f64.powf(log_tau) as f32;
        prop_assert!((tau_schedule(tau0, 1) / tau0 - 1.0).abs() < 5e-6 / (tau0 - TAU_MIN).min(1.0));
        prop_assert!(tau_schedule(tau0, n + 1) >= tau_schedule(tau0, n) * (1.0 - 1e-6));
        prop_assert!(tau_schedule(tau0, n) <= TAU_MAX);
        if tau0 > 100.0 {
            let ratio = tau_schedule(tau0, n) / (tau0 * (n as f32).cbrt());
            prop_assert!((ratio - 1.0).abs() < 1.0 / tau0 + 1e-5, "{ratio}");
        }
    }

    #[test]
    fn schedules_are_finite(
        x in prop::num::f32::NORMAL | prop::num::f32::ZERO,
        y in 0.0_f32..1.0,
        n in any::<u32>(),
    ) {
        let tau = tau_schedule(x, n);
        prop_assert!(tau > 0.0 && tau <= TAU_MAX);
        prop_assert!(power_law(x, n, y).is_finite());
        prop_assert!(geometric(x, y, n).is_finite());
    }
}

#[test]
fn geometric_keeps_the_digits_of_gamma() {
    for rate in [1e-4_f32, 1e-6, 0.3] {
        for n in [1_u32, 100, 10_000, 40_000] {
            let want = (f64::from(n) * (-f64::from(rate)).ln_1p()).exp();
            let got = f64::from(geometric(1.0, rate, n));
            let tolerance = 1e-6 * (1.0 + f64::from(n) * f64::from(rate));
            assert!(
                (got - want).abs() <= tolerance * want + 1e-37,
                "{rate} {n}: {got} {want}"
            );
        }
    }
}

/// Half the side of the square that samples are drawn from, uniformly: p = 1 / (2 SIDE)^d.
const SIDE: f64 = 1.0;

/// The function in front of the delta: g(0) = 1, Laplacian -d.
fn g(squared: f64) -> f64 {
    1.0 - 0.5 * squared
}

/// Mean and variance of one mollified sample `phi_r(X) g(X) / p`, by Simpson's rule over the ball.
fn one_sample(d: u32, r: f64) -> (f64, f64) {
    let n = 64;
    let volume = (2.0 * SIDE).powi(d as i32);
    let (mut mean, mut square) = (0.0, 0.0);
    for i in 0..=n {
        let t = f64::from(i) / f64::from(n);
        let rule = if i == 0 || i == n {
            1.0
        } else {
            f64::from(2 + 2 * (i % 2))
        };
        let surface = if d == 1 { 2.0 } else { 2.0 * PI * t };
        let phi = f64::from(mollifier::eval(PARABOLIC, d, t as f32));
        let value = phi * g(t * t * r * r);
        let weight = rule * surface / (3.0 * f64::from(n));
        mean += weight * value;
        square += weight * value * value;
    }
    (mean, square * volume / r.powi(d as i32) - mean * mean)
}

/// Bias and variance of the estimator after N samples, at two N.
fn bias_and_variance(initial: f32, d: u32, lambda: f32, counts: [u32; 2]) -> [(f64, f64); 2] {
    let (mut bias, mut variance) = (0.0, 0.0);
    let mut result = [(0.0, 0.0); 2];
    for n in 1..=counts[1] {
        let (mean, v) = one_sample(d, f64::from(power_law(initial, n, lambda)));
        bias += mean - 1.0;
        variance += v;
        for (at, count) in result.iter_mut().zip(counts) {
            if n == count {
                let n = f64::from(n);
                *at = (bias / n, variance / (n * n));
            }
        }
    }
    result
}

/// The proof of lemma 1: bias falls as n^(-2 lambda), variance as n^(d lambda - 1). It vanishes for lambda < 1/d (the
/// thesis once prints the bound as n^(1/d)), and the squared error falls fastest, as n^(-4/(d+4)), at 1/(d+4).
#[test]
fn bias_and_variance_fall_at_the_stated_rates() {
    let counts = [1 << 12, 1 << 17];
    let slope = |a: f64, b: f64| (b / a).abs().ln() / f64::from(counts[1] / counts[0]).ln();
    for d in [1, 2] {
        let best = optimal_exponent(d);
        let error = |initial: f32, lambda: f32| {
            let e = bias_and_variance(initial, d, lambda, counts);
            slope(e[0].0.powi(2) + e[0].1, e[1].0.powi(2) + e[1].1)
        };
        for lambda in [0.5 * best, best, 1.5 * best] {
            // From a small radius, so that the variance's constant term does not matter.
            let e = bias_and_variance(0.1, d, lambda, counts);
            let (bias, variance) = (slope(e[0].0, e[1].0), slope(e[0].1, e[1].1));
            let l = f64::from(lambda);
            assert!(
                (bias + 2.0 * l).abs() < 0.02,
                "d {d}, {lambda}: bias {bias}"
            );
            assert!(
                (variance + 1.0 - f64::from(d) * l).abs() < 0.04,
                "d {d}, {lambda}: {variance}"
            );
        }
        let want = -4.0 / (f64::from(d) + 4.0);
        let at_best = error(1.0, best);
        assert!((at_best - want).abs() < 0.05, "d {d}: {at_best}");
        // Slower shrinking leaves the bias, seen from a large radius; faster the variance, seen from a small one.
        let (slow, fast) = (error(3.0, 0.6 * best), error(0.3, 1.5 * best));
        assert!(
            slow > want + 0.1 && fast > want + 0.05,
            "d {d}: {slow} {fast}"
        );
        let beyond = bias_and_variance(1.0, d, 1.2 * largest_exponent(d), counts);
        assert!(beyond[1].1 > beyond[0].1, "d {d}: {beyond:?}");
        assert!(is_consistent(best, d) && !is_consistent(1.2 * largest_exponent(d), d));
    }
    assert!(!is_consistent(0.0, 2) && !is_consistent(0.5, 2) && is_consistent(0.49, 2));
}

/// The sums above are those of the estimator: mean and variance of 4000 independent runs of 256 samples, within five
/// standard errors of the mean and eight per cent of the variance.
#[test]
fn the_mollified_estimator_has_that_bias_and_variance() {
    for d in [1, 2] {
        let lambda = optimal_exponent(d);
        let (runs, n) = (4000, 256);
        let mut random = Random(u64::from(d));
        let volume = (2.0 * SIDE).powi(d as i32);
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..runs {
            let mut value = 0.0;
            for i in 1..=n {
                let mut squared = 0.0_f32;
                for _ in 0..d {
                    let x = 2.0 * random.next_1d() - 1.0;
                    squared += x * x;
                }
                let r = power_law(1.0, i, lambda);
                let phi = mollifier::eval_scaled(PARABOLIC, d, squared.sqrt(), r);
                value += f64::from(phi) * volume * g(f64::from(squared)) / f64::from(n);
            }
            sum += value;
            squares += value * value;
        }
        let mean = sum / f64::from(runs);
        let variance = squares / f64::from(runs) - mean * mean;
        let (bias, want) = bias_and_variance(1.0, d, lambda, [1, n])[1];
        let error = (variance / f64::from(runs)).sqrt();
        assert!(
            (mean - 1.0 - bias).abs() < 5.0 * error,
            "{d}: {mean} {bias} {error}"
        );
        assert!(
            (variance / want - 1.0).abs() < 0.08,
            "{d}: {variance} {want}"
        );
        assert!(error < 0.2 * bias.abs(), "too coarse");
    }
}

/// Asymptotic error with all constants one, bias `1/N sum r_n^2` and variance `1/N^2 sum r_n^-d`: for two specular
/// vertices (d = 4) the exponent 1/8 converges faster than the 1/12 of the thesis.
#[test]
fn two_vertices_converge_fastest_at_one_eighth() {
    let error = |lambda: f64, n: u32| {
        let (mut bias, mut variance) = (0.0, 0.0);
        for i in 1..=n {
            let r = f64::from(i).powf(-lambda);
            bias += r * r;
            variance += r.powi(-4);
        }
        let n = f64::from(n);
        (bias / n).powi(2) + variance / (n * n)
    };
    let slope = |lambda: f64| (error(lambda, 400_000) / error(lambda, 4_000)).ln() / 100_f64.ln();
    let (eighth, twelfth) = (slope(1.0 / 8.0), slope(1.0 / 12.0));
    assert!((eighth + 0.5).abs() < 0.01, "{eighth}");
    assert!((twelfth + 1.0 / 3.0).abs() < 0.01, "{twelfth}");
    assert_eq!(optimal_exponent(4), 1.0 / 8.0);
    assert!((optimal_exponent(2) - 1.0 / 6.0).abs() < 1e-7);
}
