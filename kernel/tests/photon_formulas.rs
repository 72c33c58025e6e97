//! The formulas of photon statistics against truths that do not come from them: quadrature and search in double precision,
//! statistics made by hand, and simulated photons.

mod common;

use common::Random;
use glam::{Vec2, Vec3};
use halflight_kernel::regularize::mollifier::{self, PERLIN};
use halflight_kernel::transport::photon::schedule::ProgressivePixel;
use halflight_kernel::transport::photon::statistics::{
    PhotonPass, PhotonStatistics, RUNNING_MEAN, SECOND_MOMENT, SQUARE_NORM, Variance,
    optimal_bandwidth,
};

/// Perlin's kernel on the disk as the thesis prints its shape, of mass one: 7 / (2 pi) (1 - 10 t^3 + 15 t^4 - 6 t^5).
fn kernel(t: f64) -> f64 {
    if t >= 1.0 {
        return 0.0;
    }
    let shape = 1.0 - 10.0 * t.powi(3) + 15.0 * t.powi(4) - 6.0 * t.powi(5);
    3.5 / std::f64::consts::PI * shape
}

/// The integral of f(t) over the unit disk.
fn over_disk(f: impl Fn(f64) -> f64) -> f64 {
    let n = 20_000;
    let ring = |i: u32| {
        let t = (f64::from(i) + 0.5) / f64::from(n);
        2.0 * std::f64::consts::PI * t * f(t) / f64::from(n)
    };
    (0..n).map(ring).sum()
}

#[test]
fn constants_are_integrals_of_the_kernel() {
    assert!((over_disk(kernel) - 1.0).abs() < 1e-6);
    let per_axis = over_disk(|t| kernel(t) * t * t) / 2.0;
    assert!((f64::from(SECOND_MOMENT) - per_axis).abs() < 1e-6 * per_axis);
    let squares = over_disk(|t| kernel(t).powi(2));
    assert!((f64::from(SQUARE_NORM) - squares).abs() < 1e-6 * squares);
}

/// The radius of the least error, found by search.
fn searched(v: f64, laplacian: f64, m: f64) -> f64 {
    let bias = |r: f64| 0.5 * over_disk(|t| kernel(t) * t * t) / 2.0 * laplacian * r * r;
    let error = |r: f64| v / (m * r * r) + bias(r).powi(2);
    let (mut low, mut high) = (1e-4_f64.ln(), 1e2_f64.ln());
    for _ in 0..60 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if error(a.exp()) < error(b.exp()) {
            high = b;
        } else {
            low = a;
        }
    }
    (0.5 * (low + high)).exp()
}

#[test]
fn the_best_radius_is_that_of_a_search() {
    for (v, laplacian, m) in [(0.17, -0.45, 500.0), (3.0, 20.0, 1e5), (0.02, 1.0, 64.0)] {
        let found = optimal_bandwidth(v as f32, laplacian as f32, m as f32);
        let expected = searched(v, laplacian, m);
        assert!(
            (f64::from(found) / expected - 1.0).abs() < 2e-3,
            "{found} {expected}"
        );
    }
}

/// Statistics by hand, of 64 passes.
fn by_hand(square: f32, laplacian: f32, deviation: f32) -> PhotonStatistics {
    PhotonStatistics {
        passes: 64.0,
        photons: 1000.0,
        mean: 0.5,
        square,
        laplacian,
        laplacian_square: laplacian * laplacian + deviation * deviation,
        density: 0.25,
        value: 0.125,
    }
}

/// Bounds fall as N^(-1/6), half of the first after 64 passes, where the statistics know nothing; between them the radius is
/// 3^(-1/6) of that of least error of one pass with all photons.
#[test]
fn bandwidths_are_those_of_their_statistics() {
    let flat = by_hand(0.3, 0.0, 0.0);
    let r = flat.bandwidth(Variance::KERNEL, 100.0, 1e-3, 0.8);
    assert!((r - 0.4).abs() < 1e-6, "{r}");
    let dark = by_hand(0.0, 1e6, 0.0);
    let r = dark.bandwidth(Variance::KERNEL, 100.0, 1e-3, 0.8);
    assert!((r - 5e-4).abs() < 1e-9, "{r}");
    let inside = by_hand(0.3, 2.0, 0.0);
    // The kernel estimate has the square of psi, equation 5.12 its variance, 0.3 - 0.5^2.
    for (kind, v) in [
        (
            Variance::KERNEL,
            over_disk(|t| kernel(t).powi(2)) * 0.25 * 0.3,
        ),
        (Variance::MEASUREMENT, 0.25 * 0.05 / std::f64::consts::PI),
    ] {
        let expected = 0.832_683 * searched(v, 2.0, 6400.0);
        let r = inside.bandwidth(kind, 100.0, 1e-3, 10.0);
        assert!(
            (f64::from(r) / expected - 1.0).abs() < 2e-3,
            "{kind}: {r} {expected}"
        );
    }
}

/// Equation 5.18 where its bounds do not act: 1.9635 deviations times N^(-1/8).
#[test]
fn the_derivatives_bandwidth_is_the_printed_one() {
    let statistics = by_hand(0.3, 2.0, 0.25);
    let expected = 1.9635 * 0.25 * 64_f32.powf(-1.0 / 8.0);
    let r = statistics.derivative_bandwidth(1e-3, 10.0);
    assert!((r / expected - 1.0).abs() < 1e-4, "{r} {expected}");
}

/// The normal fit finds the deviation of a Gaussian bump: 0.125 at its top with the Laplacian -2 I / s^2, s = 0.3. Where nothing
/// bends, and where nothing is known, it is the largest radius.
#[test]
fn the_normal_fit_finds_the_width_of_a_bump() {
    let bump = by_hand(0.3, -2.0 * 0.125 / 0.09, 0.0);
    // Silverman's constant for second derivatives, with quadrature's moments.
    let per_axis = over_disk(|t| kernel(t) * t * t) / 2.0;
    let squares = over_disk(|t| kernel(t).powi(2));
    let constant = (2.0 * squares * 2.0 * std::f64::consts::PI / (per_axis * per_axis)).powf(0.125);
    let expected = constant * 0.3 * 64_f64.powf(-0.125);
    let r = bump.curvature_bandwidth(1e-3, 10.0);
    assert!(
        (f64::from(r) / expected - 1.0).abs() < 1e-3,
        "{r} {expected}"
    );
    let largest = 0.7 * 64_f32.powf(-0.125);
    let flat = by_hand(0.3, 0.0, 0.0).curvature_bandwidth(1e-3, 0.7);
    assert!((flat / largest - 1.0).abs() < 1e-6);
    assert_eq!(
        PhotonStatistics::default().curvature_bandwidth(1e-3, 0.7),
        0.7
    );
}

/// Noise is not taken for curvature: 64 values of deviation 4 around a Laplacian of 1 have a mean of variance 16 / 63.
#[test]
fn curvature_stands_out_from_its_noise() {
    let found = by_hand(0.3, 1.0, 4.0).significant_laplacian();
    assert!(
        (found - (1.0_f32 - 16.0 / 63.0).sqrt()).abs() < 1e-5,
        "{found}"
    );
    assert_eq!(by_hand(0.3, 0.1, 4.0).significant_laplacian(), 0.0);
}

/// The variance of the kernel estimate by quadrature, against what statistics of photons say of it.
#[test]
fn the_variance_is_that_of_quadrature() {
    let (r, photons) = (0.35_f32, 400_000);
    // Photons of density 1/4 with the contribution 1 - 0.45 x^2.
    let psi = |x: f64| 1.0 - 0.45 * x * x;
    let square = over_disk(|t| (kernel(t) * psi(t * f64::from(r))).powi(2)) / 4.0;
    let mean = over_disk(|t| kernel(t) * psi(t * f64::from(r))) / 4.0;
    let variance = square / f64::from(r * r) - mean * mean;

    let mut random = Random(5);
    let mut pass = PhotonPass::default();
    for _ in 0..photons {
        let x = 2.0 * random.next_2d() - Vec2::ONE;
        pass.add(x, psi(f64::from(x.length())) as f32, r, 0.4);
    }
    let mut statistics = PhotonStatistics::default();
    statistics.update(&pass, photons as f32);
    let v = f64::from(statistics.variance_coefficient(Variance::KERNEL));
    let found = v / f64::from(r * r);
    // What is left is the square of the mean, and the slope of psi within the disk.
    assert!((found / variance - 1.0).abs() < 0.05, "{found} {variance}");
}

/// The first pass of per-pixel statistics loses no light: its radiance is its flux over the disk that it was found in.
#[test]
fn one_pass_of_progressive_statistics_keeps_its_light() {
    for (found, alpha) in [(7, 2.0 / 3.0), (1, 0.3), (5000, 0.9)] {
        let mut pixel = ProgressivePixel::new(0.3);
        let flux = Vec3::new(2.0, 3.0, 5.0);
        pixel.update(found, flux, alpha);
        let expected = flux / (std::f32::consts::PI * 0.3 * 0.3 * 1000.0);
        assert!(
            (pixel.radiance(1000.0) / expected - Vec3::ONE)
                .abs()
                .max_element()
                < 1e-5
        );
        assert!(pixel.radius < 0.3);
    }
}

/// Bias and variance of the mean over passes with radii r_1 i^(-1/6) and the constants of `searched`, summed up.
fn error_of_mean(factor: f64, passes: u32) -> f64 {
    let (v, laplacian, m) = (0.17, -0.45, 500.0);
    let half_moment: f64 = 0.5 * 5.0 / 48.0;
    let (mut bias, mut variance) = (0.0, 0.0);
    for i in 1..=passes {
        let i = f64::from(i);
        // What one pass of all photons so far would take.
        let r = factor * (v / (2.0 * m * i * (half_moment * laplacian).powi(2))).powf(1.0 / 6.0);
        bias += half_moment * laplacian * r * r;
        variance += v / (m * r * r);
    }
    let n = f64::from(passes);
    (bias / n).powi(2) + variance / (n * n)
}

/// 3^(-1/6) of the radius of least error of a single pass is that of the running mean, whose error it lowers by 13.5 % (the other is 15.6 % above).
#[test]
fn the_running_mean_wants_smaller_radii() {
    let n = 100_000;
    let best = error_of_mean(f64::from(RUNNING_MEAN), n);
    for factor in [0.78, 0.81, 0.86, 0.9, 1.0] {
        assert!(error_of_mean(factor, n) > best, "{factor}");
    }
    let gain = 1.0 - best / error_of_mean(1.0, n);
    assert!((gain - 0.1346).abs() < 0.002, "{gain}");
    assert!((f64::from(RUNNING_MEAN) - 3_f64.powf(-1.0 / 6.0)).abs() < 1e-6);
}

/// The same by simulated photons.
#[test]
fn simulated_photons_agree_about_the_running_mean() {
    let (m, passes, runs) = (300, 40, 1500);
    let v = SQUARE_NORM * 0.25;
    let (laplacian, value) = (-0.9, 0.25);
    let error = |factor: f32| {
        let mut sum = 0.0;
        for run in 0..runs {
            let mut random = Random(1000 + run);
            let mut mean = 0.0;
            for i in 1..=passes {
                let r = factor * optimal_bandwidth(v, laplacian, (m * i) as f32);
                // Photons in the square around the disk, as many as fall there.
                let side = r.min(1.0);
                let mut of_pass = 0.0;
                for _ in 0..m {
                    if random.next_2d().x > side * side {
                        continue;
                    }
                    let x = (2.0 * random.next_2d() - Vec2::ONE) * side;
                    let psi = 1.0 + laplacian * x.length_squared();
                    of_pass += psi * mollifier::eval_scaled(PERLIN, 2, x.length(), r);
                }
                mean += f64::from(of_pass / m as f32) / f64::from(passes);
            }
            sum += (mean - value).powi(2) / f64::from(runs as u32);
        }
        sum
    };
    let (small, large) = (error(RUNNING_MEAN), error(1.0));
    assert!(small < 0.93 * large, "{small} {large}");
}
