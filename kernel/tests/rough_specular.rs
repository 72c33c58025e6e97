//! Rough conductors and dielectrics: Jacobians, reciprocity, sampling, energy.

mod common;

use common::lobes::specular;
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::microfacet::visible_normal_pdf;
use halflight_kernel::bsdf::{
    BsdfSample, Lobe, dielectric, event, fresnel, mode, model, rough_conductor, rough_dielectric,
};
use halflight_kernel::sampler::{IndependentSampler, Sampler};
use halflight_kernel::scene::{distribution, lobe_flag, lobe_kind};
use proptest::prelude::*;

fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Vec3 {
    if lobe.kind == lobe_kind::ROUGH_CONDUCTOR {
        rough_conductor::eval(lobe, wi, wo)
    } else {
        rough_dielectric::eval(lobe, wi, wo)
    }
}

fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    if lobe.kind == lobe_kind::ROUGH_CONDUCTOR {
        rough_conductor::pdf(lobe, wi, wo)
    } else {
        rough_dielectric::pdf(lobe, wi, wo)
    }
}

fn sample(lobe: &Lobe, wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    model::sample(lobe, &[], wi, u1, u2)
}

fn direction(z: f32, phi: f32) -> Vec3 {
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * phi.cos(), r * phi.sin(), z)
}

const ROUGH: [u32; 2] = [lobe_kind::ROUGH_CONDUCTOR, lobe_kind::ROUGH_DIELECTRIC];
const DISTRIBUTIONS: [u32; 2] = [distribution::BECKMANN, distribution::GGX];

/// Vectors in f64, for finite differences.
type Vector = [f64; 3];

fn combine(a: Vector, s: f64, b: Vector) -> Vector {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn length(a: Vector) -> f64 {
    (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()
}

fn unit(a: Vector) -> Vector {
    let l = length(a);
    [a[0] / l, a[1] / l, a[2] / l]
}

fn to_f64(a: Vec3) -> Vector {
    unit([f64::from(a.x), f64::from(a.y), f64::from(a.z)])
}

fn to_f32(a: Vector) -> Vec3 {
    Vec3::new(a[0] as f32, a[1] as f32, a[2] as f32)
}

/// Half vector in the upper hemisphere, as a function of `wo`.
fn half(wi: Vector, wo: Vector, eta: f64) -> Vector {
    let h = unit(combine(wi, eta, wo));
    if h[2] < 0.0 {
        combine([0.0; 3], -1.0, h)
    } else {
        h
    }
}

/// Solid angle of half vectors per solid angle of `wo` by central differences.
fn jacobian(wi: Vector, wo: Vector, eta: f64) -> f64 {
    let s = unit(cross(
        wo,
        if wo[0].abs() < 0.5 {
            [1.0, 0.0, 0.0]
        } else {
            [0.0, 1.0, 0.0]
        },
    ));
    let t = cross(wo, s);
    let step = 1e-5;
    let d = |v: Vector| {
        let ahead = half(wi, unit(combine(wo, step, v)), eta);
        let behind = half(wi, unit(combine(wo, -step, v)), eta);
        combine(ahead, -1.0, behind)
    };
    length(cross(d(s), d(t))) / (4.0 * step * step)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 4096,
        rng_seed: proptest::test_runner::RngSeed::Fixed(2),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn densities_hold_the_jacobian(
        zi in 0.05_f32..0.99,
        below: bool,
        zo in -0.99_f32..0.99,
        phi in 0.0_f32..core::f32::consts::TAU,
        eta in prop_oneof![0.4_f32..0.8, 1.2_f32..2.5],
    ) {
        // pdf / (probability of the event * density of the normal) is the Jacobian of the half vector.
        let wi = direction(if below { -zi } else { zi }, 0.7);
        let wo = direction(zo, phi);
        let reflection = wi.z * wo.z > 0.0;
        let l = specular(lobe_kind::ROUGH_DIELECTRIC, distribution::GGX, Vec2::splat(0.8), eta);
        let p = f64::from(pdf(&l, wi, wo));
        if p < 1e-4 {
            return Ok(());
        }
        let e = if reflection { 1.0 } else { f64::from(fresnel::relative_eta(wi.z, eta)) };
        let (di, d_o) = (to_f64(wi), to_f64(wo));
        let m = to_f32(half(di, d_o, e));
        let f = f64::from(fresnel::fresnel_dielectric(wi.dot(m), eta).0);
        let probability = if reflection { f } else { 1.0 - f };
        let up = if wi.z < 0.0 { -wi } else { wi };
        let up_normal = f64::from(visible_normal_pdf(l.distribution, l.alpha, up, m));
        // Beside the critical angle and grazing microfacets the rounding of cosines shows.
        if probability < 1e-3 || wi.dot(m).abs() < 0.1 || wo.dot(m).abs() < 0.1 {
            return Ok(());
        }
        if m.z < 1e-3 {
            return Ok(()); // on the horizon, where the half vector turns over between the differences' ends
        }
        let want = jacobian(di, d_o, e);
        let got = p / (probability * up_normal);
        prop_assert!((got / want - 1.0).abs() < 1e-3, "{} {}", got, want);
    }

    #[test]
    fn values_are_reciprocal(
        zi in -0.99_f32..0.99,
        zo in -0.99_f32..0.99,
        phi in 0.0_f32..core::f32::consts::TAU,
        eta in prop_oneof![0.4_f32..0.95, 1.05_f32..2.5],
        ax in 0.1_f32..1.0,
        ay in 0.1_f32..1.0,
        d in 0_u32..2,
    ) {
        let (wi, wo) = (direction(zi, 0.7), direction(zo, phi));
        for kind in ROUGH {
            let mut l = specular(kind, d, Vec2::new(ax, ay), eta);
            let (f, g) = (f64::from(eval(&l, wi, wo).x), f64::from(eval(&l, wo, wi).x));
            // f(wi, wo) / n_i^2 = f(wo, wi) / n_o^2 for radiance.
            let e = if zi * zo > 0.0 { 1.0 } else { f64::from(fresnel::relative_eta(wi.z, eta)) };
            let size = f.max(1e-4);
            prop_assert!((f - g / (e * e)).abs() < 2e-3 * size, "{} {} {}", kind, f, g / (e * e));
            // Importance is the adjoint of radiance.
            l.mode = mode::IMPORTANCE;
            let adjoint = f64::from(eval(&l, wo, wi).x);
            prop_assert!((f - adjoint).abs() < 2e-3 * size, "{} {} {}", kind, f, adjoint);
        }
    }

    #[test]
    fn samples_are_consistent(
        z in -1.0_f32..=1.0,
        phi in 0.0_f32..core::f32::consts::TAU,
        eta in prop_oneof![0.4_f32..0.9, 1.1_f32..2.5],
        ax in 0.05_f32..1.0,
        ay in 0.05_f32..1.0,
        d in 0_u32..2,
        all: bool,
        importance: bool,
        u1 in 0.0_f32..1.0,
        u in 0.0_f32..1.0,
        v in 0.0_f32..0.999,
    ) {
        let wi = direction(z, phi);
        for kind in ROUGH {
            let mut l = specular(kind, d, Vec2::new(ax, ay), eta);
            if all {
                l.flags |= lobe_flag::SAMPLE_ALL_NORMALS;
            }
            l.mode = if importance { mode::IMPORTANCE } else { mode::RADIANCE };
            let s = sample(&l, wi, u1, Vec2::new(u, v));
            if s.pdf == 0.0 {
                continue;
            }
            prop_assert!((s.wo.length() - 1.0).abs() < 1e-5);
            // Beside grazing angles the rounding of directions dominates both.
            if s.wo.z.abs() < 0.02 || wi.z.abs() < 0.02 {
                continue;
            }
            let p = pdf(&l, wi, s.wo);
            prop_assert!((p / s.pdf - 1.0).abs() < 5e-3, "{} {} {}", kind, p, s.pdf);
            let f = eval(&l, wi, s.wo) * s.wo.z.abs() / p;
            prop_assert!((f.x / s.weight.x - 1.0).abs() < 2e-3, "{} {} {}", kind, f, s.weight);
            let same_side = s.wo.z * wi.z > 0.0;
            let (bit, e) = if same_side { (event::REFLECTION, 1.0) } else { (event::TRANSMISSION, fresnel::relative_eta(z, eta)) };
            prop_assert_eq!(s.event, event::GLOSSY | bit);
            prop_assert_eq!(s.eta, e);
        }
    }
}

/// Adaptive integral of `f(wo)` over `z` in (z0, z1), `phi` in (p0, p1), three-point Gauss rule.
fn integrate(f: &impl Fn(Vec3) -> f64, z: [f64; 2], p: [f64; 2], depth: u32) -> f64 {
    let rule = |z: [f64; 2], p: [f64; 2]| {
        let node = (0.6_f64).sqrt();
        let mut sum = 0.0;
        for (x, wx) in [(-node, 5.0), (0.0, 8.0), (node, 5.0)] {
            for (y, wy) in [(-node, 5.0), (0.0, 8.0), (node, 5.0)] {
                let cz = 0.5 * (z[0] + z[1] + x * (z[1] - z[0]));
                let cp = 0.5 * (p[0] + p[1] + y * (p[1] - p[0]));
                let r = (1.0 - cz * cz).sqrt();
                let w = to_f32([r * cp.cos(), r * cp.sin(), cz]);
                sum += wx * wy * f(w);
            }
        }
        sum * (z[1] - z[0]) * (p[1] - p[0]) / 324.0
    };
    let whole = rule(z, p);
    let (zm, pm) = (0.5 * (z[0] + z[1]), 0.5 * (p[0] + p[1]));
    let quarters = [
        ([z[0], zm], [p[0], pm]),
        ([z[0], zm], [pm, p[1]]),
        ([zm, z[1]], [p[0], pm]),
        ([zm, z[1]], [pm, p[1]]),
    ];
    let parts: f64 = quarters.iter().map(|(z, p)| rule(*z, *p)).sum();
    if depth == 0 || (parts - whole).abs() < 1e-7 + 1e-4 * parts.abs() {
        return parts;
    }
    quarters
        .iter()
        .map(|(z, p)| integrate(f, *z, *p, depth - 1))
        .sum()
}

/// The cells of the sphere for histograms: equal in z and in azimuth.
const ROWS: usize = 24;
const COLUMNS: usize = 24;

fn cell_bounds(i: usize, j: usize) -> ([f64; 2], [f64; 2]) {
    let z = |i: usize| -1.0 + 2.0 * i as f64 / ROWS as f64;
    let p = |j: usize| core::f64::consts::TAU * j as f64 / COLUMNS as f64;
    ([z(i), z(i + 1)], [p(j), p(j + 1)])
}

/// Per lobe and direction; 64 are tested.
const FALSE_ALARM: f64 = 1e-5;

#[test]
fn rough_samples_follow_their_density_and_conserve_energy() {
    use statrs::distribution::{ChiSquared, ContinuousCDF};
    const N: u32 = 60_000;
    for kind in ROUGH {
        for d in DISTRIBUTIONS {
            for alpha in [Vec2::new(0.2, 0.2), Vec2::new(0.25, 0.8)] {
                for z in [0.9_f32, 0.3, -0.05, -0.8] {
                    for all in [false, true] {
                        let mut l = specular(kind, d, alpha, 1.5);
                        l.mode = mode::IMPORTANCE;
                        l.flags |= if all {
                            lobe_flag::SAMPLE_ALL_NORMALS
                        } else {
                            0
                        };
                        let conductor = kind == lobe_kind::ROUGH_CONDUCTOR;
                        let wi = direction(if conductor { z.abs() } else { z }, 1.1);
                        let name = format!("{kind} {d} {alpha} {wi} {all}");

                        let mut counts = vec![0_u32; ROWS * COLUMNS];
                        let (mut none, mut sum, mut sum2) = (0_u32, 0.0, 0.0);
                        for i in 0..N {
                            let mut rng = IndependentSampler::new(3, 9, i);
                            let s = sample(&l, wi, rng.next_1d(), rng.next_2d());
                            if s.pdf == 0.0 {
                                none += 1;
                                continue;
                            }
                            let weight = f64::from(s.weight.x);
                            sum += weight;
                            sum2 += weight * weight;
                            let row = ((s.wo.z + 1.0) * 0.5 * ROWS as f32) as usize;
                            let turn = s.wo.y.atan2(s.wo.x) / core::f32::consts::TAU;
                            let column = ((turn - turn.floor()) * COLUMNS as f32) as usize;
                            counts[row.min(ROWS - 1) * COLUMNS + column.min(COLUMNS - 1)] += 1;
                        }

                        let (mut chi2, mut cells, mut total, mut albedo) = (0.0, 0, 0.0, 0.0);
                        let (mut rest, mut rest_count) = (0.0, 0.0);
                        for i in 0..ROWS {
                            for j in 0..COLUMNS {
                                let (zs, ps) = cell_bounds(i, j);
                                let p = integrate(&|w| f64::from(pdf(&l, wi, w)), zs, ps, 6);
                                albedo += integrate(
                                    &|w| f64::from(eval(&l, wi, w).x * w.z.abs()),
                                    zs,
                                    ps,
                                    6,
                                );
                                total += p;
                                let e = p * f64::from(N);
                                let c = f64::from(counts[i * COLUMNS + j]);
                                if e < 10.0 {
                                    rest += e;
                                    rest_count += c;
                                } else {
                                    chi2 += (c - e).powi(2) / e;
                                    cells += 1;
                                }
                            }
                        }
                        // What the density lacks is where no direction comes out.
                        assert!(total < 1.001, "{name}: density integrates to {total}");
                        for (e, c) in [
                            (rest, rest_count),
                            ((1.0 - total) * f64::from(N), f64::from(none)),
                        ] {
                            if e > 10.0 {
                                chi2 += (c - e).powi(2) / e;
                                cells += 1;
                            } else {
                                assert!(c < 100.0, "{name}: {c} drawn, {e} due");
                            }
                        }
                        let p = 1.0 - ChiSquared::new(f64::from(cells) - 1.0).unwrap().cdf(chi2);
                        assert!(
                            p > FALSE_ALARM,
                            "{name}: p = {p}, chi2 {chi2}, {cells} cells"
                        );

                        // White furnace: single scattering never gains; the mean weight is the integral of f cos.
                        assert!(albedo < 1.0 + 1e-3, "{name}: albedo {albedo}");
                        let n = f64::from(N);
                        let mean = sum / n;
                        let deviation = ((sum2 / n - mean * mean) / n).sqrt();
                        assert!(
                            (mean - albedo).abs() < 4.5 * deviation + 1e-3,
                            "{name}: mean {mean} +- {deviation}, albedo {albedo}"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn nearly_smooth_dielectric_loses_nothing() {
    // alpha -> 0: reflection and refraction keep all energy and the smooth directions.
    for d in DISTRIBUTIONS {
        for z in [0.9_f32, 0.3, -0.8] {
            let l = Lobe {
                mode: mode::IMPORTANCE,
                ..specular(lobe_kind::ROUGH_DIELECTRIC, d, Vec2::splat(1e-4), 1.5)
            };
            let smooth = Lobe {
                kind: lobe_kind::DIELECTRIC,
                ..l
            };
            let wi = direction(z, 0.2);
            for i in 0..1000 {
                let mut rng = IndependentSampler::new(1, 1, i);
                let u1 = rng.next_1d();
                let s = sample(&l, wi, u1, rng.next_2d());
                let want = dielectric::sample(&smooth, wi, u1, Vec2::ZERO);
                if (s.event ^ want.event) & event::REFLECTION != 0 {
                    continue; // u1 beside the reflectance
                }
                assert!(s.weight.x > 0.999);
                // Slopes of 1e-4, with GGX's tail.
                assert!(s.wo.distance(want.wo) < 0.05, "{s:?} {want:?}");
            }
        }
    }
}
