//! Theorem 2 of Kaplanyan 2017: consistency of a mollified Monte Carlo estimator.
//!
//! The integral is `integral of delta(x) g(x) dx` in one and two dimensions with `g = 1 - 8 |x|^2`, whose value is 1.
//! The estimator draws x uniformly on [-1, 1]^d and averages `phi_{r_n}(x) g(x) / p` with `r_n = r_0 n^-lambda`. Bias
//! is summed from the expectation of each sample (quadrature), variance and error are measured over independent runs.

use super::fit::log_slope;
use super::report::Report;
use super::search::Random;
use crate::plot::{Mark, Plot, Scale, Series};
use halflight_kernel::regularize::bandwidth::{
    is_consistent, largest_exponent, optimal_exponent, power_law,
};
use halflight_kernel::regularize::mollifier::{self, PARABOLIC};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::fmt::Write;

/// First bandwidth.
const INITIAL: f32 = 0.35;

fn g(squared: f64) -> f64 {
    1.0 - 8.0 * squared
}

/// Expectation of one mollified sample of bandwidth `r` less the answer, by Simpson's rule.
fn bias_of_one(d: u32, r: f64) -> f64 {
    let n = 32;
    let mut sum = 0.0;
    for i in 0..=n {
        let t = f64::from(i) / f64::from(n);
        let rule = match i {
            0 => 1.0,
            _ if i == n => 1.0,
            _ => f64::from(2 + 2 * (i % 2)),
        };
        let surface = if d == 1 { 2.0 } else { 2.0 * PI * t };
        let k = f64::from(mollifier::eval(PARABOLIC, d, t as f32));
        sum += rule * surface * k * g(t * t * r * r);
    }
    sum / (3.0 * f64::from(n)) - 1.0
}

struct Curve {
    bias: Vec<(f64, f64)>,
    variance: Vec<(f64, f64)>,
    error: Vec<(f64, f64)>,
}

fn measure(d: u32, lambda: f32, runs: u32, counts: &[u32]) -> Curve {
    let last = counts[counts.len() - 1];
    let radii: Vec<f32> = (1..=last).map(|n| power_law(INITIAL, n, lambda)).collect();
    let volume = 2_f64.powi(d as i32);
    let estimates: Vec<Vec<f64>> = (0..runs)
        .into_par_iter()
        .map(|run| {
            let mut random = Random(u64::from(run) * 1_000_003 + u64::from(d));
            let (mut sum, mut at) = (0.0, vec![]);
            for n in 1..=last {
                let squared: f64 = (0..d).map(|_| random.symmetric().powi(2)).sum();
                let r = radii[n as usize - 1];
                if squared < f64::from(r * r) {
                    let phi = mollifier::eval_scaled(PARABOLIC, d, squared.sqrt() as f32, r);
                    sum += f64::from(phi) * volume * g(squared);
                }
                if counts.contains(&n) {
                    at.push(sum / f64::from(n));
                }
            }
            at
        })
        .collect();
    let mut bias_sum = 0.0;
    let mut biases = vec![];
    for n in 1..=last {
        bias_sum += bias_of_one(d, f64::from(radii[n as usize - 1]));
        if counts.contains(&n) {
            biases.push(bias_sum / f64::from(n));
        }
    }
    let mut curve = Curve {
        bias: vec![],
        variance: vec![],
        error: vec![],
    };
    for (i, &n) in counts.iter().enumerate() {
        let mean = estimates.iter().map(|e| e[i]).sum::<f64>() / f64::from(runs);
        let variance =
            estimates.iter().map(|e| (e[i] - mean).powi(2)).sum::<f64>() / f64::from(runs - 1);
        let error = estimates.iter().map(|e| (e[i] - 1.0).powi(2)).sum::<f64>() / f64::from(runs);
        let n = f64::from(n);
        curve.bias.push((n, biases[i].abs()));
        curve.variance.push((n, variance));
        curve.error.push((n, error));
    }
    curve
}

/// Runs the experiment.
pub fn run(quick: bool) -> Report {
    let (runs, last) = if quick { (120, 11) } else { (1500, 15) };
    let counts: Vec<u32> = (3..=last).map(|i| 1 << i).collect();
    let tail = counts.len() / 2;
    let mut text = String::new();
    let mut plots = vec![];
    let mut figures = vec![];
    for d in [1, 2] {
        let best = optimal_exponent(d);
        let limit = largest_exponent(d);
        let lambdas = [
            0.4 * best,
            best,
            0.5 * (best + limit),
            0.9 * limit,
            1.15 * limit,
        ];
        let _ = writeln!(
            text,
            "dimension {d}: consistent for 0 < lambda < {limit:.4}, fastest at {best:.4} with N^{:.3}; {runs} runs, N to {}",
            -4.0 / (f64::from(d) + 4.0),
            counts[counts.len() - 1]
        );
        let _ = writeln!(
            text,
            "  lambda   bias slope (theory)   variance slope (theory)   error slope   error at last N   consistent"
        );
        let mut series = vec![];
        for (i, lambda) in lambdas.into_iter().enumerate() {
            let curve = measure(d, lambda, runs, &counts);
            let bias = log_slope(&curve.bias[tail..]);
            let variance = log_slope(&curve.variance[tail..]);
            let error = log_slope(&curve.error[tail..]);
            let l = f64::from(lambda);
            let bias_theory = (-2.0 * l).max(-1.0);
            let _ = writeln!(
                text,
                "  {lambda:<8.4} {bias:>9.3} ({:>6.3})     {variance:>9.3} ({:>6.3})        {error:>9.3}      {:>10.2e}       {}",
                bias_theory,
                f64::from(d) * l - 1.0,
                curve.error[curve.error.len() - 1].1,
                if is_consistent(lambda, d) {
                    "yes"
                } else {
                    "no"
                },
            );
            figures.push((format!("d{d} bias {i}"), bias - bias_theory));
            figures.push((
                format!("d{d} variance {i}"),
                variance - (f64::from(d) * l - 1.0),
            ));
            figures.push((format!("d{d} error {i}"), error));
            series.push(Series {
                label: format!("lambda {lambda:.3}"),
                mark: Mark::Line,
                colour: i,
                points: curve.error.clone(),
            });
            series.push(Series {
                label: String::new(),
                mark: Mark::Dashed,
                colour: i,
                points: curve.bias.iter().map(|&(n, b)| (n, b * b)).collect(),
            });
        }
        text.push('\n');
        plots.push(Plot {
            title: format!("Mollified delta in {d}D: squared error (bias squared dashed)"),
            axes: ["samples N".into(), "mean squared error".into()],
            scales: [Scale::Logarithmic; 2],
            series,
        });
    }
    text.push_str(
        "Bias falls as N^(-2 lambda), but never faster than 1/N, which the first samples leave; variance \
         as N^(d lambda - 1): at lambda >= 1/d the variance stays or grows (thesis equation 6.5).\n",
    );
    Report {
        text,
        plots,
        figures,
    }
}
