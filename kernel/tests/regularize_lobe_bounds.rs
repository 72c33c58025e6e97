//! Bounds of lobes against an adversarial search over directions: those that heuristics take, and tau itself for the exponential
//! power distribution of every exponent; and the base of plastics, which regularisation leaves alone.

mod common;

use common::Random;
use common::lobes::{specular, white};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Lobe, lobe, mode};
use halflight_kernel::regularize::regularized_bsdf::{
    alpha_hat, bound, eval_cosine_pdf, regularized_lobe,
};
use halflight_kernel::scene::{distribution, lobe_kind};

/// A direction of cosine z and azimuth phi.
fn direction(z: f32, phi: f32) -> Vec3 {
    let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    Vec3::new(r * phi.cos(), r * phi.sin(), z)
}

/// The largest value of the lobe without a cosine, over pairs of directions of all elevations down to 1e-6, half of them grazing
/// pairs of nearly opposite azimuth, then by small steps from the best.
fn largest(lobe: &Lobe, transmission: bool, seed: u64) -> f32 {
    let mut random = Random(seed);
    let value = |v: [f32; 4]| {
        let z = |u: f32| 1e-6_f32.powf(u.clamp(0.0, 1.0));
        let wi = direction(z(v[0]), v[2]);
        let mut wo = direction(z(v[1]), v[2] + std::f32::consts::PI + v[3]);
        if transmission {
            wo.z = -wo.z;
        }
        let (f, _) = lobe::eval_cosine_pdf(lobe, &[], wi, wo);
        assert!(f.is_finite());
        (f / wo.z.abs()).max_element()
    };
    let mut best = (0.0, [0.0; 4]);
    for n in 0..20_000 {
        let u = random.next_1d();
        let phi = 6.3 * random.next_1d();
        // Azimuths apart from opposite by 1e-6 to pi, at either side.
        let apart = 3.1 * 1e-6_f32.powf(random.next_1d());
        let other = if n % 2 == 0 { u } else { random.next_1d() };
        let v = [u, other, phi, apart];
        let found = value(v);
        if found > best.0 {
            best = (found, v);
        }
    }
    for n in 0..20_000 {
        let scale = 0.3 * 1e-4_f32.powf(n as f32 / 20_000.0);
        let mut v = best.1;
        for x in &mut v[..3] {
            *x += scale * (2.0 * random.next_1d() - 1.0);
        }
        v[3] *= (scale * 8.0 * (2.0 * random.next_1d() - 1.0)).exp();
        let found = value(v);
        if found > best.0 {
            best = (found, v);
        }
    }
    best.0
}

fn power(kind: u32, exponent: f32, alpha: Vec2) -> Lobe {
    // A mirror's Fresnel term is one.
    let k = if kind == lobe_kind::ROUGH_CONDUCTOR {
        1e4
    } else {
        0.0
    };
    Lobe {
        exponent,
        k: Vec3::splat(k),
        ..specular(kind, distribution::EXPONENTIAL_POWER, alpha, 1.5)
    }
}

#[test]
fn the_exponential_power_distribution_stays_below_tau() {
    let mut closest = 0.0_f32;
    for exponent in [0.2, 0.3, 0.5, 0.8, 1.0, 1.5, 2.0, 3.0, 5.0] {
        for tau in [5.0, 20.0, 200.0, 3000.0] {
            for (kind, transmission) in [
                (lobe_kind::ROUGH_CONDUCTOR, false),
                (lobe_kind::ROUGH_DIELECTRIC, true),
            ] {
                let lobe = power(kind, exponent, Vec2::splat(0.003));
                let hat = alpha_hat(&lobe, transmission, tau);
                if hat >= 1.0 {
                    // No roughness will do.
                    continue;
                }
                let found = largest(&regularized_lobe(&lobe, transmission, tau), transmission, 5);
                assert!(
                    found <= 1.002 * tau,
                    "p = {exponent}, tau = {tau}, transmission {transmission}: {found} at alpha {hat}"
                );
                if !transmission {
                    closest = closest.max(found / tau);
                    assert!(
                        found > 0.5 * tau,
                        "p = {exponent}, tau = {tau}: {found} is far below at alpha {hat}"
                    );
                }
            }
        }
    }
    assert!(closest > 0.95, "{closest}");
}

#[test]
fn bounds_of_lobes_hold_and_are_close() {
    let mut cases: Vec<(String, Lobe, bool, f32)> = Vec::new();
    let mut half = white(lobe_kind::DIFFUSE);
    half.reflectance = Vec3::splat(0.5);
    cases.push(("diffuse".into(), half, false, 0.99));
    let mut curtain = white(lobe_kind::DIFFUSE_TRANSMISSION);
    curtain.specular_transmittance = Vec3::splat(0.3);
    cases.push(("curtain".into(), curtain, true, 0.99));
    // As rough as it gets: the peak of the highlight is not along the normal.
    let mut plastic = specular(
        lobe_kind::ROUGH_PLASTIC,
        distribution::BECKMANN,
        Vec2::ONE,
        1.5,
    );
    plastic.reflectance = Vec3::splat(0.9);
    plastic.internal_reflectance = 0.596;
    plastic.table = halflight_kernel::scene::NONE;
    cases.push(("plastic".into(), plastic, false, 0.5));
    for alpha in [0.05, 0.3, 0.7, 1.0] {
        for kind in [distribution::BECKMANN, distribution::GGX] {
            let mut metal = specular(lobe_kind::ROUGH_CONDUCTOR, kind, Vec2::splat(alpha), 1.5);
            metal.k = Vec3::splat(1e4);
            cases.push((format!("metal {kind} {alpha}"), metal, false, 0.9));
            let glass = specular(lobe_kind::ROUGH_DIELECTRIC, kind, Vec2::splat(alpha), 1.5);
            cases.push((format!("glass {kind} {alpha}"), glass, false, 0.7));
            // The bound is of importance, which refraction does not scale.
            let through = Lobe {
                mode: mode::IMPORTANCE,
                ..glass
            };
            cases.push((format!("through {kind} {alpha}"), through, true, 0.6));
        }
        for exponent in [0.4, 1.0, 2.0, 5.0] {
            let metal = power(lobe_kind::ROUGH_CONDUCTOR, exponent, Vec2::splat(alpha));
            cases.push((format!("power {exponent} {alpha}"), metal, false, 0.9));
            let oblong = power(
                lobe_kind::ROUGH_CONDUCTOR,
                exponent,
                Vec2::new(alpha, 2.0 * alpha),
            );
            cases.push((format!("oblong {exponent} {alpha}"), oblong, false, 0.1));
            let glass = power(lobe_kind::ROUGH_DIELECTRIC, exponent, Vec2::splat(alpha));
            cases.push((format!("power glass {exponent} {alpha}"), glass, true, 0.0));
        }
    }
    for (name, lobe, transmission, share) in cases {
        let (found, stated) = (largest(&lobe, transmission, 9), bound(&lobe, transmission));
        assert!(found <= 1.002 * stated, "{name}: {found} above {stated}");
        assert!(
            found >= share * stated,
            "{name}: {found} far below {stated}"
        );
    }
}

/// The roughness for tau has tau as its bound, and equation 9 is equation 8 times 4 K, K = 9 for glass.
#[test]
fn bounds_of_the_exponential_power_distribution_are_inverted() {
    for exponent in [0.2, 0.5, 1.0, 2.0, 5.0] {
        for tau in [300.0, 1e4] {
            for (kind, transmission) in [
                (lobe_kind::ROUGH_CONDUCTOR, false),
                (lobe_kind::ROUGH_DIELECTRIC, false),
                (lobe_kind::ROUGH_DIELECTRIC, true),
            ] {
                let lobe = power(kind, exponent, Vec2::splat(0.003));
                let raised = regularized_lobe(&lobe, transmission, tau);
                let ratio = bound(&raised, transmission) / tau;
                let hat = raised.alpha.x;
                assert!(
                    (ratio - 1.0).abs() < 5e-3 || hat == 1.0 && ratio > 1.0,
                    "p = {exponent}, tau = {tau}, {kind} {transmission}: {ratio} at {hat}"
                );
            }
        }
        let glass = power(lobe_kind::ROUGH_DIELECTRIC, exponent, Vec2::splat(0.3));
        let ratio = bound(&glass, true) / bound(&glass, false);
        assert!((ratio - 36.0).abs() < 1e-3, "{ratio}");
    }
}

/// Beside the highlight of the coating both densities are those of the diffuse base: only the coating's is scaled.
#[test]
fn the_base_of_plastics_is_sampled_as_before() {
    for kind in [lobe_kind::PLASTIC, lobe_kind::ROUGH_PLASTIC] {
        let mut plastic = specular(kind, distribution::BECKMANN, Vec2::splat(0.02), 1.5);
        plastic.reflectance = Vec3::splat(0.5);
        plastic.internal_reflectance = 0.596;
        plastic.table = halflight_kernel::scene::NONE;
        for phi in [0.3, 1.0, 2.5] {
            // A grazing wo, where the ratio of masking is far from one, seen from the normal: a tangent of the half vector
            // of 0.9 and an alpha_hat of 0.18.
            let (wi, wo) = (Vec3::Z, direction(0.1, phi));
            let (_, plain) = lobe::eval_cosine_pdf(&plastic, &[], wi, wo);
            let (_, hat) = eval_cosine_pdf(&plastic, &[], wi, wo, 1000.0);
            assert!(plain > 0.0);
            assert!(
                (hat / plain - 1.0).abs() < 1e-3,
                "{kind}: {hat} for {plain}"
            );
        }
    }
}
