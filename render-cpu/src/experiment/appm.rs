//! Chapter 5 of Kaplanyan 2017: the optimal alpha of progressive photon mapping, and radii from statistics.
//!
//! Photons fall uniformly on [-1, 1]^2 with the contribution `psi = 1 + c |x|^2`, so that the pixel's value at
//! the origin is 1/4 and its Laplacian is c. Plain progressive photon mapping is run over alpha; the adaptive method
//! with the kernel's variance and with that of equation 5.12 is compared with fixed first radii.

use super::fit::log_slope;
use super::report::Report;
use super::search::Random;
use crate::plot::{Mark, Plot, Scale, Series};
use glam::Vec2;
use halflight_kernel::regularize::mollifier::{self, PERLIN};
use halflight_kernel::transport::photon::schedule::{OPTIMAL_ALPHA, radius};
use halflight_kernel::transport::photon::statistics::{
    PhotonPass, PhotonStatistics, SQUARE_NORM, Variance, optimal_bandwidth,
};
use rayon::prelude::*;
use std::fmt::Write;

/// Laplacian of the pixel's value.
const LAPLACIAN: f32 = -0.9;
/// Photons per pass.
const EMITTED: u32 = 512;
/// The answer.
const VALUE: f64 = 0.25;

/// Number of photons of a pass in the square of half side `side`: Poisson, as for a light that emits at random times.
/// Photons outside do not matter.
fn photons_in(random: &mut Random, side: f32) -> u32 {
    let expected = f64::from(EMITTED) * f64::from(side * side);
    // The product of uniform numbers falls below exp(-expected) after a Poisson number of factors.
    let (mut left, mut count) = (-expected, 0);
    loop {
        left -= (1.0 - random.uniform()).ln();
        if left > 0.0 {
            return count;
        }
        count += 1;
    }
}

/// A photon in that square, and its contribution.
fn photon(random: &mut Random, side: f32) -> (Vec2, f32) {
    let x = Vec2::new(random.symmetric() as f32, random.symmetric() as f32) * side;
    (x, 1.0 + LAPLACIAN * x.length_squared())
}

/// Squared errors at the given numbers of passes, mean over runs, of the progressive estimate with radii `r(n)`.
fn plain(runs: u32, counts: &[u32], r: impl Fn(u32) -> f32 + Sync) -> Vec<(f64, f64)> {
    let last = counts[counts.len() - 1];
    let radii: Vec<f32> = (1..=last).map(r).collect();
    mean_errors(runs, counts, |run| {
        let mut random = Random(u64::from(run) + 17);
        let (mut sum, mut at) = (0.0, vec![]);
        for n in 1..=last {
            let r = radii[n as usize - 1];
            for _ in 0..photons_in(&mut random, r) {
                let (x, psi) = photon(&mut random, r);
                let squared = x.length_squared();
                if squared < r * r {
                    sum += f64::from(psi * mollifier::eval_scaled(PERLIN, 2, squared.sqrt(), r));
                }
            }
            if counts.contains(&n) {
                at.push(sum / f64::from(n * EMITTED));
            }
        }
        at
    })
}

/// The same of the adaptive method, with one of [`Variance`].
fn adaptive(runs: u32, counts: &[u32], kind: u32, bounds: [f32; 2]) -> Vec<(f64, f64)> {
    let last = counts[counts.len() - 1];
    mean_errors(runs, counts, |run| {
        let mut random = Random(u64::from(run) + 17);
        let mut statistics = PhotonStatistics::default();
        let (mut r, mut dr) = (bounds[1], bounds[1]);
        let mut at = vec![];
        for n in 1..=last {
            let mut pass = PhotonPass::default();
            // Twice the derivative's radius must stay within the square of photons.
            let inner = dr.min(0.5);
            let side = r.max(2.0 * inner).min(1.0);
            for _ in 0..photons_in(&mut random, side) {
                let (x, psi) = photon(&mut random, side);
                pass.add(x, psi, r, inner);
            }
            let emitted = EMITTED as f32;
            statistics.update(&pass, emitted);
            r = statistics.bandwidth(kind, emitted, bounds[0], bounds[1]);
            dr = statistics.derivative_bandwidth(bounds[0], bounds[1]);
            if counts.contains(&n) {
                at.push(f64::from(statistics.value));
            }
        }
        at
    })
}

fn mean_errors(runs: u32, counts: &[u32], run: impl Fn(u32) -> Vec<f64> + Sync) -> Vec<(f64, f64)> {
    let values: Vec<Vec<f64>> = (0..runs).into_par_iter().map(&run).collect();
    counts
        .iter()
        .enumerate()
        .map(|(i, &n)| {
            let sum: f64 = values.iter().map(|v| (v[i] - VALUE).powi(2)).sum();
            (f64::from(n), sum / f64::from(runs))
        })
        .collect()
}

fn curve(label: String, colour: usize, mark: Mark, points: Vec<(f64, f64)>) -> Series {
    Series {
        label,
        mark,
        colour,
        points,
    }
}

/// Runs the experiment.
pub fn run(quick: bool) -> Report {
    let (runs, last) = if quick { (80, 10) } else { (300, 12) };
    let counts: Vec<u32> = (2..=last).map(|i| 1 << i).collect();
    let tail = counts.len() / 2;
    let mut text = String::new();
    let mut figures = vec![];

    // The radius whose bias and variance are balanced in the first pass.
    let balanced = optimal_bandwidth(SQUARE_NORM * VALUE as f32, LAPLACIAN, EMITTED as f32);
    let first = balanced.min(0.9);
    let _ = writeln!(
        text,
        "progressive radii r_1 N^((alpha - 1)/2), r_1 = {first:.3}, {EMITTED} photons per pass, {runs} runs"
    );
    let _ = writeln!(
        text,
        "  alpha    error slope (theory)   error at N = {}",
        counts[counts.len() - 1]
    );
    let mut series = vec![];
    let mut best = (f64::MAX, 0.0_f32);
    let alphas = [0.367, 0.467, 0.567, OPTIMAL_ALPHA, 0.767, 0.867];
    for (i, alpha) in alphas.into_iter().enumerate() {
        let errors = plain(runs, &counts, |n| radius(first, n, alpha));
        let slope = log_slope(&errors[tail..]);
        let a = f64::from(alpha);
        let theory = (-a).max(2.0 * a - 2.0);
        let at_last = errors[errors.len() - 1].1;
        let _ = writeln!(
            text,
            "  {alpha:<8.3} {slope:>8.3} ({theory:>6.3})       {at_last:>10.3e}"
        );
        figures.push((format!("slope {i}"), slope));
        figures.push((format!("theory {i}"), theory));
        if at_last < best.0 {
            best = (at_last, alpha);
        }
        series.push(curve(format!("alpha {alpha:.3}"), i, Mark::Line, errors));
    }
    let reference = |points: &[(f64, f64)], power: f64| -> Vec<(f64, f64)> {
        let (n0, e0) = points[0];
        points
            .iter()
            .map(|&(n, _)| (n, e0 * (n / n0).powf(power)))
            .collect()
    };
    let guide = reference(&series[3].points, -2.0 / 3.0);
    series.push(curve("N^(-2/3)".into(), 6, Mark::Dashed, guide));
    let _ = writeln!(
        text,
        "Least error at alpha = {:.3}; the thesis has 2/3 with N^(-2/3) (equations 5.8, 5.11).\n",
        best.1
    );
    figures.push(("best alpha".into(), f64::from(best.1)));

    let _ = writeln!(
        text,
        "adaptive radii against fixed first radii with alpha = 2/3, error at N = {}:",
        counts[counts.len() - 1]
    );
    let mut compared = vec![];
    let ideal = |n: u32| {
        optimal_bandwidth(SQUARE_NORM * VALUE as f32, LAPLACIAN, (EMITTED * n) as f32).min(0.9)
    };
    let bounds = [1e-3, 0.9];
    let cases = [
        (
            "all constants known".to_string(),
            plain(runs, &counts, ideal),
        ),
        (
            "statistics, kernel variance".into(),
            adaptive(runs, &counts, Variance::KERNEL, bounds),
        ),
        (
            "statistics, equation 5.12".into(),
            adaptive(runs, &counts, Variance::MEASUREMENT, bounds),
        ),
        (
            "fixed, r_1 / 4".into(),
            plain(runs, &counts, |n| radius(first * 0.25, n, OPTIMAL_ALPHA)),
        ),
        (
            "fixed, 0.9".into(),
            plain(runs, &counts, |n| radius(0.9, n, OPTIMAL_ALPHA)),
        ),
    ];
    for (i, (name, errors)) in cases.into_iter().enumerate() {
        let at_last = errors[errors.len() - 1].1;
        let slope = log_slope(&errors[tail..]);
        let _ = writeln!(text, "  {name:<30} {at_last:>10.3e}   slope {slope:>7.3}");
        figures.push((name.clone(), at_last));
        compared.push(curve(name, i, Mark::Line, errors));
    }
    text.push_str(
        "The variance of equation 5.12 takes the number of photons in the disk as given; the kernel's variance counts it in.\n",
    );
    let plot = |title: &str, series| Plot {
        title: title.into(),
        axes: ["passes N".into(), "mean squared error".into()],
        scales: [Scale::Logarithmic; 2],
        series,
    };
    Report {
        text,
        plots: vec![
            plot("Progressive photon mapping over alpha", series),
            plot("Radii from statistics", compared),
        ],
        figures,
    }
}
