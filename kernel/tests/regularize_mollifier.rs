//! Mollifiers: mass and moments by quadrature in double precision, samplers against densities, cones on the sphere.

mod common;

use common::chi_square::ChiSquare;
use common::{Random, direction_at};
use glam::{Vec2, Vec3};
use halflight_kernel::regularize::cone;
use halflight_kernel::regularize::mollifier::{self, CONSTANT, PARABOLIC, PERLIN, QUARTIC};
use halflight_kernel::transport::photon::statistics;
use proptest::prelude::*;
use std::f64::consts::PI;

const KINDS: [u32; 4] = [CONSTANT, PARABOLIC, QUARTIC, PERLIN];

/// The kernels as the papers print them, before normalisation.
fn shape(kind: u32, t: f64) -> f64 {
    match kind {
        CONSTANT => 1.0,
        PARABOLIC => 1.0 - t * t,
        QUARTIC => (1.0 - t * t).powi(2),
        _ => 1.0 + t.powi(3) * (-6.0 * t * t + 15.0 * t - 10.0),
    }
}

/// Integral of `f(t) t^(d-1) dt` times the unit sphere's surface, Simpson's rule: exact to 1e-12 for these polynomials.
fn over_ball(dimensions: u32, f: impl Fn(f64) -> f64) -> f64 {
    let surface = [2.0, 2.0 * PI, 4.0 * PI][dimensions as usize - 1];
    let n = 2000;
    let mut sum = 0.0;
    for i in 0..=n {
        let t = f64::from(i) / f64::from(n);
        let weight = match i {
            0 => 1.0,
            _ if i == n => 1.0,
            _ if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        sum += weight * f(t) * t.powi(dimensions as i32 - 1);
    }
    surface * sum / (3.0 * f64::from(n))
}

#[test]
fn kernels_have_unit_mass_and_the_stated_moments() {
    for kind in KINDS {
        for d in 1..=3 {
            let mass = over_ball(d, |t| shape(kind, t));
            let close = |name: &str, got: f32, want: f64| {
                let error = (f64::from(got) - want).abs() / want;
                assert!(error < 6e-6, "kernel {kind}, d {d}: {name} {got} {want}");
            };
            close("constant", mollifier::normalization(kind, d), 1.0 / mass);
            for p in [0, 1, 2, 4] {
                let want = over_ball(d, |t| t.powi(p as i32) * shape(kind, t)) / mass;
                close("moment", mollifier::radial_moment(kind, d, p), want);
            }
            let second = over_ball(d, |t| t * t * shape(kind, t)) / mass / f64::from(d);
            close("per axis", mollifier::second_moment(kind, d), second);
            let square = over_ball(d, |t| shape(kind, t).powi(2)) / (mass * mass);
            close("square", mollifier::square_norm(kind, d), square);
            let scaled = over_ball(d, |t| f64::from(mollifier::eval(kind, d, t as f32)));
            // Simpson's rule meets the jump of the constant kernel at the rim.
            assert!((scaled - 1.0).abs() < 2e-3, "{kind} {d} {scaled}");
        }
    }
}

/// The fractions of the Perlin kernel. The thesis divides by the disk's area, which leaves a mass of 2/7, and gives
/// the second moment of one dimension for the disk.
#[test]
fn perlin_constants_are_those_of_the_disk() {
    let thesis_mass = over_ball(2, |t| shape(PERLIN, t)) / PI;
    assert!((thesis_mass - 2.0 / 7.0).abs() < 1e-12);
    let close = |a: f32, b: f64| assert!((f64::from(a) - b).abs() < 1e-6, "{a} {b}");
    close(mollifier::second_moment(PERLIN, 1), 5.0 / 42.0);
    close(mollifier::square_norm(PERLIN, 1), 181.0 / 231.0);
    close(mollifier::second_moment(PERLIN, 2), 5.0 / 48.0);
    close(mollifier::square_norm(PERLIN, 2), 287.0 / (132.0 * PI));
    close(statistics::SECOND_MOMENT, 5.0 / 48.0);
    close(statistics::SQUARE_NORM, 287.0 / (132.0 * PI));
}

/// Each kernel's distribution function inverts its quantiles, and both are the quadrature's.
#[test]
fn radii_are_the_quantiles_of_the_mass() {
    for kind in KINDS {
        for d in 1..=3 {
            for i in 0..=200 {
                let u = i as f32 / 200.0;
                let t = mollifier::sample_radius(kind, d, u);
                let back = mollifier::radial_cdf(kind, d, t);
                assert!((back - u).abs() < 3e-6, "{kind} {d}: {u} -> {t} -> {back}");
            }
            let half = mollifier::sample_radius(kind, d, 0.5);
            let n = 4000;
            let mut mass = 0.0;
            for i in 0..n {
                let t = (f64::from(i) + 0.5) / f64::from(n) * f64::from(half);
                let surface = [2.0, 2.0 * PI * t, 4.0 * PI * t * t][d as usize - 1];
                mass += surface * f64::from(mollifier::eval(kind, d, t as f32));
            }
            mass *= f64::from(half) / f64::from(n);
            assert!((mass - 0.5).abs() < 1e-5, "{kind} {d}: {mass}");
        }
    }
}

/// Means and second moments of samples in every dimension, within 5 standard errors: 84 numbers, false alarm 5e-5.
#[test]
fn samples_have_the_moments_of_the_kernel() {
    let n = 40_000;
    for kind in KINDS {
        let mut random = Random(u64::from(kind) + 1);
        let mut moments = [[0.0_f64; 2]; 6];
        let mut fourth = [0.0_f64; 6];
        for _ in 0..n {
            let one = mollifier::sample_1d(kind, random.next_1d());
            let two = mollifier::sample_2d(kind, random.next_2d());
            let u = random.next_2d();
            let three = mollifier::sample_3d(kind, Vec3::new(u.x, u.y, random.next_1d()));
            for (j, x) in [one, two.x, two.y, three.x, three.y, three.z]
                .into_iter()
                .enumerate()
            {
                let x = f64::from(x);
                moments[j][0] += x;
                moments[j][1] += x * x;
                fourth[j] += x.powi(4);
            }
        }
        let n = f64::from(n);
        for (j, d) in [1, 2, 2, 3, 3, 3].into_iter().enumerate() {
            let mean = moments[j][0] / n;
            let square = moments[j][1] / n;
            let want = f64::from(mollifier::second_moment(kind, d));
            let error = ((fourth[j] / n - square * square) / n).sqrt();
            assert!(mean.abs() < 5.0 * (square / n).sqrt(), "{kind} {d}: {mean}");
            assert!(
                (square - want).abs() < 5.0 * error,
                "{kind} {d}: {square} {want}"
            );
        }
    }
}

#[test]
fn cones_follow_their_density() {
    // The rim lies on the edge of a cell, where the constant kernel's jump does no harm to the quadrature.
    let caps = [2, 6, 12, 20].map(|i| {
        let half_angle = PI * (f64::from(i) / 20.0).powf(2.5);
        (2.0 * (0.5 * half_angle).sin().powi(2)) as f32
    });
    let family = (KINDS.len() * caps.len()) as u32;
    let axis = direction_at(40.0, 200.0);
    for kind in KINDS {
        for cap in caps {
            let test = ChiSquare {
                samples: 30_000,
                pole: axis,
                family,
                seed: 3,
            };
            let result = test.run(
                |random| Some(cone::sample(kind, axis, cap, random.next_2d())),
                |w| cone::eval(kind, axis, w, cap),
            );
            assert!(result.is_ok(), "kernel {kind}, cap {cap}: {result:?}");
        }
    }
}

/// The constant cone is that of the thesis and of Jendersie and Grosch, equation 15.
#[test]
fn the_constant_cone_has_the_papers_value() {
    for (r, d) in [(0.1_f64, 1.0_f64), (0.5, 0.2), (1e-3, 2.0), (3.0, 1.0)] {
        let epsilon = (r / d).atan();
        let value = 1.0 / (2.0 * PI * (1.0 - epsilon.cos()));
        let cap = cone::one_minus_cos_of_radius(r as f32, d as f32);
        let got = cone::eval(CONSTANT, Vec3::Z, Vec3::Z, cap);
        assert!((f64::from(got) / value - 1.0).abs() < 2e-6, "{got} {value}");
        let back = cone::one_minus_cos_of_tau(got);
        assert!((back / cap - 1.0).abs() < 2e-6);
        // Nothing outside.
        let outside = direction_at((epsilon.to_degrees() * 1.01) as f32, 10.0);
        assert_eq!(cone::eval(CONSTANT, Vec3::Z, outside, cap), 0.0);
    }
}

proptest! {
    /// Total for any finite input.
    #[test]
    fn evaluation_is_finite(
        kind in 0_u32..6,
        d in 0_u32..6,
        t in prop::num::f32::NORMAL | prop::num::f32::ZERO,
        r in prop::num::f32::NORMAL | prop::num::f32::ZERO,
        u in 0.0_f32..1.0,
    ) {
        prop_assert!(mollifier::eval(kind, d, t.abs()).is_finite());
        prop_assert!(mollifier::eval_scaled(kind, d, t.abs(), r).is_finite());
        prop_assert!((0.0..=1.0).contains(&mollifier::sample_radius(kind, d, u)));
        prop_assert!(cone::one_minus_cos_of_radius(r.abs(), t.abs()).is_finite());
        let cap = cone::one_minus_cos_of_tau(r);
        prop_assert!(cap > 0.0 && cap <= cone::WHOLE_SPHERE);
        let w = cone::sample(kind, Vec3::Z, cap, Vec2::new(u, 0.3));
        prop_assert!((w.length() - 1.0).abs() < 1e-5);
        prop_assert!(cone::eval(kind, Vec3::Z, w, cap).is_finite());
    }
}
