//! Local Beckmann roughness: closed forms per distribution, finite differences, blending with diffuse lobes.

mod common;

use common::lobes::{conductor, white};
use common::measured::table_of;
use common::{Random, direction_at};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::local_roughness::{DIFFUSE_ROUGHNESS, falloff_by_differences};
use halflight_kernel::bsdf::{Bsdf, Lobe, lobe, local_beckmann_roughness};
use halflight_kernel::math::luminance;
use halflight_kernel::scene::{MAX_LOBES, distribution, lobe_kind};

fn bsdf(parts: &[Lobe], wi: Vec3) -> Bsdf {
    let mut lobes = [Lobe::NONE; MAX_LOBES];
    lobes[..parts.len()].copy_from_slice(parts);
    Bsdf::from_lobes(lobes, parts.len() as u32, &[], wi)
}

fn roughness(parts: &[Lobe], wi: Vec3, wo: Vec3) -> f64 {
    f64::from(local_beckmann_roughness(&bsdf(parts, wi), &[], wi, wo))
}

fn glossy(kind: u32, distribution: u32, alpha: f32) -> Lobe {
    let mut l = conductor(kind);
    l.distribution = distribution;
    l.alpha = Vec2::splat(alpha);
    if kind == lobe_kind::ROUGH_DIELECTRIC {
        l.eta = Vec3::splat(1.5);
    }
    l
}

/// The squared slope of the half vector of a reflection.
fn slope_squared(wi: Vec3, wo: Vec3) -> f64 {
    let h = (wi.as_dvec3() + wo.as_dvec3()).normalize();
    (1.0 - h.z * h.z) / (h.z * h.z)
}

/// Checks sigma^2 of a rough conductor against a closed form in alpha^2 and t^2, wherever there is a value.
fn holds(distribution: u32, exponent: f32, closed: impl Fn(f64, f64) -> f64) {
    let mut random = Random(3);
    let mut checked = 0;
    for _ in 0..20_000 {
        let (wi, wo) = (random.upper_direction(), random.upper_direction());
        let mut l = glossy(
            lobe_kind::ROUGH_CONDUCTOR,
            distribution,
            0.05 + 0.9 * random.next_1d(),
        );
        l.exponent = exponent;
        let f = lobe::eval_cosine(&l, &[], wi, wo).max_element();
        if f <= 0.0 {
            continue;
        }
        let (a2, t2) = (f64::from(l.alpha.x).powi(2), slope_squared(wi, wo));
        let (got, want) = (
            roughness(&[l], wi, wo),
            closed(a2, t2).sqrt().min(f64::from(DIFFUSE_ROUGHNESS)),
        );
        assert!(
            (got / want - 1.0).abs() < 2e-4,
            "{distribution} {exponent}: {got} {want} at alpha^2 {a2}, t^2 {t2}"
        );
        checked += 1;
    }
    assert!(checked > 5_000, "{checked}");
}

#[test]
fn beckmann_is_alpha_at_every_angle() {
    holds(distribution::BECKMANN, 1.0, |a2, _| a2);
}

#[test]
fn ggx_grows_with_the_slope() {
    holds(distribution::GGX, 1.0, |a2, t2| 0.5 * (a2 + t2));
}

#[test]
fn phong_has_its_closed_form() {
    holds(distribution::PHONG, 1.0, |a2, t2| {
        a2 * (1.0 + t2) / (1.0 + a2)
    });
}

#[test]
fn exponential_power_has_its_closed_form() {
    for p in [0.25, 0.6, 1.0, 2.0, 4.0_f32] {
        holds(distribution::EXPONENTIAL_POWER, p, |a2, t2| {
            let p = f64::from(p);
            // Cut off beside the pole, see `local_alpha_squared`.
            let s2 = (t2 / a2).max(1e-6);
            a2 * s2.powf(1.0 - p) / p
        });
    }
}

#[test]
fn the_pole_has_its_limit() {
    let wi = direction_at(30.0, 0.0);
    let wo = Vec3::new(-wi.x, -wi.y, wi.z);
    let at = |d: u32| roughness(&[glossy(lobe_kind::ROUGH_CONDUCTOR, d, 0.2)], wi, wo);
    assert!((at(distribution::BECKMANN) - 0.2).abs() < 1e-5);
    assert!((at(distribution::GGX) - 0.2 / 2.0_f64.sqrt()).abs() < 1e-5);
}

#[test]
fn refraction_has_the_roughness_of_its_normals() {
    let l = glossy(lobe_kind::ROUGH_DIELECTRIC, distribution::BECKMANN, 0.3);
    let mut random = Random(5);
    let mut transmitted = 0;
    for _ in 0..2_000 {
        let wi = random.direction();
        let s = lobe::sample(&l, &[], wi, random.next_1d(), random.next_2d());
        if s.pdf > 1e-6 && lobe::eval_cosine(&l, &[], wi, s.wo).x > 0.0 {
            let got = roughness(&[l], wi, s.wo);
            assert!((got - 0.3).abs() < 1e-4, "{wi} {}: {got}", s.wo);
            transmitted += u32::from(wi.z * s.wo.z < 0.0);
        }
    }
    assert!(transmitted > 500);
}

/// The roughness of a GGX lobe grows with the slope of the half vector, so it tells a wrong index in that from the right one.
#[test]
fn refraction_takes_the_generalised_half_vector() {
    let l = glossy(lobe_kind::ROUGH_DIELECTRIC, distribution::GGX, 0.3);
    let mut random = Random(6);
    let mut counts = [0; 3];
    for _ in 0..4_000 {
        let wi = random.direction();
        let s = lobe::sample(&l, &[], wi, random.next_1d(), random.next_2d());
        if !(s.pdf > 1e-6 && lobe::eval_cosine(&l, &[], wi, s.wo).x > 0.0) {
            continue;
        }
        let is_transmitted = wi.z * s.wo.z < 0.0;
        // The index beyond the surface over that on this side: 1.5 from outside.
        let eta = match (is_transmitted, wi.z > 0.0) {
            (false, _) => 1.0,
            (true, true) => 1.5,
            (true, false) => 1.0 / 1.5,
        };
        counts[if !is_transmitted {
            0
        } else {
            1 + usize::from(wi.z > 0.0)
        }] += 1;
        let h = (wi.as_dvec3() + s.wo.as_dvec3() * eta).normalize();
        let t2 = (1.0 - h.z * h.z) / (h.z * h.z);
        let want = (0.5 * (f64::from(0.3f32).powi(2) + t2)).sqrt();
        let got = roughness(&[l], wi, s.wo);
        // Half vectors of directions that hardly bend are rounded.
        assert!(
            (got / want - 1.0).abs() < 2e-3,
            "{wi} {}: {got}, not {want}",
            s.wo
        );
    }
    assert!(counts.iter().all(|n| *n > 200), "{counts:?}");
}

#[test]
fn diffuse_lobes_widen_the_tail_alone() {
    // Figure 2 of the paper: a narrow lobe over a diffuse one, along the lobe at one incidence.
    let mut narrow = glossy(lobe_kind::ROUGH_CONDUCTOR, distribution::BECKMANN, 0.1);
    narrow.weight = 0.9;
    let mut base = white(lobe_kind::DIFFUSE);
    base.weight = 0.1;
    let wi = direction_at(20.0, 0.0);
    let mut last = 0.0;
    for degrees in (-20..70).step_by(5) {
        let wo = direction_at(degrees as f32, 180.0);
        let got = roughness(&[narrow, base], wi, wo);
        let value = |l: &Lobe| f64::from(luminance(lobe::eval_cosine(l, &[], wi, wo)) * l.weight);
        let share = value(&narrow) / (value(&narrow) + value(&base));
        let want = if share > 1e-8 {
            0.1 / share.sqrt()
        } else {
            f64::from(DIFFUSE_ROUGHNESS)
        };
        assert!((got / want - 1.0).abs() < 1e-3, "{degrees}: {got} {want}");
        if degrees >= 20 {
            assert!(got >= last, "{degrees}: {got} after {last}");
            last = got;
        }
    }
    let mirror = Vec3::new(-wi.x, -wi.y, wi.z);
    assert!((roughness(&[narrow, base], wi, mirror) - 0.1).abs() < 1e-3);
    assert!(last > 10.0, "{last}");
}

#[test]
fn rough_plastic_widens_where_its_base_takes_over() {
    let mut l = white(lobe_kind::ROUGH_PLASTIC);
    l.distribution = distribution::BECKMANN;
    l.alpha = Vec2::splat(0.1);
    let wi = direction_at(20.0, 0.0);
    let at = |degrees: f32| roughness(&[l], wi, direction_at(degrees, 180.0));
    assert!((at(20.0) / 0.1 - 1.0).abs() < 0.25, "{}", at(20.0));
    assert!(at(35.0) > 1.3 * at(20.0) && at(60.0) > 10.0 * at(20.0));
}

#[test]
fn discrete_and_diffuse_materials_have_the_extremes() {
    let wi = direction_at(20.0, 0.0);
    let wo = direction_at(40.0, 100.0);
    assert_eq!(roughness(&[conductor(lobe_kind::CONDUCTOR)], wi, wo), 0.0);
    let diffuse = roughness(&[white(lobe_kind::DIFFUSE)], wi, wo);
    assert_eq!(diffuse, f64::from(DIFFUSE_ROUGHNESS));
}

#[test]
fn differences_agree_with_derivatives() {
    // A measured material is only values: those of analytic lobes stand in, whose Fresnel term and masking vary too.
    for (kind, exponent, limit) in [
        (distribution::BECKMANN, 1.0, 0.01),
        (distribution::GGX, 1.0, 0.02),
        (distribution::PHONG, 1.0, 0.01),
        (distribution::EXPONENTIAL_POWER, 0.5, 0.02),
    ] {
        for alpha in [0.02, 0.1, 0.3] {
            let mut l = glossy(lobe_kind::ROUGH_CONDUCTOR, kind, alpha);
            l.exponent = exponent;
            for k in 0..40 {
                let wi = direction_at(25.0, 40.0);
                // Half vectors from 0 to 2 alpha from the normal.
                let m =
                    Vec3::new(0.05 * alpha * k as f32, 0.01 * alpha * k as f32, 1.0).normalize();
                let wo = m * (2.0 * wi.dot(m)) - wi;
                let value = |i: Vec3, o: Vec3| lobe::eval_cosine(&l, &[], i, o).element_sum() / o.z;
                let got = (1.0 / falloff_by_differences(value, wi, wo)).sqrt();
                let want = roughness(&[l], wi, wo) as f32;
                // The narrowest chord, a quarter of a degree, is wide against a narrow lobe that is not Gaussian.
                let chord = 1.5 * (0.0044 / alpha) * (0.0044 / alpha);
                // At the tip of a sharp lobe a chord cannot be as narrow as the derivative.
                let tip = k < 6 && kind == distribution::EXPONENTIAL_POWER;
                assert!(
                    tip || (got / want - 1.0).abs() < limit + chord + 0.25 * alpha * alpha,
                    "{kind} {alpha} {k}: {got} {want}"
                );
            }
        }
    }
}

#[test]
fn a_flat_value_has_no_falloff_to_speak_of() {
    let wi = direction_at(10.0, 0.0);
    let wo = direction_at(50.0, 80.0);
    let rising = |i: Vec3, o: Vec3| 1.0 / (i.z * o.z).powi(4);
    assert_eq!(falloff_by_differences(rising, wi, wo), 0.0);
    let flat = (1.0 / falloff_by_differences(|_, _| 1.0, wi, wo)).sqrt();
    assert!(flat > 0.5, "{flat}");
}

/// The paper's figure 2: measured nickel is narrow at its tip and wide in its tail, and a local Gaussian follows it.
#[test]
fn measured_data_has_the_roughness_of_its_lobe() {
    let alpha2 = 0.15_f32 * 0.15;
    for gaussian in [true, false] {
        let data = table_of(|angles| {
            let t2 = angles.x.tan().powi(2);
            let slopes = if gaussian {
                (-t2 / alpha2).exp()
            } else {
                (1.0 + t2 / alpha2).powi(-2)
            };
            Vec3::splat(slopes / angles.x.cos().powi(4))
        });
        let mut l = white(lobe_kind::MERL);
        l.table = 0;
        let wi = direction_at(15.0, 0.0);
        let mut lobes = [Lobe::NONE; MAX_LOBES];
        lobes[0] = l;
        let bsdf = Bsdf::from_lobes(lobes, 1, &data, wi);
        for degrees in [2.0_f32, 5.0, 8.0, 12.0, 16.0, 20.0] {
            let m = direction_at(degrees, 90.0);
            let wo = m * (2.0 * wi.dot(m)) - wi;
            let got = local_beckmann_roughness(&bsdf, &data, wi, wo);
            let t2 = degrees.to_radians().tan().powi(2);
            let want = if gaussian {
                alpha2
            } else {
                0.5 * (alpha2 + t2)
            }
            .sqrt();
            // Forty cells over the half angle, linear between.
            assert!((got / want - 1.0).abs() < 0.15, "{degrees}: {got} {want}");
        }
    }
}
