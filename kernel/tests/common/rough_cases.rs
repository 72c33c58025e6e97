//! The rough lobes under test beyond the everyday ones: Phong and exponential-power microfacets, the ends of the roughness
//! scale, Oren-Nayar and diffracting conductors.

use super::lobes::{Case, case, conductor, white};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::Lobe;
use halflight_kernel::bsdf::diffracting_conductor::fill_table;
use halflight_kernel::bsdf::diffraction_table::{FineScale, WORDS};
use halflight_kernel::bsdf::hanrahan_krueger::layer_parameters;
use halflight_kernel::bsdf::ward::variant;
use halflight_kernel::scene::{distribution, lobe_flag, lobe_kind};
use std::sync::OnceLock;

/// A table for a fine scale of the given height and correlation length in micrometres.
pub fn diffracting(alpha: f32, exponent: f32, sigma: f32, b: f32, c: f32) -> Case {
    let mut lobe = conductor(lobe_kind::DIFFRACTING_CONDUCTOR);
    lobe.distribution = distribution::EXPONENTIAL_POWER;
    lobe.alpha = Vec2::splat(alpha);
    lobe.exponent = exponent;
    lobe.table = 0;
    let scale = FineScale {
        wavelengths: [0.6114, 0.5491, 0.4642],
        sigma,
        b,
        c,
    };
    let mut data = vec![0.0; WORDS];
    fill_table(&scale, alpha, exponent, &mut data);
    Case {
        name: format!("diffracting, alpha {alpha}, p {exponent}, sigma {sigma}, b {b}, c {c}"),
        lobe,
        data,
    }
}

/// Diffracting conductors: weak, strong, narrow and broad.
pub fn diffracting_cases() -> Vec<Case> {
    // Filled once: the tables take a third of a second each, and many tests go through all lobes.
    static CASES: OnceLock<Vec<Case>> = OnceLock::new();
    CASES.get_or_init(build_diffracting_cases).clone()
}

fn build_diffracting_cases() -> Vec<Case> {
    vec![
        diffracting(0.1, 1.0, 0.02, 2.0, 2.0),
        diffracting(0.3, 0.6, 0.06, 1.0, 1.4),
        diffracting(0.03, 2.0, 0.1, 0.4, 3.0),
        diffracting(0.2, 0.4, 0.3, 8.0, 2.5),
        diffracting(0.4, 4.0, 0.03, 0.1, 1.2),
    ]
}

/// The highlights of older models, transmission of diffusers, and the parts of the principled model.
pub fn later_cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for exponent in [0.0, 3.0, 30.0, 1000.0] {
        let mut lobe = white(lobe_kind::PHONG);
        lobe.exponent = exponent;
        cases.push(case(&format!("Phong, exponent {exponent}"), lobe));
    }
    for variant in [variant::WARD, variant::DUER, variant::BALANCED] {
        for alpha in [Vec2::splat(0.1), Vec2::new(0.15, 0.5)] {
            let mut lobe = white(lobe_kind::WARD);
            lobe.distribution = variant;
            lobe.alpha = alpha;
            cases.push(case(
                &format!("Ward, variant {variant}, alpha {alpha}"),
                lobe,
            ));
        }
    }
    let mut lobe = white(lobe_kind::DIFFUSE_TRANSMISSION);
    lobe.specular_transmittance = Vec3::new(1.0, 0.5, 0.1);
    // There is no change of index.
    lobe.eta = Vec3::ONE;
    cases.push(case("diffuse transmission", lobe));
    for (roughness, flatness) in [(0.0, 0.0), (0.3, 0.0), (1.0, 0.0), (0.5, 1.0)] {
        let mut lobe = white(lobe_kind::PRINCIPLED_DIFFUSE);
        lobe.alpha = Vec2::splat(roughness);
        lobe.exponent = flatness;
        let name = format!("principled diffuse, roughness {roughness}, flatness {flatness}");
        cases.push(case(&name, lobe));
    }
    let mut lobe = white(lobe_kind::SHEEN);
    lobe.reflectance = Vec3::new(0.8, 0.4, 0.1);
    lobe.exponent = 0.5;
    cases.push(case("sheen", lobe));
    for alpha in [Vec2::splat(0.2), Vec2::new(0.1, 0.5)] {
        for flag in [0, lobe_flag::TINTED] {
            let mut lobe = white(lobe_kind::SCHLICK_REFLECTION);
            lobe.distribution = distribution::GGX;
            lobe.reflectance = Vec3::new(0.8, 0.4, 0.1);
            lobe.flags |= flag;
            lobe.alpha = alpha;
            cases.push(case(
                &format!("Schlick reflection, alpha {alpha}, flag {flag}"),
                lobe,
            ));
        }
    }
    for alpha in [0.02, 0.1] {
        let mut lobe = white(lobe_kind::CLEARCOAT);
        lobe.alpha = Vec2::splat(alpha);
        cases.push(case(&format!("clear coat, alpha {alpha}"), lobe));
    }
    for (alpha, eta) in [
        (Vec2::splat(0.2), 1.5),
        (Vec2::new(0.1, 0.5), 1.9),
        (Vec2::splat(0.6), 0.8),
    ] {
        let mut lobe = white(lobe_kind::THIN_TRANSMISSION);
        lobe.distribution = distribution::GGX;
        lobe.specular_transmittance = Vec3::new(1.0, 0.5, 0.1);
        lobe.alpha = alpha;
        lobe.eta = Vec3::splat(eta);
        cases.push(case(
            &format!("thin transmission, alpha {alpha}, eta {eta}"),
            lobe,
        ));
    }
    for (given, first, second, g) in [
        (layer_parameters::DEPTHS, Vec3::new(1.0, 0.5, 0.1), 0.2, 0.0),
        (layer_parameters::DEPTHS, Vec3::splat(0.01), 0.0, 0.5),
        (layer_parameters::DEPTHS, Vec3::splat(5.0), 1.0, -0.4),
        (layer_parameters::ALBEDO, Vec3::new(1.0, 0.5, 0.1), 2.0, 0.9),
        (layer_parameters::ALBEDO, Vec3::splat(0.9), 1e9, 0.3),
    ] {
        let mut lobe = white(lobe_kind::HANRAHAN_KRUEGER);
        lobe.distribution = given;
        lobe.reflectance = first;
        lobe.specular_transmittance = Vec3::splat(second);
        lobe.exponent = g;
        cases.push(case(
            &format!("scattering layer, {given}, {first}, {second}, g {g}"),
            lobe,
        ));
    }
    cases
}

/// All of them.
pub fn cases() -> Vec<Case> {
    let mut cases = diffracting_cases();
    cases.extend(later_cases());
    for alpha in [0.001, 0.2, 0.4, 0.7, 1.0] {
        let mut lobe = white(lobe_kind::ROUGH_DIFFUSE);
        lobe.reflectance = Vec3::new(0.9, 0.5, 0.1);
        lobe.alpha = Vec2::splat(alpha);
        cases.push(case(&format!("rough diffuse, alpha {alpha}"), lobe));
    }
    let aniso = Vec2::new(0.1, 0.5);
    for (kind, exponent, alpha) in [
        (distribution::BECKMANN, 1.0, Vec2::splat(0.001)),
        (distribution::BECKMANN, 1.0, Vec2::splat(1.0)),
        (distribution::GGX, 1.0, Vec2::splat(0.001)),
        (distribution::GGX, 1.0, Vec2::splat(1.0)),
        (distribution::PHONG, 1.0, Vec2::splat(0.001)),
        (distribution::PHONG, 1.0, Vec2::splat(0.4)),
        (distribution::PHONG, 1.0, aniso),
        (distribution::EXPONENTIAL_POWER, 1.0, Vec2::splat(0.001)),
        (distribution::EXPONENTIAL_POWER, 0.5, Vec2::splat(0.3)),
        (distribution::EXPONENTIAL_POWER, 3.0, Vec2::splat(1.0)),
        (distribution::EXPONENTIAL_POWER, 1.5, aniso),
    ] {
        let with = |lobe: Lobe| Lobe {
            distribution: kind,
            exponent,
            alpha,
            ..lobe
        };
        let name =
            |model: &str| format!("{model}, distribution {kind}, p {exponent}, alpha {alpha}");
        cases.push(case(
            &name("rough conductor"),
            with(conductor(lobe_kind::ROUGH_CONDUCTOR)),
        ));
        // The cells of the chi-square test resolve one lobe of this width, not two.
        if alpha.x > 0.01 {
            cases.push(case(
                &name("rough dielectric"),
                with(white(lobe_kind::ROUGH_DIELECTRIC)),
            ));
        }
    }
    cases
}
