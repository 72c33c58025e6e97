//! Older models against their published formulas, written out in double precision.

mod common;

use common::lobes::white;
use common::{Random, direction_at};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::hanrahan_krueger::layer_parameters;
use halflight_kernel::bsdf::ward::variant;
use halflight_kernel::bsdf::{Lobe, lobe};
use halflight_kernel::scene::lobe_kind;
use std::f64::consts::PI;

/// Pairs of directions above the surface, some of them near each other's mirror image.
fn pairs() -> Vec<(Vec3, Vec3)> {
    let mut random = Random(3);
    let mut pairs = Vec::new();
    while pairs.len() < 200 {
        let (mut wi, mut wo) = (random.direction(), random.direction());
        (wi.z, wo.z) = (wi.z.abs(), wo.z.abs());
        if pairs.len() % 2 == 0 {
            wo = (Vec3::new(-wi.x, -wi.y, wi.z) + 0.2 * random.direction()).normalize();
        }
        if wi.z > 0.05 && wo.z > 0.05 {
            pairs.push((wi, wo));
        }
    }
    pairs
}

fn wide(v: Vec3) -> [f64; 3] {
    [v.x.into(), v.y.into(), v.z.into()]
}

#[track_caller]
fn matches(lobe: &Lobe, formula: impl Fn([f64; 3], [f64; 3]) -> f64, tolerance: f64) {
    let mut positive = 0;
    for (wi, wo) in pairs() {
        let expected = formula(wide(wi), wide(wo));
        let value = f64::from(lobe::eval_cosine(lobe, &[], wi, wo).x / wo.z);
        let error = (value - expected).abs() / expected.max(1e-4);
        assert!(error < tolerance, "{wi} {wo}: {value}, not {expected}");
        positive += u32::from(expected > 1e-4);
    }
    assert!(positive > 50, "{positive}");
}

#[test]
fn phong_is_lafortune_and_willems() {
    for n in [1.0_f64, 20.0, 300.0] {
        let mut lobe = white(lobe_kind::PHONG);
        lobe.exponent = n as f32;
        lobe.specular_reflectance = Vec3::splat(0.5);
        let formula = |i: [f64; 3], o: [f64; 3]| {
            let cos = i[2] * o[2] - i[0] * o[0] - i[1] * o[1];
            0.5 * (n + 2.0) / (2.0 * PI) * cos.max(0.0).powf(n)
        };
        matches(&lobe, formula, 1e-4);
    }
}

#[test]
fn ward_is_that_of_each_paper() {
    let (u, v) = (0.2_f64, 0.4_f64);
    for kind in [variant::WARD, variant::DUER, variant::BALANCED] {
        let mut lobe = white(lobe_kind::WARD);
        lobe.distribution = kind;
        lobe.alpha = Vec2::new(u as f32, v as f32);
        let formula = |i: [f64; 3], o: [f64; 3]| {
            // The half vector is not normalised in these forms.
            let h = [i[0] + o[0], i[1] + o[1], i[2] + o[2]];
            let slope2 = ((h[0] / u).powi(2) + (h[1] / v).powi(2)) / (h[2] * h[2]);
            let gauss = (-slope2).exp() / (PI * u * v);
            let length2 = h.iter().map(|x| x * x).sum::<f64>();
            gauss
                * match kind {
                    variant::WARD => 1.0 / (4.0 * (i[2] * o[2]).sqrt()),
                    variant::DUER => 1.0 / (4.0 * i[2] * o[2]),
                    _ => length2 / h[2].powi(4),
                }
        };
        matches(&lobe, formula, 2e-4);
    }
}

#[test]
fn the_bounded_form_of_ward_stays_below_all_light_where_the_one_before_does_not() {
    let albedo = |kind: u32| {
        let mut lobe = white(lobe_kind::WARD);
        lobe.distribution = kind;
        lobe.alpha = Vec2::splat(0.1);
        let (albedo, error) =
            common::furnace::albedo(&lobe, &[], direction_at(88.5, 10.0), 40_000, 2);
        (albedo.x, 5.0 * error.x)
    };
    let (balanced, error) = albedo(variant::BALANCED);
    assert!(balanced - error <= 1.0, "{balanced} +- {error}");
    let (duer, error) = albedo(variant::DUER);
    assert!(duer - error > 1.0, "{duer} +- {error}");
}

#[test]
fn diffusers_transmit_by_lambert() {
    let mut lobe = white(lobe_kind::DIFFUSE_TRANSMISSION);
    lobe.specular_transmittance = Vec3::splat(0.7);
    for (wi, wo) in pairs() {
        assert_eq!(lobe::eval_cosine(&lobe, &[], wi, wo), Vec3::ZERO);
        for (wi, wo) in [(wi, -wo), (-wi, wo)] {
            let f = lobe::eval_cosine(&lobe, &[], wi, wo).x / wo.z.abs();
            assert!((f64::from(f) - 0.7 / PI).abs() < 1e-6, "{wi} {wo}: {f}");
        }
    }
}

#[test]
fn scattering_layers_are_hanrahan_and_krueger() {
    for (depth, albedo, g) in [(0.3, 0.9, 0.0), (2.0, 0.5, 0.6), (0.01, 1.0, -0.3_f64)] {
        let mut by_albedo = white(lobe_kind::HANRAHAN_KRUEGER);
        by_albedo.distribution = layer_parameters::ALBEDO;
        by_albedo.reflectance = Vec3::splat(albedo as f32);
        by_albedo.specular_transmittance = Vec3::splat(depth as f32);
        by_albedo.exponent = g as f32;
        let mut by_depths = by_albedo;
        by_depths.distribution = layer_parameters::DEPTHS;
        by_depths.reflectance = Vec3::splat((albedo * depth) as f32);
        by_depths.specular_transmittance = Vec3::splat(((1.0 - albedo) * depth) as f32);
        let phase = |i: [f64; 3], o: [f64; 3]| {
            let cos = i[0] * o[0] + i[1] * o[1] + i[2] * o[2];
            (1.0 - g * g) / (4.0 * PI) / (1.0 + g * g + 2.0 * g * cos).powf(1.5)
        };
        for lobe in [by_albedo, by_depths] {
            let reflected = |i: [f64; 3], o: [f64; 3]| {
                let lost = (-depth * (1.0 / i[2] + 1.0 / o[2])).exp();
                albedo * phase(i, o) / (i[2] + o[2]) * (1.0 - lost)
            };
            matches(&lobe, reflected, 1e-4);
            for (wi, wo) in pairs() {
                let (i, o) = (wide(wi), wide(-wo));
                let difference = (-depth / i[2]).exp() - (depth / o[2]).exp();
                let expected = albedo * phase(i, o) * difference / (i[2] + o[2]);
                for (wi, wo) in [(wi, -wo), (-wi, wo)] {
                    let f = f64::from(lobe::eval_cosine(&lobe, &[], wi, wo).x / wo.z.abs());
                    // The published form cancels where the cosines are alike.
                    let tolerance = 1e-4 + 1e-7 / (i[2] + o[2]).abs();
                    let error = (f - expected).abs() / expected.max(1e-4);
                    assert!(error < tolerance, "{wi} {wo}: {f}, not {expected}");
                }
            }
            // What is not scattered passes: u = 0 chooses that.
            for wi in [direction_at(0.0, 0.0), direction_at(60.0, 10.0)] {
                let s = lobe::sample(&lobe, &[], wi, 0.0, Vec2::splat(0.5));
                let passed = (-depth / f64::from(wi.z)).exp();
                assert_eq!(s.wo, -wi);
                assert!((f64::from(s.weight.x * s.pdf) - passed).abs() < 1e-6);
            }
        }
    }
}
