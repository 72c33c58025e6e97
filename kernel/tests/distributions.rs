//! The distributions of normals beyond Beckmann and GGX: Gamma quantiles, projected areas against quadrature, sampling,
//! derivatives and slope densities of all kinds.

mod common;

use common::chi_square::ChiSquare;
use common::direction_at;
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::microfacet::exponential_power::{AREA_ERROR, projected_area};
use halflight_kernel::bsdf::microfacet::{Microfacets, v_cavity};
use halflight_kernel::math::float::{gamma_1p, inverse_gamma_distribution};
use halflight_kernel::scene::distribution as kinds;
use statrs::distribution::{ContinuousCDF, Gamma};

/// Every kind, with several exponents of the last.
const MODELS: [(u32, f32); 6] = [
    (kinds::BECKMANN, 1.0),
    (kinds::GGX, 1.0),
    (kinds::PHONG, 1.0),
    (kinds::EXPONENTIAL_POWER, 0.3),
    (kinds::EXPONENTIAL_POWER, 1.0),
    (kinds::EXPONENTIAL_POWER, 4.0),
];

#[test]
fn gamma_function_is_exact() {
    for i in 0..=1000 {
        let x = i as f32 * 0.01;
        let want = statrs::function::gamma::gamma(1.0 + f64::from(x));
        let error = (f64::from(gamma_1p(x)) / want - 1.0).abs();
        assert!(error < 1.5e-6, "{x}: {error}");
    }
}

#[test]
fn gamma_quantiles_are_exact() {
    for i in 0..=48 {
        let shape = 0.2 + 0.1 * i as f32;
        let exact = Gamma::new(f64::from(shape), 1.0).expect("positive parameters");
        for j in 0..1000 {
            let u = (j as f32 + 0.5) / 1000.0;
            let power = inverse_gamma_distribution(shape, u);
            // In the power, whose cumulative distribution is smooth at zero.
            let x = f64::from(power).powf(1.0 / f64::from(shape));
            let got = exact.cdf(x);
            assert!((got - f64::from(u)).abs() < 3e-6, "{shape} {u}: {got}");
        }
        for tail in [1e-3_f32, 1e-5, 1e-6] {
            let x = f64::from(inverse_gamma_distribution(shape, 1.0 - tail))
                .powf(1.0 / f64::from(shape));
            let want = 1.0 - f64::from(1.0 - tail);
            assert!(
                (exact.sf(x) / want - 1.0).abs() < 1e-3,
                "{shape} {tail}: {}",
                exact.sf(x)
            );
        }
    }
}

/// Mean over the slopes of an exponential power distribution of unit width of the area turned towards a direction of
/// unit sine and cosine `a`: one-dimensional quadrature in f64 over the radius, the azimuth in closed form.
fn area_by_quadrature(a: f64, p: f64) -> f64 {
    let norm = 2.0 * p / statrs::function::gamma::gamma(1.0 / p);
    // s = e^v; exp(-60) ends the tail.
    let (low, high) = (-16.0_f64, (60.0_f64).ln() / (2.0 * p));
    let n = 20_000;
    let step = (high - low) / f64::from(n);
    let mut sum = 0.0;
    for i in 0..=n {
        let s = (low + step * f64::from(i)).exp();
        let density = norm * s * (-s.powf(2.0 * p)).exp();
        let masked = if s > a {
            ((s * s - a * a).sqrt() - a * (a / s).acos()) / core::f64::consts::PI
        } else {
            0.0
        };
        sum += density * masked * s * step;
    }
    a + sum
}

#[test]
fn exponential_power_area_is_smiths() {
    let mut worst = 0.0_f64;
    for p in [0.2_f32, 0.25, 0.4, 0.7, 1.0, 1.5, 2.2, 3.0, 4.2, 5.0] {
        for i in 0..40 {
            let a = (0.15 * i as f32).exp() * 0.01 - 0.01;
            let got = f64::from(projected_area(a, 1.0, p));
            worst = worst.max((got / area_by_quadrature(f64::from(a), f64::from(p)) - 1.0).abs());
        }
    }
    assert!(worst < f64::from(AREA_ERROR), "{worst}");
}

#[test]
fn exponential_power_of_one_is_beckmann() {
    let alpha = Vec2::new(0.3, 0.1);
    let power = Microfacets::new(kinds::EXPONENTIAL_POWER, alpha, 1.0);
    let beckmann = Microfacets::new(kinds::BECKMANN, alpha, 1.0);
    for i in 0..90 {
        let w = direction_at(i as f32, 37.0 * i as f32);
        let (d, want) = (power.distribution(w), beckmann.distribution(w));
        assert!((d - want).abs() <= 2e-5 * want + 1e-30, "{w}: {d} {want}");
        let (a, want) = (power.projected_area(w), beckmann.projected_area(w));
        assert!((a / want - 1.0).abs() < AREA_ERROR, "{w}: {a} {want}");
    }
}

#[test]
fn normals_follow_their_densities() {
    let incidences = [0.0, 40.0, 80.0, 89.5];
    let alphas = [Vec2::splat(1.0), Vec2::splat(0.05), Vec2::new(0.6, 0.15)];
    let family = (MODELS.len() * alphas.len() * (1 + incidences.len())) as u32;
    for (kind, exponent) in MODELS {
        for alpha in alphas {
            let facets = Microfacets::new(kind, alpha, exponent);
            let test = ChiSquare {
                samples: 70_000,
                pole: Vec3::Z,
                family,
                seed: 11,
            };
            let name = format!("{kind} {exponent} {alpha}");
            test.run(
                |random| Some(facets.sample_normal(random.next_2d())),
                |m| facets.normal_pdf(m),
            )
            .unwrap_or_else(|e| panic!("{name}, all normals: {e}"));
            for degrees in incidences {
                let wi = direction_at(degrees, 30.0);
                test.run(
                    |random| {
                        let m = facets.sample_visible_normal(wi, random.next_2d());
                        // Anisotropic Phong also draws normals that face away, and has no density there.
                        (wi.dot(m) > 0.0).then_some(m)
                    },
                    |m| facets.visible_normal_pdf(wi, m),
                )
                .unwrap_or_else(|e| panic!("{name}, seen at {degrees}: {e}"));
            }
        }
    }
}

#[test]
fn cavities_show_normals_that_face_the_viewer() {
    let mut random = common::Random(4);
    for (kind, exponent) in &MODELS[2..] {
        let facets = Microfacets::new(*kind, Vec2::splat(0.7), *exponent);
        for _ in 0..20_000 {
            let wi = random.upper_direction();
            let m = facets.sample_visible_normal(wi, random.next_2d());
            assert!(wi.dot(m) > -2e-6, "{kind} {exponent} {wi} {m}");
        }
    }
}

#[test]
fn cavity_masking_is_that_of_a_groove() {
    let mut random = common::Random(12);
    for _ in 0..5_000 {
        let (w, m) = (random.upper_direction(), random.upper_direction());
        let g = v_cavity::g1(w, m);
        assert!((0.0..=1.0).contains(&g));
        // Seen from one facet or the other, the pair covers the groove: G1 over both is the area of its opening.
        let mirrored = Vec3::new(-m.x, -m.y, m.z);
        let covered = g * w.dot(m).max(0.0) + v_cavity::g1(w, mirrored) * w.dot(mirrored).max(0.0);
        let opening = 2.0 * m.z * w.z;
        assert!(
            (covered - opening).abs() < 2e-6,
            "{w} {m}: {covered} {opening}"
        );
        let o = random.upper_direction();
        assert_eq!(v_cavity::g2(w, o, m), v_cavity::g2(o, w, m));
    }
}

#[test]
fn derivatives_are_those_of_the_densities() {
    for (kind, exponent) in MODELS {
        for alpha in [Vec2::splat(0.5), Vec2::new(0.6, 0.25)] {
            let facets = Microfacets::new(kind, alpha, exponent);
            for i in 0..24 {
                let t = 0.03 * f64::from(i + 1);
                let (sin, cos) = (0.9_f64 * f64::from(i)).sin_cos();
                let at = |t: f64| Vec2::new((t * cos) as f32, (t * sin) as f32);
                let normal = |t: f64| {
                    let s = at(t);
                    Vec3::new(-s.x, -s.y, 1.0).normalize()
                };
                // Where exp has underflowed there is nothing to differentiate.
                if facets.distribution(normal(1.2 * t)) < 1e-25 {
                    continue;
                }
                let step = 2e-3 * t.max(0.1);
                let slope = |t: f64| f64::from(facets.slope_density(at(t))).ln();
                let normals = |t: f64| f64::from(facets.distribution(normal(t))).ln();
                let fd = |f: &dyn Fn(f64) -> f64| (f(t + step) - f(t - step)) / (2.0 * step);
                let (a, b) = (fd(&slope), fd(&normals));
                let got = f64::from(facets.ln_slope_density_derivative(normal(t)));
                assert!(
                    (got - a).abs() < 3e-3 * (1.0 + a.abs()),
                    "{kind} {exponent} {t}: {got} {a}"
                );
                let got = f64::from(facets.ln_distribution_derivative(normal(t)));
                assert!(
                    (got - b).abs() < 3e-3 * (1.0 + b.abs()),
                    "{kind} {exponent} {t}: {got} {b}"
                );
            }
        }
    }
}
