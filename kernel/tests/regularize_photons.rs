//! Adaptive and plain progressive photon mapping: bias, variance, Laplacian and radii against simulated photons.
//!
//! The scene is a plane on which photons fall with a known density; a photon's contribution psi is known too, so that
//! the pixel's value I(x) = p(x) psi(x) and its Laplacian are.

mod common;

use common::Random;
use glam::{Vec2, Vec3};
use halflight_kernel::regularize::mollifier::{self, PERLIN};
use halflight_kernel::transport::photon::schedule::{
    OPTIMAL_ALPHA, ProgressivePixel, next_squared_radius, radius,
};
use halflight_kernel::transport::photon::statistics::{
    DERIVATIVE_CONSTANT, PhotonPass, PhotonStatistics, SECOND_MOMENT, SQUARE_NORM, Variance,
    laplacian_kernel, optimal_bandwidth,
};
use proptest::prelude::*;

/// Photons on the square [-1, 1]^2, uniform (p = 1/4), with the contribution `psi = 1 + c (x^2 + y^2)`: I = psi / 4,
/// its Laplacian c.
const C: f32 = -0.45;

fn psi(x: Vec2) -> f32 {
    1.0 + C * x.length_squared()
}

fn photon(random: &mut Random) -> Vec2 {
    2.0 * random.next_2d() - Vec2::ONE
}

/// Mean and variance of the kernel estimate at the origin with `m` photons.
fn estimate(r: f32, m: u32, runs: u32, seed: u64) -> (f64, f64) {
    let mut random = Random(seed);
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..runs {
        let mut value = 0.0_f64;
        for _ in 0..m {
            let x = photon(&mut random);
            let k = mollifier::eval_scaled(PERLIN, 2, x.length(), r);
            value += f64::from(k * psi(x));
        }
        value /= f64::from(m);
        sum += value;
        squares += value * value;
    }
    let mean = sum / f64::from(runs);
    (mean, squares / f64::from(runs) - mean * mean)
}

/// Equation 5.13 with k2 = 5/48, and the variance with k3: both within their standard errors (the bias alone would be
/// 14 % off with the thesis's k2 = 5/42).
#[test]
fn bias_and_variance_have_the_stated_constants() {
    let (m, runs, r) = (500, 8000, 0.8);
    let (mean, variance) = estimate(r, m, runs, 3);
    let bias = mean - 0.25;
    let laplacian = f64::from(C);
    let want = 0.5 * f64::from(SECOND_MOMENT) * laplacian * f64::from(r * r);
    let error = (variance / f64::from(runs)).sqrt();
    assert!((bias - want).abs() < 4.0 * error, "{bias} {want} {error}");
    assert!(
        error < 0.02 * want.abs(),
        "the simulation is too coarse: {error} {want}"
    );

    // psi is constant up to its slope within a small disk: E[psi^2] p = 1/4 there.
    let r = 0.2;
    let (_, variance) = estimate(r, m, runs, 4);
    let v = f64::from(SQUARE_NORM) * 0.25;
    let want = v / (f64::from(m) * f64::from(r * r));
    assert!((variance / want - 1.0).abs() < 0.15, "{variance} {want}");
}

/// Of the two forms of the variance, the kernel's predicts the radius of least error; equation 5.12, which takes the
/// number of photons in the disk as given, asks for a radius several times too small.
#[test]
fn the_kernel_variance_predicts_the_best_radius() {
    let m = 2000;
    let error = |r: f32| {
        let (mean, variance) = estimate(r, m, 400, 9);
        variance + (mean - 0.25).powi(2)
    };
    // Statistics gathered at the radius itself.
    let mut statistics = PhotonStatistics::default();
    let mut random = Random(12);
    for _ in 0..50 {
        let mut pass = PhotonPass::default();
        for _ in 0..m {
            let x = photon(&mut random);
            pass.add(x, psi(x), 0.3, 0.5);
        }
        statistics.update(&pass, m as f32);
    }
    let v = statistics.variance_coefficient(Variance::KERNEL);
    let best = optimal_bandwidth(v, C, m as f32);
    let measured = statistics.variance_coefficient(Variance::MEASUREMENT);
    let thesis = optimal_bandwidth(measured, C, m as f32);
    assert!(thesis < 0.5 * best, "{thesis} {best}");
    let at_best = error(best);
    for r in [0.6 * best, 1.6 * best, thesis] {
        assert!(
            error(r) > 1.2 * at_best,
            "{r}: {} against {at_best} at {best}",
            error(r)
        );
    }
}

/// The second differences of the kernel integrate a quadratic function to its Laplacian, a constant and a linear one
/// to zero.
#[test]
fn the_laplacian_kernel_has_the_moments_of_a_laplacian() {
    let r = 0.7_f32;
    let n = 600;
    let mut moments = [0.0_f64; 6];
    for i in 0..n {
        for j in 0..n {
            let node = |i: u32| 2.0 * r * (2.0 * (i as f32 + 0.5) / n as f32 - 1.0);
            let x = Vec2::new(node(i), node(j));
            let k = f64::from(laplacian_kernel(x, r)) * f64::from(16.0 * r * r) / f64::from(n * n);
            let (a, b) = (f64::from(x.x), f64::from(x.y));
            for (sum, f) in moments.iter_mut().zip([1.0, a, b, a * a, b * b, a * b]) {
                *sum += k * f;
            }
        }
    }
    for (got, want) in moments.into_iter().zip([0.0, 0.0, 0.0, 2.0, 2.0, 0.0]) {
        assert!((got - want).abs() < 2e-3, "{moments:?}");
    }
}

/// The Laplacian's estimate is consistent with its radius falling as N^(-1/8): the error over independent runs falls
/// from 20 to 320 passes. With N^(-1/4), faster than the N^(-1/6) that the thesis names as the limit, it grows.
#[test]
fn the_laplacian_estimate_is_consistent() {
    let error = |exponent: f32| {
        let mut errors = [0.0_f64; 2];
        for run in 0..60 {
            let mut random = Random(run + 100);
            let mut sum = 0.0_f64;
            for n in 1..=320 {
                let r = 0.4 * (n as f32).powf(-exponent);
                let mut pass = PhotonPass::default();
                for _ in 0..100 {
                    let x = photon(&mut random);
                    pass.add(x, psi(x), 0.1, r);
                }
                sum += f64::from(pass.laplacian_sum / 100.0);
                if n == 20 || n == 320 {
                    let e = sum / f64::from(n) - f64::from(C);
                    errors[usize::from(n == 320)] += e * e / 60.0;
                }
            }
        }
        errors
    };
    let slow = error(1.0 / 8.0);
    // Variance falls as N^(6/8 - 1): by half over a factor of 16.
    assert!(slow[1] < 0.75 * slow[0], "{slow:?}");
    let fast = error(1.0 / 4.0);
    assert!(fast[1] > fast[0], "{fast:?}");
}

/// Radii stay in their bounds, follow N^(-1/6) once the statistics have settled, and the value converges.
#[test]
fn the_adaptive_radius_settles() {
    let (least, largest, emitted) = (1e-4, 0.9, 400.0);
    let mut statistics = PhotonStatistics::default();
    let mut random = Random(77);
    let (mut r, mut dr) = (largest, largest);
    let mut at_200 = 0.0;
    for n in 1..=1600 {
        let mut pass = PhotonPass::default();
        for _ in 0..400 {
            let x = photon(&mut random);
            pass.add(x, psi(x), r, dr.min(0.45));
        }
        statistics.update(&pass, emitted);
        r = statistics.bandwidth(Variance::KERNEL, emitted, least, largest);
        dr = statistics.derivative_bandwidth(least, largest);
        let n = n as f32;
        assert!(
            r >= least * n.powf(-1.0 / 6.0) * 0.999 && r <= largest * n.powf(-1.0 / 6.0) * 1.001
        );
        assert!(dr >= least * n.powf(-0.125) * 0.999 && dr <= largest * n.powf(-0.125) * 1.001);
        if n == 200.0 {
            at_200 = r;
        }
    }
    assert!((statistics.value - 0.25).abs() < 0.01, "{statistics:?}");
    assert!((statistics.density - 0.25).abs() < 0.01);
    assert!(
        (statistics.laplacian / C - 1.0).abs() < 0.35,
        "{}",
        statistics.laplacian
    );
    // The best radius with all constants known.
    let best = optimal_bandwidth(SQUARE_NORM * 0.25, C, emitted * 1600.0);
    assert!((r / best - 1.0).abs() < 0.25, "{r} {best}");
    assert!(
        (at_200 / r / 8_f32.powf(1.0 / 6.0) - 1.0).abs() < 0.35,
        "{at_200} {r}"
    );
}

/// The printed constant is 1.2 % above 1.9397, which Silverman's rule gives in the form `(d R / (m2^2 / (2
/// pi)))^(1/8)` with m2 the trace of the second moments: no derivation that we know comes nearer.
#[test]
fn the_constant_of_the_derivative_is_not_silvermans() {
    let trace = 2.0 * f64::from(SECOND_MOMENT);
    let rule =
        (2.0 * f64::from(SQUARE_NORM) * 2.0 * std::f64::consts::PI / (trace * trace)).powf(0.125);
    assert!((rule - 1.9397).abs() < 1e-3, "{rule}");
    let excess = f64::from(DERIVATIVE_CONSTANT) / rule;
    assert!((excess - 1.0123).abs() < 1e-3, "{excess}");
}

/// The recursion 5.5 and the power law 5.6 share their limit; per-pixel statistics shrink alike under a constant
/// density.
#[test]
fn plain_radii_follow_their_power_law() {
    for alpha in [0.4_f32, OPTIMAL_ALPHA, 0.9] {
        let mut squared = 1.0_f64;
        let mut ratio = vec![];
        for n in 1..=40_000_u32 {
            if n == 10_000 || n == 40_000 {
                ratio.push(squared.sqrt() / f64::from(radius(1.0, n, alpha)));
            }
            squared = f64::from(next_squared_radius(squared as f32, n, alpha));
        }
        assert!(
            (ratio[0] / ratio[1] - 1.0).abs() < 2e-3,
            "{alpha}: {ratio:?}"
        );
    }
    assert_eq!(radius(2.0, 1, 0.5), 2.0);

    // Photons of flux 1 with density 1/4, 500 per pass: radiance tends to 1/4.
    let mut pixel = ProgressivePixel::new(0.5);
    let mut random = Random(1);
    let mut radii = vec![];
    for n in 1..=800 {
        let mut found = 0;
        for _ in 0..500 {
            if photon(&mut random).length() < pixel.radius {
                found += 1;
            }
        }
        pixel.update(found, Vec3::splat(found as f32), OPTIMAL_ALPHA);
        if n == 100 || n == 800 {
            radii.push(pixel.radius);
        }
    }
    let shrink = radii[0] / radii[1];
    assert!(
        (shrink / 8_f32.powf(1.0 / 6.0) - 1.0).abs() < 0.05,
        "{shrink}"
    );
    let radiance = pixel.radiance(500.0 * 800.0).x;
    assert!((radiance / 0.25 - 1.0).abs() < 0.03, "{radiance}");
}

proptest! {
    /// Finite statistics and radii within bounds for any finite pass.
    #[test]
    fn statistics_are_total(
        photons in 0.0_f32..1e6,
        sum in -1e6_f32..1e6,
        square in 0.0_f32..1e12,
        laplacian in -1e12_f32..1e12,
        emitted in 0.0_f32..1e9,
        least in 0.0_f32..1.0,
    ) {
        let pass = PhotonPass {
            photons,
            sum,
            square_sum: square,
            kernel_sum: photons,
            value_sum: sum,
            laplacian_sum: laplacian,
        };
        let mut s = PhotonStatistics::default();
        for _ in 0..3 {
            s.update(&pass, emitted);
        }
        for kind in [Variance::KERNEL, Variance::MEASUREMENT] {
            let r = s.bandwidth(kind, emitted, least, 2.0);
            prop_assert!(r.is_finite() && (0.0..=2.0).contains(&r));
        }
        let r = s.derivative_bandwidth(least, 2.0);
        prop_assert!(r.is_finite() && (0.0..=2.0).contains(&r));
    }
}
