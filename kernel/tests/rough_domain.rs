//! Rough models over their whole domain, ends included: finite everywhere, and the energy of those whose fit or borrowed
//! masking does not conserve it, held to the figure that their documentation gives.

mod common;

use common::lobes::{conductor, white};
use common::rough_cases::{diffracting, diffracting_cases};
use common::{direction_at, furnace};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::microfacet::Microfacets;
use halflight_kernel::bsdf::{Bsdf, Lobe, lobe, local_beckmann_roughness, mode};
use halflight_kernel::scene::{MAX_LOBES, distribution, lobe_flag, lobe_kind};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use std::f32::consts::TAU;

/// A conductor that reflects everything.
fn mirror_facets(distribution: u32, alpha: f32) -> Lobe {
    let mut l = conductor(lobe_kind::ROUGH_CONDUCTOR);
    l.eta = Vec3::ZERO;
    l.k = Vec3::ONE;
    l.distribution = distribution;
    l.alpha = Vec2::splat(alpha);
    l
}

/// The largest albedo over incidences.
fn brightest(l: &Lobe) -> f32 {
    let mut worst = 0.0_f32;
    for degrees in [0.0, 30.0, 60.0, 75.0, 85.0, 89.0, 89.9] {
        let (albedo, _) = furnace::albedo(l, &[], direction_at(degrees, 0.0), 30_000, 2);
        worst = worst.max(albedo.x);
    }
    worst
}

#[test]
fn phong_exceeds_one_by_its_borrowed_masking_alone() {
    // The projected area of all Phong facets of alpha 1 (uniform over the hemisphere) at grazing incidence is 1 / 2.
    let facets = Microfacets::new(distribution::PHONG, Vec2::ONE, 1.0);
    let ratio = 0.5 / facets.projected_area(Vec3::X);
    assert!((ratio - 1.772).abs() < 1e-3, "{ratio}");
    let excess = [0.1, 0.3, 0.5, 1.0].map(|a| brightest(&mirror_facets(distribution::PHONG, a)));
    // With its own masking a distribution never returns more than it gets.
    for kind in [distribution::BECKMANN, distribution::GGX] {
        for alpha in [0.1, 0.5, 1.0] {
            let own = brightest(&mirror_facets(kind, alpha));
            assert!(own < 1.0 + 1e-5, "{kind} {alpha}: {own}");
        }
    }
    // Brighter the rougher, as the borrowed projected area falls short of the own.
    let within = [(0.98, 1.01), (0.98, 1.02), (1.04, 1.09), (1.3, 1.4)];
    for (found, (least, most)) in excess.into_iter().zip(within) {
        assert!(found > least && found < most, "{excess:?}");
    }
}

#[test]
fn exponential_power_facets_conserve_energy() {
    for p in [0.2, 0.5, 1.5, 5.0] {
        for alpha in [0.05, 0.5, 1.0] {
            let mut l = mirror_facets(distribution::EXPONENTIAL_POWER, alpha);
            l.exponent = p;
            let got = brightest(&l);
            // Sampling noise of the V-cavity weights, and the area's 2.5e-4.
            assert!(got < 1.005, "{p} {alpha}: {got}");
        }
    }
}

#[test]
fn oren_nayar_is_lambert_when_smooth_and_its_fit_exceeds_one_by_four_percent() {
    let mut l = white(lobe_kind::ROUGH_DIFFUSE);
    let lambert = white(lobe_kind::DIFFUSE);
    l.alpha = Vec2::ZERO;
    let (wi, wo) = (direction_at(50.0, 10.0), direction_at(70.0, 200.0));
    assert_eq!(
        lobe::eval_cosine(&l, &[], wi, wo),
        lobe::eval_cosine(&lambert, &[], wi, wo)
    );
    let mut worst = 0.0_f32;
    for alpha in [0.1, 0.3, 0.6, 1.0] {
        l.alpha = Vec2::splat(alpha);
        worst = worst.max(brightest(&l));
    }
    assert!(worst > 1.03 && worst < 1.05, "{worst}");
}

#[test]
fn coats_widen_the_local_roughness_by_refraction() {
    // The half vector's slope at which the outer value falls by e is the inner one's, seen through the coat.
    let mut l = mirror_facets(distribution::BECKMANN, 0.1);
    l.coat_count = 1;
    l.coats[0].eta = 1.5;
    let wi = direction_at(10.0, 0.0);
    let bsdf = {
        let mut lobes = [Lobe::NONE; MAX_LOBES];
        lobes[0] = l;
        Bsdf::from_lobes(lobes, 1, &[], wi)
    };
    for degrees in [2.0_f32, 12.0, 20.0, 30.0] {
        let wo = direction_at(degrees, 180.0);
        let got = local_beckmann_roughness(&bsdf, &[], wi, wo);
        // 1 / sigma^2 = -d ln f / d(t^2), where f varies by D alone: the transmission and the Jacobian are slow.
        let inner = |degrees: f32| {
            let bend = |w: Vec3| {
                let (x, y) = (w.x / 1.5, w.y / 1.5);
                Vec3::new(x, y, (1.0 - x * x - y * y).sqrt())
            };
            let (i, o) = (wi, direction_at(degrees, 180.0));
            let slope2 = |h: Vec3| (h.x * h.x + h.y * h.y) / (h.z * h.z);
            (slope2(bend(i) + bend(o)), slope2(i + o))
        };
        let (a, b) = (inner(degrees - 0.5), inner(degrees + 0.5));
        let want = 0.1 * ((b.1 - a.1) / (b.0 - a.0)).sqrt();
        assert!((got / want - 1.0).abs() < 0.03, "{degrees}: {got} {want}");
    }
}

fn any_direction() -> impl Strategy<Value = Vec3> {
    let unit = (-1.0_f32..=1.0, 0.0_f32..TAU).prop_map(|(z, phi)| {
        let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    });
    let grazing =
        (-1e-6_f32..=1e-6, 0.0_f32..TAU).prop_map(|(z, phi)| Vec3::new(phi.cos(), phi.sin(), z));
    prop_oneof![6 => unit, 3 => grazing, 1 => Just(Vec3::Z), 1 => Just(-Vec3::Z), 1 => Just(Vec3::X)]
}

/// Finite and not negative: value, density, sample and local roughness.
fn is_total(l: &Lobe, data: &[f32], wi: Vec3, wo: Vec3, u: [f32; 3]) -> Result<(), TestCaseError> {
    let mut lobes = [Lobe::NONE; MAX_LOBES];
    lobes[0] = *l;
    lobes[1] = white(lobe_kind::DIFFUSE);
    let bsdf = Bsdf::from_lobes(lobes, 2, data, wi);
    let roughness = local_beckmann_roughness(&bsdf, data, wi, wo);
    prop_assert!((0.0..=1e3).contains(&roughness), "roughness {roughness}");
    let (f, p) = lobe::eval_cosine_pdf(l, data, wi, wo);
    prop_assert!(f.is_finite() && f.min_element() >= 0.0, "f {f}");
    prop_assert!(p.is_finite() && p >= 0.0, "pdf {p}");
    let s = lobe::sample(l, data, wi, u[0], Vec2::new(u[1], u[2]));
    prop_assert!(s.pdf.is_finite() && s.pdf >= 0.0, "{s:?}");
    if s.pdf > 0.0 {
        prop_assert!(
            s.weight.is_finite() && s.weight.min_element() >= 0.0,
            "{s:?}"
        );
        prop_assert!((s.wo.length() - 1.0).abs() < 1e-4 && s.eta > 0.0, "{s:?}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 8_000,
        rng_seed: proptest::test_runner::RngSeed::Fixed(3),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn rough_lobes_are_total(
        kind in prop_oneof![Just(lobe_kind::ROUGH_CONDUCTOR), Just(lobe_kind::ROUGH_DIELECTRIC), Just(lobe_kind::ROUGH_DIFFUSE)],
        distribution in 0_u32..4,
        exponent in prop_oneof![Just(0.0_f32), Just(0.2), Just(5.0), 0.0_f32..8.0],
        alpha in prop::array::uniform2(prop_oneof![Just(0.0_f32), Just(1.0), 0.0_f32..=1.0, (-5.0_f32..0.0).prop_map(|e| 10.0_f32.powf(e))]),
        eta in prop_oneof![Just(1.0_f32), Just(1.0 + 1e-7), 0.999_f32..1.001, 0.333_f32..3.0],
        rho in prop_oneof![Just(0.0_f32), Just(1.0), 0.0_f32..=1.0],
        all_normals: bool, importance: bool,
        wi in any_direction(), wo in any_direction(),
        u in prop::array::uniform3(prop_oneof![Just(0.0_f32), Just(0.999_999_94), 0.0_f32..1.0]),
    ) {
        let mut l = white(kind);
        l.distribution = distribution;
        l.exponent = exponent;
        l.alpha = Vec2::from(alpha);
        l.eta = Vec3::splat(eta);
        l.k = Vec3::splat(if kind == lobe_kind::ROUGH_CONDUCTOR { rho * 4.0 } else { 0.0 });
        l.reflectance = Vec3::splat(rho);
        if all_normals {
            l.flags |= lobe_flag::SAMPLE_ALL_NORMALS;
        }
        if importance {
            l.mode = mode::IMPORTANCE;
        }
        is_total(&l, &[], wi, wo, u)?;
        // The mirror direction, where narrow lobes are.
        is_total(&l, &[], wi, Vec3::new(-wi.x, -wi.y, wi.z), u)?;
    }
}

#[test]
fn diffracting_conductors_are_total() {
    let mut cases = diffracting_cases();
    // The corners of the plugin's domain.
    cases.push(diffracting(1.0, 0.2, 10.0, 0.01, 1.01));
    cases.push(diffracting(1e-3, 5.0, 10.0, 1e3, 6.0));
    let strategy = (
        any_direction(),
        any_direction(),
        prop::array::uniform3(0.0_f32..1.0),
    );
    for case in &cases {
        let mut runner = proptest::test_runner::TestRunner::deterministic();
        for _ in 0..4_000 {
            let (wi, wo, u) = strategy.new_tree(&mut runner).expect("a value").current();
            is_total(&case.lobe, &case.data, wi, wo, u)
                .unwrap_or_else(|e| panic!("{}: {e} at {wi} {wo}", case.name));
        }
    }
}

/// Nearly opposite directions in the horizon, whose half vector is made of rounding errors: where a lobe has a value it has a
/// density, or a sample there would weigh as much as `f32` holds.
#[test]
fn opposite_directions_in_the_horizon_have_both_value_and_density() {
    let mut random = common::Random(11);
    let mut degenerate = 0;
    for i in 0..200_000 {
        let mut l = match i % 3 {
            0 => conductor(lobe_kind::ROUGH_CONDUCTOR),
            1 => white(lobe_kind::ROUGH_COAT),
            _ => white(lobe_kind::ROUGH_PLASTIC),
        };
        l.distribution = i % 4;
        l.alpha = Vec2::splat(10f32.powf(-2.0 * random.next_1d()));
        let height = |random: &mut common::Random| 10f32.powf(-3.0 - 5.0 * random.next_1d());
        let phi = TAU * random.next_1d();
        let wi = Vec3::new(phi.cos(), phi.sin(), height(&mut random)).normalize();
        let away = random.direction() * 10f32.powf(-6.0 - 2.0 * random.next_1d());
        let wo = Vec3::new(-wi.x + away.x, -wi.y + away.y, height(&mut random)).normalize();
        let (f, pdf) = lobe::eval_cosine_pdf(&l, &[], wi, wo);
        degenerate += u32::from((wi + wo).normalize_or_zero().dot(wi) <= 0.0);
        assert!(f.is_finite() && pdf.is_finite());
        // Plastic has its base's density everywhere: what the coating adds must not dwarf it.
        let weight = if pdf > 0.0 {
            f.max_element() / pdf
        } else {
            0.0
        };
        assert!(
            weight < 100.0 && (f == Vec3::ZERO || pdf > 0.0),
            "{l:?} {wi} {wo}: {f} {pdf}"
        );
    }
    assert!(degenerate > 100, "{degenerate}");
}
