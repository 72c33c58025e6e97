//! Regularised lobes: values below tau, the density of equation 13, samplers, limits, and lobes that are left alone.

mod common;

use common::chi_square::ChiSquare;
use common::lobes::{Case, conductor, delta_cases, rough_cases, white};
use common::{Random, direction_at};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Lobe, event, lobe, microfacet};
use halflight_kernel::regularize::regularized_bsdf::{bound, eval_cosine_pdf, regularized_lobe};
use halflight_kernel::scene::{distribution, lobe_flag, lobe_kind};
use proptest::prelude::*;

/// Lobes that have a microfacet model or become one.
fn glossy_cases() -> Vec<Case> {
    let mut cases = rough_cases();
    for kind in [distribution::BECKMANN, distribution::GGX] {
        for mut case in delta_cases() {
            if case.lobe.kind == lobe_kind::CONDUCTOR || case.lobe.kind == lobe_kind::DIELECTRIC {
                case.lobe.distribution = kind;
                case.name = format!("{}, distribution {kind}", case.name);
                cases.push(case);
            }
        }
    }
    cases
}

/// f |cos| / |cos| of the regularised lobe never exceeds tau (the base of plastics aside), down to elevations of 1e-6.
#[test]
fn values_stay_below_tau() {
    let mut random = Random(21);
    let mut closest = 0.0_f32;
    for case in glossy_cases() {
        if case.lobe.kind == lobe_kind::ROUGH_PLASTIC {
            continue;
        }
        // Where alpha_hat is not clamped: tau above 4 K / pi (11.5 for glass), and alpha below 1/sqrt(2) for Beckmann.
        for tau in [200.0_f32, 3000.0] {
            for n in 0..10_000 {
                let z = |u: f32| 1e-6_f32.powf(u);
                let direction = |z: f32, phi: f32| {
                    let r = (1.0 - z * z).max(0.0).sqrt();
                    Vec3::new(r * phi.cos(), r * phi.sin(), z)
                };
                let phi = 6.2831855 * random.next_1d();
                let wi = direction(z(random.next_1d()), phi);
                let r = (wi.x * wi.x + wi.y * wi.y).sqrt().max(1e-12);
                let zo = if n % 2 == 0 {
                    wi.z
                } else {
                    z(random.next_1d())
                };
                let ro = (1.0 - zo * zo).max(0.0).sqrt();
                let mut wo = Vec3::new(-wi.x / r * ro, -wi.y / r * ro, zo);
                if n % 3 == 0 {
                    wo.z = -wo.z;
                }
                if n % 5 == 0 {
                    wo = random.direction();
                }
                let (f, p) = eval_cosine_pdf(&case.lobe, &case.data, wi, wo, tau);
                assert!(p >= 0.0 && p.is_finite() && f.is_finite());
                let value = f.max_element() / wo.z.abs().max(1e-12);
                assert!(
                    value <= tau * 1.001,
                    "{}: {value} above {tau} at {wi} {wo}",
                    case.name
                );
                closest = closest.max(value / tau);
            }
        }
    }
    assert!(closest > 0.5, "{closest}");
}

/// p_hat = (f_hat / f) p, equation 13, against the values and densities of the lobe itself.
#[test]
fn the_density_is_scaled_as_the_value() {
    let mut random = Random(4);
    let mut compared = 0;
    let mut cases = rough_cases();
    // Distributions whose normals are not sampled by Smith's visibility.
    for (kind, exponent) in [
        (distribution::PHONG, 1.0),
        (distribution::EXPONENTIAL_POWER, 0.8),
        (distribution::EXPONENTIAL_POWER, 1.7),
    ] {
        let mut lobe = conductor(lobe_kind::ROUGH_CONDUCTOR);
        lobe.distribution = kind;
        lobe.exponent = exponent;
        lobe.alpha = Vec2::splat(0.2);
        cases.push(common::lobes::case("other distribution", lobe));
        // Becomes isotropic in refraction.
        let mut glass = white(lobe_kind::ROUGH_DIELECTRIC);
        glass.distribution = kind;
        glass.exponent = exponent;
        glass.alpha = Vec2::new(0.1, 0.5);
        cases.push(common::lobes::case("other glass", glass));
    }
    for case in cases {
        let kind = case.lobe.kind;
        if kind != lobe_kind::ROUGH_CONDUCTOR && kind != lobe_kind::ROUGH_DIELECTRIC {
            continue;
        }
        let wi = direction_at(50.0, 25.0);
        for side in [wi, -wi] {
            for _ in 0..300 {
                let wo = if random.next_1d() < 0.3 {
                    random.direction()
                } else {
                    lobe::sample(
                        &case.lobe,
                        &case.data,
                        side,
                        random.next_1d(),
                        random.next_2d(),
                    )
                    .wo
                };
                let (f, p) = lobe::eval_cosine_pdf(&case.lobe, &case.data, side, wo);
                let (f_hat, p_hat) = eval_cosine_pdf(&case.lobe, &case.data, side, wo, 60.0);
                if p > 1e-6 && f.y > 1e-6 && f_hat.y > 1e-6 {
                    let want = f_hat.y / f.y * p;
                    assert!(
                        (p_hat / want - 1.0).abs() < 2e-3,
                        "{}: {p_hat} {want}",
                        case.name
                    );
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 2000, "{compared}");
}

/// For a mirror and for smooth glass p_hat is f_hat |cos| over the weight of the discrete sample.
#[test]
fn the_density_of_a_specular_lobe_is_the_limit() {
    let mut random = Random(14);
    for (lobe, transmission) in [
        (conductor(lobe_kind::CONDUCTOR), false),
        (white(lobe_kind::DIELECTRIC), false),
        (white(lobe_kind::DIELECTRIC), true),
    ] {
        let tau = 500.0;
        let rough = regularized_lobe(&lobe, transmission, tau);
        let wi = direction_at(35.0, 80.0);
        for _ in 0..300 {
            let s = lobe::sample(&rough, &[], wi, random.next_1d(), random.next_2d());
            if s.pdf <= 0.0 || (s.wo.z < 0.0) != transmission {
                continue;
            }
            let (f_hat, p_hat) = eval_cosine_pdf(&lobe, &[], wi, s.wo, tau);
            // White glass: weight 1, but 1/eta^2 in transmission. The conductor's Fresnel term belongs to the normal.
            let colour = if lobe.kind == lobe_kind::DIELECTRIC {
                if transmission { 1.0 / 2.25 } else { 1.0 }
            } else {
                let m = (wi + s.wo).normalize();
                halflight_kernel::bsdf::fresnel::fresnel_conductor(wi.dot(m), lobe.eta, lobe.k).y
            };
            // Masking of wi, which the regularised sampler has drawn along with D, is in f_hat and in p_hat.
            assert!(
                (p_hat * colour / f_hat.y - 1.0).abs() < 1e-3,
                "{p_hat} {f_hat}"
            );
        }
    }
}

/// Samplers of the regularised lobes follow their densities, which integrate to one or to what the horizon leaves.
#[test]
fn regularized_lobes_follow_their_density() {
    let cases = glossy_cases();
    let mut failures = vec![];
    let family = 2 * cases.len() as u32;
    for case in &cases {
        let refracts = case.lobe.kind == lobe_kind::DIELECTRIC;
        for transmission in [false, true] {
            if transmission && !refracts {
                continue;
            }
            let rough = regularized_lobe(&case.lobe, transmission, 100.0);
            let wi = direction_at(55.0, 30.0);
            let test = ChiSquare {
                samples: 20_000,
                pole: Vec3::new(-wi.x, -wi.y, wi.z),
                family,
                seed: 8,
            };
            let result = test.run(
                |random| {
                    let u1 = random.next_1d();
                    let s = lobe::sample(&rough, &case.data, wi, u1, random.next_2d());
                    (s.pdf > 0.0 && s.event & event::DELTA == 0).then_some(s.wo)
                },
                |w| lobe::pdf(&rough, &case.data, wi, w),
            );
            if let Err(reason) = result {
                failures.push(format!("{}: {reason}", case.name));
            }
        }
    }
    assert!(failures.is_empty(), "{failures:#?}");
}

/// Integral of f_hat |cos| L over one side, by the regularised lobe's own sampler at the nodes of a grid.
fn transported(
    lobe: &Lobe,
    transmission: bool,
    wi: Vec3,
    tau: f32,
    light: impl Fn(Vec3) -> f32,
) -> f64 {
    let rough = regularized_lobe(lobe, transmission, tau);
    let n = 64;
    let node = |i: u32| (i as f32 + 0.5) / n as f32;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            // The choice between reflection and refraction is integrated in a third dimension of few nodes.
            for k in 0..8 {
                let u = Vec2::new(node(i), node(j));
                let s = lobe::sample(&rough, &[], wi, (k as f32 + 0.5) / 8.0, u);
                if s.pdf > 0.0 && (s.wo.z < 0.0) == transmission {
                    sum += f64::from(s.weight.y * light(s.wo));
                }
            }
        }
    }
    sum / f64::from(n * n * 8)
}

/// As tau grows, energy and image of a regularised mirror tend to those of the mirror.
#[test]
fn specular_lobes_are_the_limit_of_their_regularisation() {
    let wi = direction_at(40.0, 70.0);
    let mirror = conductor(lobe_kind::CONDUCTOR);
    let exact = lobe::sample(&mirror, &[], wi, 0.5, Vec2::splat(0.5));
    let white_light = |_: Vec3| 1.0;
    let smooth_light = |w: Vec3| 1.0 + w.x * w.x + (3.0 * w.y).sin() * w.z;
    let mut last = f64::MAX;
    for tau in [1e2, 1e4, 1e6, 1e8] {
        let energy = transported(&mirror, false, wi, tau, white_light);
        let image = transported(&mirror, false, wi, tau, smooth_light);
        let want = f64::from(exact.weight.y);
        let error = (image / (want * f64::from(smooth_light(exact.wo))) - 1.0).abs();
        // Less energy for masking; bias falls as alpha_hat^2, which is tau^(-1/2).
        assert!(
            (energy / want - 1.0).abs() < 1.5 * f64::from(tau).powf(-0.5),
            "{tau}: {energy}"
        );
        assert!(error < 0.4 * last, "{tau}: {error} after {last}");
        last = error.max(1e-6);
    }
    assert!(last < 3e-3, "{last}");
    // Glass: each side on its own.
    let glass = white(lobe_kind::DIELECTRIC);
    let reflectance = f64::from(lobe::sample(&glass, &[], wi, 0.0, Vec2::ZERO).pdf);
    for tau in [1e4, 1e8] {
        // 8 nodes of the Fresnel choice resolve 1/8: the dense choice is by the density itself.
        let rough = regularized_lobe(&glass, true, tau);
        let mut random = Random(2);
        let (mut through, mut all) = (0.0, 0.0);
        for _ in 0..60_000 {
            let s = lobe::sample(&rough, &[], wi, random.next_1d(), random.next_2d());
            if s.pdf > 0.0 {
                all += 1.0;
                if s.wo.z < 0.0 {
                    through += f64::from(s.weight.y) * 2.25;
                }
            }
        }
        assert!(all > 59_000.0);
        // 5 standard errors.
        let error = 5.0 * (reflectance * (1.0 - reflectance) / 6e4).sqrt()
            + 1.5 * f64::from(tau).powf(-0.5);
        assert!(
            (through / 6e4 - (1.0 - reflectance)).abs() < error,
            "{through}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Finite for every roughness, index, threshold and pair of directions.
    #[test]
    fn evaluation_is_total(
        kind in 0_u32..9,
        distribution in 0_u32..2,
        alpha in (0.0_f32..1.5, 0.0_f32..1.5),
        eta in prop_oneof![Just(1.0_f32), 0.3_f32..3.0],
        log_tau in -3.0_f32..20.0,
        seed in any::<u64>(),
        low in -8.0_f32..0.0,
    ) {
        let mut lobe = white(kind);
        lobe.distribution = distribution;
        lobe.alpha = microfacet::clamp_alpha(Vec2::new(alpha.0, alpha.1));
        lobe.eta = Vec3::splat(eta);
        lobe.k = Vec3::ONE;
        lobe.flags |= if seed % 2 == 0 { lobe_flag::SAMPLE_ALL_NORMALS } else { 0 };
        let mut random = Random(seed);
        let wi = random.direction();
        let mut wo = random.direction();
        wo.z *= 10_f32.powf(low);
        let wo = wo.normalize();
        let tau = 10_f32.powf(log_tau);
        for (i, o) in [(wi, wo), (wo, wi), (wi, -wi), (wi, wi)] {
            let (f, p) = eval_cosine_pdf(&lobe, &[], i, o, tau);
            prop_assert!(f.is_finite() && p.is_finite() && p >= 0.0 && f.min_element() >= 0.0);
        }
        prop_assert!(bound(&lobe, false).is_finite() && bound(&lobe, true).is_finite());
    }
}
