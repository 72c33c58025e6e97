//! The samplers against their definitions: uniformity, independence, and the net property of Sobol' points.
//!
//! Statistical tests use fixed seeds, so their outcome is fixed; thresholds are those of a false-alarm rate of 1e-6 per
//! test statistic for a random draw of the seed.

use halflight_kernel::sampler::{
    AnySampler, IndependentSampler, Sampler, SobolSampler, mix, sampler_kind,
};
use proptest::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Chi-square p-value of counts against the uniform distribution.
fn uniform_p_value(counts: &[u32]) -> f64 {
    let n: u32 = counts.iter().sum();
    let expected = f64::from(n) / counts.len() as f64;
    let chi2: f64 = counts
        .iter()
        .map(|c| (f64::from(*c) - expected).powi(2) / expected)
        .sum();
    1.0 - ChiSquared::new(counts.len() as f64 - 1.0)
        .unwrap()
        .cdf(chi2)
}

const FALSE_ALARM: f64 = 1e-6;

/// The number at a counter (seed, pixel, sample, dimension).
fn independent_number(c: [u32; 4]) -> f32 {
    let mut s = IndependentSampler::new(c[0], c[1], c[2]);
    for _ in 0..c[3] {
        s.next_1d();
    }
    s.next_1d()
}

#[test]
fn independent_numbers_are_uniform_in_each_coordinate_of_the_counter() {
    // Runs along one coordinate with the others fixed.
    for axis in 0..4 {
        for fixed in 0..4_u32 {
            let mut counts = [0_u32; 256];
            // Reaching a dimension takes as many steps.
            let n = if axis == 3 { 1 << 12 } else { 1 << 16 };
            for i in 0..n {
                let mut c = [fixed; 4];
                c[axis] = i;
                counts[(independent_number(c) * 256.0) as usize] += 1;
            }
            let p = uniform_p_value(&counts);
            assert!(p > FALSE_ALARM, "axis {axis}, others {fixed}: p = {p}");
        }
    }
}

#[test]
fn neighbouring_counters_fill_the_square_uniformly() {
    // Pairs (number at c, number at c + 1 along an axis) on a 16 x 16 grid: any dependence of neighbours shows.
    for axis in 0..4 {
        for stride in [1_u32, 2, 256, 1 << 16, 1 << 31] {
            if axis == 3 && stride > 2 {
                continue;
            }
            let mut counts = [0_u32; 256];
            for i in 0..1_u32 << 16 {
                let c = [i & 15, (i >> 4) & 255, (i >> 12) & 15, 2];
                let mut d = c;
                d[axis] = d[axis].wrapping_add(stride);
                let (x, y) = (independent_number(c), independent_number(d));
                counts[(x * 16.0) as usize * 16 + (y * 16.0) as usize] += 1;
            }
            let p = uniform_p_value(&counts);
            assert!(p > FALSE_ALARM, "axis {axis}, stride {stride}: p = {p}");
        }
    }
}

#[test]
fn mix_avalanches() {
    // Each input bit flips each output bit with probability 1/2: 6 standard deviations of 2^14 coin tosses.
    let n = 1_u32 << 14;
    let limit = 6.0 * (0.25 * f64::from(n)).sqrt();
    for bit in 0..32 {
        let mut flips = [0_u32; 32];
        for i in 0..n {
            let x = i.wrapping_mul(0x9e37_79b9);
            let difference = mix(x) ^ mix(x ^ (1 << bit));
            for (k, f) in flips.iter_mut().enumerate() {
                *f += (difference >> k) & 1;
            }
        }
        for (k, f) in flips.iter().enumerate() {
            // A published bias of this mixer's family is below 0.02 of a toss.
            let excess = (f64::from(*f) - 0.5 * f64::from(n)).abs();
            assert!(
                excess < limit + 0.02 * f64::from(n),
                "bit {bit} -> {k}: {f}"
            );
        }
    }
}

/// The first `n` points of a pixel in the `pair`-th two-dimensional draw.
fn sobol_points(seed: u32, pixel: u32, pair: u32, n: u32) -> Vec<[f32; 2]> {
    (0..n)
        .map(|i| {
            let mut s = SobolSampler::new(seed, pixel, i);
            for _ in 0..pair {
                s.next_2d();
            }
            s.next_2d().to_array()
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn sobol_pairs_are_nets(seed: u32, pixel: u32, pair in 0_u32..20, k in 0_u32..11) {
        let n = 1_u32 << k;
        let points = sobol_points(seed, pixel, pair, n);
        for kx in 0..=k {
            let (nx, ny) = (1_u32 << kx, 1_u32 << (k - kx));
            let mut hit = vec![false; n as usize];
            for p in &points {
                let cell = (p[0] * nx as f32) as u32 * ny + (p[1] * ny as f32) as u32;
                prop_assert!(!hit[cell as usize], "interval {}x{} cell {} hit twice", nx, ny, cell);
                hit[cell as usize] = true;
            }
        }
    }

    #[test]
    fn sobol_numbers_are_stratified(seed: u32, pixel: u32, dimension in 0_u32..20, k in 0_u32..13) {
        let n = 1_u32 << k;
        let mut hit = vec![false; n as usize];
        for i in 0..n {
            let mut s = SobolSampler::new(seed, pixel, i);
            for _ in 0..dimension {
                s.next_1d();
            }
            let cell = (s.next_1d() * n as f32) as usize;
            prop_assert!(!hit[cell]);
            hit[cell] = true;
        }
    }

    #[test]
    fn numbers_lie_below_one_and_repeat(seed: u32, pixel: u32, sample: u32, kind in 0_u32..2) {
        let mut a = AnySampler::new(kind, seed, pixel, sample);
        let mut b = AnySampler::new(kind, seed, pixel, sample);
        for _ in 0..16 {
            let (x, p) = (a.next_1d(), a.next_2d());
            for v in [x, p.x, p.y] {
                prop_assert!((0.0..1.0).contains(&v));
            }
            prop_assert_eq!(x, b.next_1d());
            prop_assert_eq!(p, b.next_2d());
        }
    }

    #[test]
    fn the_switch_draws_the_numbers_of_its_kind(seed: u32, pixel: u32, sample: u32) {
        let mut a = AnySampler::new(sampler_kind::INDEPENDENT, seed, pixel, sample);
        let mut b = IndependentSampler::new(seed, pixel, sample);
        let mut c = AnySampler::new(sampler_kind::SOBOL, seed, pixel, sample);
        let mut d = SobolSampler::new(seed, pixel, sample);
        for _ in 0..4 {
            prop_assert_eq!(a.next_1d(), b.next_1d());
            prop_assert_eq!(a.next_2d(), b.next_2d());
            prop_assert_eq!(c.next_1d(), d.next_1d());
            prop_assert_eq!(c.next_2d(), d.next_2d());
        }
    }
}

#[test]
fn sobol_numbers_are_uniform_over_pixels_and_dimensions() {
    // One sample of many pixels: scrambling alone must make it uniform, in the square too.
    for dimension in 0..4 {
        for sample in [0_u32, 1, 7] {
            let mut counts = [0_u32; 256];
            for pixel in 0..1_u32 << 16 {
                let mut s = SobolSampler::new(3, pixel, sample);
                for _ in 0..dimension {
                    s.next_2d();
                }
                let p = s.next_2d();
                counts[(p.x * 16.0) as usize * 16 + (p.y * 16.0) as usize] += 1;
            }
            let p = uniform_p_value(&counts);
            assert!(
                p > FALSE_ALARM,
                "dimension {dimension}, sample {sample}: p = {p}"
            );
        }
    }
}

#[test]
fn padded_pairs_of_a_sobol_sequence_are_uncorrelated() {
    // The same sample's numbers in different draws, over samples of one pixel and over pixels, on a 16 x 16 grid.
    for (first, second) in [(0, 1), (0, 2), (1, 3)] {
        let mut counts = [0_u32; 256];
        for i in 0..1_u32 << 16 {
            let mut s = SobolSampler::new(11, i >> 6, i & 63);
            let mut x = [0.0; 4];
            for v in &mut x {
                *v = s.next_1d();
            }
            counts[(x[first] * 16.0) as usize * 16 + (x[second] * 16.0) as usize] += 1;
        }
        let p = uniform_p_value(&counts);
        assert!(p > FALSE_ALARM, "draws {first}, {second}: p = {p}");
    }
}

/// Root mean square error of the mean of `f` over the first `n` points of 256 pixels.
fn rms_error(kind: u32, n: u32, f: impl Fn(f64, f64) -> f64, exact: f64) -> f64 {
    let mut sum = 0.0;
    for pixel in 0..256 {
        let mut mean = 0.0;
        for i in 0..n {
            let p = AnySampler::new(kind, 5, pixel, i).next_2d();
            mean += f(f64::from(p.x), f64::from(p.y)) / f64::from(n);
        }
        sum += (mean - exact).powi(2);
    }
    (sum / 256.0).sqrt()
}

#[test]
fn sobol_converges_faster_than_independent_numbers() {
    // A smooth integrand: Owen's scrambled nets converge as n^-1.5 (up to logarithms), independent numbers as n^-0.5.
    let f = |x: f64, y: f64| (-x * y).exp() * (1.0 + x);
    // Midpoint rule in one dimension of the integral over y, which has a closed form.
    let exact = (0..100_000)
        .map(|i| (f64::from(i) + 0.5) / 100_000.0)
        .map(|x| (1.0 + x) * (1.0 - (-x).exp()) / x)
        .sum::<f64>()
        / 100_000.0;
    let rate = |kind| {
        let coarse = rms_error(kind, 16, f, exact);
        let fine = rms_error(kind, 1024, f, exact);
        (coarse / fine).log2() / 6.0
    };
    let independent = rate(sampler_kind::INDEPENDENT);
    let sobol = rate(sampler_kind::SOBOL);
    assert!(
        (independent - 0.5).abs() < 0.1,
        "independent: n^-{independent}"
    );
    assert!(sobol > 1.3, "sobol: n^-{sobol}");
}
