//! Pearson's chi-square test of a sampler of directions against its density.
//!
//! The sphere is cut into cells of polar angle and azimuth around a chosen pole, finer towards it so that peaked lobes
//! fill more than one cell. Each cell's probability is the integral of the density by adaptive quadrature in f64.
//! Samples that fail (no direction, or a discrete one) make one more cell, whose probability is what the density
//! leaves of one. Cells that expect fewer than five samples are pooled. The statistic's p-value is held against a
//! significance that is shared by all tests of a family (Sidak 1967): under correct samplers, the family as a whole
//! fails for a share [`FALSE_ALARM`] of the seeds; seeds are fixed, so a test that passes passes always.

use super::Random;
use glam::{Quat, Vec3};
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::PI;

/// Probability that a family of correct samplers fails, over random seeds.
pub const FALSE_ALARM: f64 = 1e-3;

/// Cells in polar angle.
const POLAR: usize = 20;
/// Cells in azimuth.
const AZIMUTH: usize = 20;
/// Polar angles are pi x^POWER: cells at the pole are 20^-2.5 of a half turn, 0.1 degrees, wide.
const POWER: f64 = 2.5;
/// Cells that expect less are pooled.
const SMALLEST_EXPECTED: f64 = 5.0;

/// One test of a family.
pub struct ChiSquare {
    /// Number of samples.
    pub samples: u32,
    /// Where the density peaks, roughly.
    pub pole: Vec3,
    /// Number of tests in the family.
    pub family: u32,
    /// Seed of the samples.
    pub seed: u64,
}

impl ChiSquare {
    /// The p-value, or why the sampler is rejected. `sample` returns no direction where it fails.
    pub fn run(
        &self,
        mut sample: impl FnMut(&mut Random) -> Option<Vec3>,
        pdf: impl Fn(Vec3) -> f32,
    ) -> Result<f64, String> {
        let to_pole = Quat::from_rotation_arc(Vec3::Z, self.pole.normalize());
        let n = f64::from(self.samples);
        let mut observed = vec![0.0_f64; POLAR * AZIMUTH + 1];
        let mut random = Random(self.seed);
        for _ in 0..self.samples {
            match sample(&mut random) {
                Some(w) => observed[cell_of(to_pole.inverse() * w)] += 1.0,
                None => observed[POLAR * AZIMUTH] += 1.0,
            }
        }
        let density = |theta: f64, phi: f64| {
            let (s, c) = theta.sin_cos();
            let (sp, cp) = phi.sin_cos();
            let w = Vec3::new((s * cp) as f32, (s * sp) as f32, c as f32);
            f64::from(pdf((to_pole * w).normalize())) * s
        };
        let mut expected = vec![0.0_f64; POLAR * AZIMUTH + 1];
        for i in 0..POLAR {
            for j in 0..AZIMUTH {
                let (p0, p1) = (azimuth_edge(j), azimuth_edge(j + 1));
                expected[i * AZIMUTH + j] =
                    n * integrate(&density, [polar_edge(i), polar_edge(i + 1)], [p0, p1]);
            }
        }
        let mass: f64 = expected.iter().sum::<f64>() / n;
        if mass.is_nan() || mass > 1.0 + 1e-3 {
            return Err(format!("the density integrates to {mass}"));
        }
        expected[POLAR * AZIMUTH] = n * (1.0 - mass).max(0.0);
        self.judge(&observed, &expected)
    }

    fn judge(&self, observed: &[f64], expected: &[f64]) -> Result<f64, String> {
        let mut cells: Vec<(f64, f64)> = expected
            .iter()
            .copied()
            .zip(observed.iter().copied())
            .collect();
        cells.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Samples where there is no density drown in a pooled cell: they are looked for first. Quadrature
        // errors are far below the 0.01 that a cell may expect here, and two samples on an edge are forgiven.
        let (none, stray) = cells
            .iter()
            .filter(|cell| cell.0 < 1e-2)
            .fold((0.0, 0.0), |sum, cell| (sum.0 + cell.0, sum.1 + cell.1));
        if stray > 4.0 + 4.0 * none {
            return Err(format!("{stray} samples where the density expects {none}"));
        }
        let (mut statistic, mut groups) = (0.0, 0);
        let mut pooled = (0.0, 0.0);
        for (e, o) in cells {
            pooled = (pooled.0 + e, pooled.1 + o);
            if pooled.0 >= SMALLEST_EXPECTED {
                statistic += (pooled.1 - pooled.0).powi(2) / pooled.0;
                groups += 1;
                pooled = (0.0, 0.0);
            }
        }
        if groups < 3 {
            return Err(format!("{groups} cells are too few for a test"));
        }
        let p = ChiSquared::new(f64::from(groups - 1))
            .unwrap()
            .sf(statistic);
        let significance = 1.0 - (1.0 - FALSE_ALARM).powf(1.0 / f64::from(self.family));
        if p < significance {
            return Err(format!(
                "chi-square {statistic:.1} on {} degrees of freedom: p = {p:.2e} < {significance:.2e}",
                groups - 1
            ));
        }
        Ok(p)
    }
}

fn polar_edge(i: usize) -> f64 {
    PI * (i as f64 / POLAR as f64).powf(POWER)
}

fn azimuth_edge(j: usize) -> f64 {
    2.0 * PI * j as f64 / AZIMUTH as f64
}

fn cell_of(w: Vec3) -> usize {
    // The angle from both components: acos would lose the digits near the pole, where the cells are fine.
    let theta = f64::from(w.x.hypot(w.y)).atan2(f64::from(w.z));
    let phi = f64::from(w.y).atan2(f64::from(w.x)).rem_euclid(2.0 * PI);
    let i = ((theta / PI).powf(1.0 / POWER) * POLAR as f64) as usize;
    let j = (phi / (2.0 * PI) * AZIMUTH as f64) as usize;
    i.min(POLAR - 1) * AZIMUTH + j.min(AZIMUTH - 1)
}

/// Deepest bisection of a cell.
const DEPTH: u32 = 6;

/// Integral over a rectangle by adaptive bisection of both axes, absolute error about 2e-6: a cell that
/// expects five of 1e5 samples gains 0.004 in the statistic.
fn integrate(f: &impl Fn(f64, f64) -> f64, x: [f64; 2], y: [f64; 2]) -> f64 {
    refine(f, x, y, gauss(f, x, y), 2e-6, DEPTH)
}

fn refine(
    f: &impl Fn(f64, f64) -> f64,
    x: [f64; 2],
    y: [f64; 2],
    whole: f64,
    tolerance: f64,
    depth: u32,
) -> f64 {
    let (mx, my) = (0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]));
    let quarters = [
        ([x[0], mx], [y[0], my]),
        ([mx, x[1]], [y[0], my]),
        ([x[0], mx], [my, y[1]]),
        ([mx, x[1]], [my, y[1]]),
    ];
    let values = quarters.map(|(x, y)| gauss(f, x, y));
    let sum: f64 = values.iter().sum();
    // A horizon may cut a corner off a cell that seems empty, or a narrow peak lie between the nodes: such cells are
    // looked at more closely.
    let seems_empty = sum < 2e-6 && depth + 3 > DEPTH;
    if depth == 0 || (!seems_empty && (sum - whole).abs() < tolerance) {
        return sum;
    }
    quarters
        .iter()
        .zip(values)
        .map(|((x, y), value)| refine(f, *x, *y, value, 0.5 * tolerance, depth - 1))
        .sum()
}

/// The product rule of three Gauss points per axis.
fn gauss(f: &impl Fn(f64, f64) -> f64, x: [f64; 2], y: [f64; 2]) -> f64 {
    let node = 0.6_f64.sqrt();
    let rule = [(-node, 5.0 / 9.0), (0.0, 8.0 / 9.0), (node, 5.0 / 9.0)];
    let (hx, hy) = (0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0]));
    let mut sum = 0.0;
    for (a, wa) in rule {
        for (b, wb) in rule {
            sum += wa * wb * f(x[0] + hx * (1.0 + a), y[0] + hy * (1.0 + b));
        }
    }
    sum * hx * hy
}
