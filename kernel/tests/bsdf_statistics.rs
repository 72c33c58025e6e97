//! Every scattering model and their mixtures as distributions: samplers follow their densities, weights agree with
//! values, no lobe creates light, and reflection is symmetric.

mod common;

use common::chi_square::ChiSquare;
use common::{Random, direction_at, furnace};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::fresnel::fresnel_diffuse_reflectance;
use halflight_kernel::bsdf::rough_plastic::{
    TRANSMITTANCE_ENTRIES, fill_rough_transmittance, rough_internal_reflectance,
};
use halflight_kernel::bsdf::{Bsdf, BsdfSample, Lobe, MAX_LOBES, event, lobe, mode};
use halflight_kernel::math::Frame;
use halflight_kernel::scene::{distribution, lobe_flag, lobe_kind};
use proptest::prelude::*;
use std::f32::consts::{PI, TAU};

/// A lobe under test with the table that it reads.
struct Case {
    name: String,
    lobe: Lobe,
    data: Vec<f32>,
}

fn white(kind: u32) -> Lobe {
    let mut lobe = Lobe::NONE;
    lobe.kind = kind;
    lobe.weight = 1.0;
    lobe.flags = lobe_flag::FRONT | lobe_flag::BACK;
    lobe.reflectance = Vec3::ONE;
    lobe.specular_reflectance = Vec3::ONE;
    lobe.specular_transmittance = Vec3::ONE;
    lobe.eta = Vec3::splat(1.5);
    lobe
}

fn case(name: &str, lobe: Lobe) -> Case {
    Case {
        name: name.into(),
        lobe,
        data: Vec::new(),
    }
}

fn conductor(kind: u32) -> Lobe {
    let mut lobe = white(kind);
    lobe.eta = Vec3::new(0.143, 0.375, 1.442);
    lobe.k = Vec3::new(3.983, 2.386, 1.603);
    lobe
}

/// Lobes with a density, over kinds, distributions and roughnesses.
fn smooth_cases() -> Vec<Case> {
    let mut cases = vec![case("diffuse", white(lobe_kind::DIFFUSE))];
    for nonlinear in [false, true] {
        let mut lobe = white(lobe_kind::PLASTIC);
        lobe.reflectance = Vec3::new(0.9, 0.5, 0.1);
        lobe.internal_reflectance = fresnel_diffuse_reflectance(1.0 / 1.5);
        if nonlinear {
            lobe.flags |= lobe_flag::NONLINEAR;
        }
        cases.push(case(
            if nonlinear {
                "plastic nonlinear"
            } else {
                "plastic"
            },
            lobe,
        ));
    }
    for kind in [distribution::BECKMANN, distribution::GGX] {
        for alpha in [Vec2::splat(0.05), Vec2::splat(0.4), Vec2::new(0.1, 0.5)] {
            let name = |model: &str| format!("{model}, distribution {kind}, alpha {alpha}");
            let mut lobe = conductor(lobe_kind::ROUGH_CONDUCTOR);
            lobe.distribution = kind;
            lobe.alpha = alpha;
            cases.push(case(&name("rough conductor"), lobe));
            lobe.flags |= lobe_flag::SAMPLE_ALL_NORMALS;
            if alpha.x == 0.4 {
                cases.push(case(&name("rough conductor by all normals"), lobe));
            }
            for eta in [1.5, 1.0 / 1.33] {
                let mut lobe = white(lobe_kind::ROUGH_DIELECTRIC);
                lobe.distribution = kind;
                lobe.alpha = alpha;
                lobe.eta = Vec3::splat(eta);
                cases.push(case(
                    &format!("{}, eta {eta}", name("rough dielectric")),
                    lobe,
                ));
            }
            if alpha.x == alpha.y {
                let mut lobe = white(lobe_kind::ROUGH_PLASTIC);
                lobe.distribution = kind;
                lobe.alpha = alpha;
                lobe.flags |= lobe_flag::NONLINEAR;
                lobe.reflectance = Vec3::new(0.2, 0.5, 0.8);
                cases.push(case(
                    &name("rough plastic without a table"),
                    Lobe {
                        internal_reflectance: fresnel_diffuse_reflectance(1.0 / 1.5),
                        ..lobe
                    },
                ));
                lobe.table = 0;
                lobe.internal_reflectance = rough_internal_reflectance(kind, alpha.x, 1.5);
                let mut data = vec![0.0; TRANSMITTANCE_ENTRIES];
                fill_rough_transmittance(kind, alpha.x, 1.5, &mut data);
                cases.push(Case {
                    name: name("rough plastic"),
                    lobe,
                    data,
                });
            }
        }
    }
    cases
}

/// Lobes of discrete directions.
fn delta_cases() -> Vec<Case> {
    vec![
        case("conductor", conductor(lobe_kind::CONDUCTOR)),
        case("dielectric", white(lobe_kind::DIELECTRIC)),
        case("thin dielectric", white(lobe_kind::THIN_DIELECTRIC)),
        case("null", white(lobe_kind::NULL)),
    ]
}

/// Incidences from both sides, normal to grazing.
fn incidences() -> [Vec3; 4] {
    [
        direction_at(0.0, 0.0),
        direction_at(50.0, 25.0),
        direction_at(85.0, 110.0),
        direction_at(130.0, 300.0),
    ]
}

/// The mean direction of smooth samples, where the cells of a chi-square test should be fine.
fn pole(mut sample: impl FnMut(&mut Random) -> BsdfSample) -> Option<Vec3> {
    let mut random = Random(77);
    let mut best = (0.0, None);
    for _ in 0..200 {
        let s = sample(&mut random);
        if s.pdf > best.0 && s.event & event::DELTA == 0 {
            best = (s.pdf, Some(s.wo));
        }
    }
    best.1
}

/// Chi-square of a sampler of [`BsdfSample`]s against a density; nothing where it never has a smooth sample.
fn follows(
    name: &str,
    family: u32,
    sample: impl Fn(f32, Vec2) -> BsdfSample,
    pdf: impl Fn(Vec3) -> f32,
    failures: &mut Vec<String>,
) -> bool {
    let draw = |random: &mut Random| {
        let u1 = random.next_1d();
        sample(u1, random.next_2d())
    };
    let Some(pole) = pole(draw) else {
        return false;
    };
    let test = ChiSquare {
        samples: 50_000,
        pole,
        family,
        seed: 5,
    };
    let result = test.run(
        |random| {
            let s = draw(random);
            (s.pdf > 0.0 && s.event & event::DELTA == 0).then_some(s.wo)
        },
        &pdf,
    );
    if let Err(reason) = result {
        failures.push(format!("{name}: {reason}"));
    }
    true
}

/// Chi-square of the cases of one kind at all incidences.
fn lobes_of_kind_follow(kind: u32) {
    let cases: Vec<Case> = smooth_cases()
        .into_iter()
        .filter(|case| case.lobe.kind == kind)
        .collect();
    let family = (cases.len() * incidences().len()) as u32;
    let (mut tested, mut failures) = (0, Vec::new());
    for case in &cases {
        for wi in incidences() {
            tested += u32::from(follows(
                &format!("{}, wi {wi}", case.name),
                family,
                |u1, u2| lobe::sample(&case.lobe, &case.data, wi, u1, u2),
                |wo| lobe::pdf(&case.lobe, &case.data, wi, wo),
                &mut failures,
            ));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    // The incidence from below is black for reflecting lobes.
    assert!(tested >= family * 3 / 4, "{tested} of {family} were tested");
}

#[test]
fn diffuse_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::DIFFUSE);
}

#[test]
fn plastic_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::PLASTIC);
}

#[test]
fn rough_conductor_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::ROUGH_CONDUCTOR);
}

#[test]
fn rough_dielectric_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::ROUGH_DIELECTRIC);
}

#[test]
fn rough_plastic_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::ROUGH_PLASTIC);
}

/// A mixture with a mask, a mirror and three smooth lobes.
fn mixture() -> ([Lobe; MAX_LOBES], u32) {
    let mut lobes = [Lobe::NONE; MAX_LOBES];
    lobes[0] = white(lobe_kind::NULL);
    lobes[0].weight = 0.2;
    lobes[1] = white(lobe_kind::DIFFUSE);
    lobes[1].weight = 0.3;
    lobes[2] = conductor(lobe_kind::ROUGH_CONDUCTOR);
    lobes[2].alpha = Vec2::splat(0.2);
    lobes[2].distribution = distribution::GGX;
    lobes[2].weight = 0.2;
    lobes[3] = white(lobe_kind::ROUGH_DIELECTRIC);
    lobes[3].alpha = Vec2::splat(0.4);
    lobes[3].weight = 0.2;
    lobes[4] = conductor(lobe_kind::CONDUCTOR);
    lobes[4].weight = 0.1;
    (lobes, 5)
}

/// Mixtures: plain, two-sided, and with perturbed frames.
fn mixtures() -> Vec<(&'static str, [Lobe; MAX_LOBES], u32)> {
    let (lobes, count) = mixture();
    let mut two_sided = lobes;
    let mut perturbed = lobes;
    for lobe in &mut two_sided[1..3] {
        lobe.flags |= lobe_flag::FLIP_BACK;
    }
    for lobe in &mut perturbed[1..5] {
        lobe.flags |= lobe_flag::FLIP_BACK;
        lobe.frame = Frame::from_normal(Vec3::new(0.3, -0.2, 0.9).normalize());
        lobe.has_frame = true;
    }
    vec![
        ("mixture", lobes, count),
        ("two-sided mixture", two_sided, count),
        ("mixture in a perturbed frame", perturbed, count),
    ]
}

#[test]
fn mixtures_sample_their_density() {
    let mixtures = mixtures();
    let family = (mixtures.len() * incidences().len()) as u32;
    let (mut tested, mut failures) = (0, Vec::new());
    for (name, lobes, count) in &mixtures {
        for wi in incidences() {
            let bsdf = Bsdf::from_lobes(*lobes, *count, &[], wi);
            tested += u32::from(follows(
                &format!("{name}, wi {wi}"),
                family,
                |u1, u2| bsdf.sample(&[], wi, u1, u2),
                |wo| bsdf.pdf(&[], wi, wo),
                &mut failures,
            ));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(tested >= family - 1, "{tested} of {family} were tested");
}

#[test]
fn a_wrong_density_is_rejected() {
    let lobe = white(lobe_kind::DIFFUSE);
    let wi = direction_at(40.0, 0.0);
    let test = ChiSquare {
        samples: 60_000,
        pole: Vec3::Z,
        family: 1,
        seed: 3,
    };
    let run = |pdf: &dyn Fn(Vec3) -> f32| {
        test.run(
            |random| {
                let u1 = random.next_1d();
                Some(lobe::sample(&lobe, &[], wi, u1, random.next_2d()).wo)
            },
            pdf,
        )
    };
    let right = |wo: Vec3| lobe::pdf(&lobe, &[], wi, wo);
    assert!(run(&right).is_ok());
    // Another shape of the same mass, three per cent of mass missing, samples where there is no density, too much mass.
    assert!(run(&|wo| if wo.z > 0.0 { 0.5 / PI } else { 0.0 }).is_err());
    assert!(run(&|wo| 0.97 * right(wo)).is_err());
    assert!(run(&|wo| if wo.x > 0.95 { 0.0 } else { right(wo) }).is_err());
    assert!(run(&|wo| 1.01 * right(wo)).is_err());
    // A slight tilt: five per cent more on one side than on the other.
    assert!(run(&|wo| right(wo) * (1.0 + 0.05 * wo.x.signum())).is_err());
}

/// Weight times density against the value, and the density against `pdf`, over random numbers; the largest relative error.
fn inconsistency(
    sample: impl Fn(f32, Vec2) -> BsdfSample,
    eval_cosine_pdf: impl Fn(Vec3) -> (Vec3, f32),
) -> f32 {
    let mut random = Random(9);
    let mut worst = 0.0_f32;
    for _ in 0..2_000 {
        let u1 = random.next_1d();
        let s = sample(u1, random.next_2d());
        assert!(
            s.weight.is_finite() && s.pdf.is_finite() && s.pdf >= 0.0,
            "{s:?}"
        );
        if s.pdf <= 0.0 {
            continue;
        }
        assert!((s.wo.length() - 1.0).abs() < 1e-5, "{s:?}");
        assert!(s.weight.min_element() >= 0.0, "{s:?}");
        if s.event & event::DELTA != 0 {
            assert!(s.pdf <= 1.0 + 1e-6, "{s:?}");
            continue;
        }
        let (f, p) = eval_cosine_pdf(s.wo);
        worst = worst.max((p - s.pdf).abs() / s.pdf);
        for c in 0..3 {
            let value = s.weight[c] * s.pdf;
            worst = worst.max((value - f[c]).abs() / value.max(1e-4 * s.pdf));
        }
    }
    worst
}

#[test]
fn samples_agree_with_value_and_density() {
    for case in smooth_cases().iter().chain(&delta_cases()) {
        // The half vector of two f32 directions is good to some 1e-6, which a peak of width alpha magnifies.
        let tolerance =
            2e-5 + 5e-5 / (case.lobe.alpha.min_element() * case.lobe.alpha.min_element());
        for wi in incidences() {
            let worst = inconsistency(
                |u1, u2| lobe::sample(&case.lobe, &case.data, wi, u1, u2),
                |wo| {
                    let both = lobe::eval_cosine_pdf(&case.lobe, &case.data, wi, wo);
                    assert_eq!(both.0, lobe::eval_cosine(&case.lobe, &case.data, wi, wo));
                    assert_eq!(both.1, lobe::pdf(&case.lobe, &case.data, wi, wo));
                    both
                },
            );
            assert!(
                worst < tolerance,
                "{}, wi {wi}: {worst} of {tolerance}",
                case.name
            );
        }
    }
    for (name, lobes, count) in mixtures() {
        for wi in incidences() {
            let bsdf = Bsdf::from_lobes(lobes, count, &[], wi);
            let worst = inconsistency(
                |u1, u2| bsdf.sample(&[], wi, u1, u2),
                |wo| {
                    let (f, p) = bsdf.eval_cosine_pdf(&[], wi, wo);
                    assert_eq!(f, bsdf.eval_cosine(&[], wi, wo));
                    assert_eq!(p, bsdf.pdf(&[], wi, wo));
                    (f, p)
                },
            );
            assert!(worst < 2e-3, "{name}, wi {wi}: {worst}");
        }
    }
}

#[test]
fn no_lobe_creates_light() {
    for case in smooth_cases().iter().chain(&delta_cases()) {
        // Linear plastics are brighter than physical by definition.
        let linear =
            case.lobe.kind == lobe_kind::PLASTIC && case.lobe.flags & lobe_flag::NONLINEAR == 0;
        // Energy is conserved without the scaling of radiance by 1 / eta^2.
        let lobe = Lobe {
            mode: mode::IMPORTANCE,
            ..case.lobe
        };
        for wi in incidences() {
            let (albedo, error) = furnace::albedo(&lobe, &case.data, wi, 10_000, 21);
            let excess = (albedo - error * 5.0).max_element();
            assert!(
                linear || excess <= 1.0 + 1e-4,
                "{}, wi {wi}: {albedo} +- {error}",
                case.name
            );
        }
    }
}

#[test]
fn lossless_lobes_return_all_light() {
    let mut plastic = white(lobe_kind::PLASTIC);
    plastic.internal_reflectance = fresnel_diffuse_reflectance(1.0 / 1.5);
    plastic.flags |= lobe_flag::NONLINEAR;
    let mut cases = vec![
        case("diffuse", white(lobe_kind::DIFFUSE)),
        case("nonlinear plastic", plastic),
        case("dielectric", white(lobe_kind::DIELECTRIC)),
        case("thin dielectric", white(lobe_kind::THIN_DIELECTRIC)),
        case("null", white(lobe_kind::NULL)),
    ];
    for case in &mut cases {
        case.lobe.mode = mode::IMPORTANCE;
        for wi in &incidences()[..3] {
            let (albedo, error) = furnace::albedo(&case.lobe, &[], *wi, 40_000, 4);
            let miss = ((albedo - Vec3::ONE).abs() - error * 5.0).max_element();
            assert!(miss < 2e-5, "{}, wi {wi}: {albedo} +- {error}", case.name);
        }
    }
}

#[test]
fn lobes_are_reciprocal() {
    for case in smooth_cases() {
        let asymmetry = furnace::asymmetry(&case.lobe, &case.data, 4_000, 8);
        assert!(asymmetry < 2e-2, "{}: {asymmetry}", case.name);
    }
}

#[test]
fn mixtures_weigh_their_parts() {
    // Lossless parts whose weights sum to one return all light, discrete parts included.
    let mut lobes = [Lobe::NONE; MAX_LOBES];
    lobes[0] = white(lobe_kind::NULL);
    lobes[1] = white(lobe_kind::DIFFUSE);
    lobes[2] = white(lobe_kind::DIELECTRIC);
    lobes[3] = white(lobe_kind::PLASTIC);
    lobes[3].internal_reflectance = fresnel_diffuse_reflectance(1.0 / 1.5);
    lobes[3].flags |= lobe_flag::NONLINEAR;
    for (lobe, weight) in lobes.iter_mut().zip([0.15, 0.35, 0.3, 0.2]) {
        lobe.mode = mode::IMPORTANCE;
        lobe.weight = weight;
    }
    for wi in &incidences()[..3] {
        let bsdf = Bsdf::from_lobes(lobes, 4, &[], *wi);
        let mut random = Random(6);
        let (mut sum, mut squares) = (0.0_f64, 0.0_f64);
        let n = 40_000;
        for _ in 0..n {
            let u1 = random.next_1d();
            let s = bsdf.sample(&[], *wi, u1, random.next_2d());
            let w = if s.pdf > 0.0 {
                f64::from(s.weight.x)
            } else {
                0.0
            };
            sum += w;
            squares += w * w;
        }
        let mean = sum / f64::from(n);
        let error = ((squares / f64::from(n) - mean * mean).max(0.0) / f64::from(n)).sqrt();
        assert!(
            (mean - 1.0).abs() < 5.0 * error + 2e-5,
            "wi {wi}: {mean} +- {error}"
        );
    }
}

/// Directions of every kind, grazing and axis-aligned ones among them.
fn any_direction() -> impl Strategy<Value = Vec3> {
    let unit = (-1.0_f32..=1.0, 0.0_f32..TAU).prop_map(|(z, phi)| {
        let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        Vec3::new(r * phi.cos(), r * phi.sin(), z)
    });
    let grazing =
        (-1e-6_f32..=1e-6, 0.0_f32..TAU).prop_map(|(z, phi)| Vec3::new(phi.cos(), phi.sin(), z));
    prop_oneof![6 => unit, 2 => grazing, 1 => Just(Vec3::Z), 1 => Just(-Vec3::Z), 1 => Just(Vec3::X)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    /// Every function is finite and non-negative for every kind, roughness, index and pair of directions.
    #[test]
    fn lobes_are_total(
        kind in 0_u32..=lobe_kind::NULL, distribution in 0_u32..2, flags in 0_u32..32,
        log_alpha in prop::array::uniform2(-4.0_f32..0.3), log_eta in -1.0_f32..1.0, k in 0.0_f32..10.0,
        rho in prop::array::uniform3(0.0_f32..=1.0), internal in 0.0_f32..1.0, frame in any_direction(),
        has_frame: bool, wi in any_direction(), wo in any_direction(), u in prop::array::uniform3(0.0_f32..1.0),
    ) {
        let mut lobe = white(kind);
        lobe.distribution = distribution;
        lobe.flags = flags;
        lobe.alpha = Vec2::new(10.0_f32.powf(log_alpha[0]), 10.0_f32.powf(log_alpha[1]));
        lobe.eta = Vec3::splat(10.0_f32.powf(log_eta));
        lobe.k = Vec3::splat(k);
        lobe.reflectance = Vec3::from(rho);
        lobe.internal_reflectance = internal;
        lobe.frame = Frame::from_normal(frame.normalize());
        lobe.has_frame = has_frame;
        let (f, p) = lobe::eval_cosine_pdf(&lobe, &[], wi, wo);
        prop_assert!(f.is_finite() && f.min_element() >= 0.0, "f {f}");
        prop_assert!(p.is_finite() && p >= 0.0, "pdf {p}");
        let s = lobe::sample(&lobe, &[], wi, u[0], Vec2::new(u[1], u[2]));
        prop_assert!(s.pdf.is_finite() && s.pdf >= 0.0, "{s:?}");
        if s.pdf > 0.0 {
            prop_assert!(s.weight.is_finite() && s.weight.min_element() >= 0.0, "{s:?}");
            prop_assert!((s.wo.length() - 1.0).abs() < 1e-4 && s.eta > 0.0, "{s:?}");
        }
        let albedo = lobe::albedo(&lobe, &[], wi);
        prop_assert!(albedo.is_finite() && albedo.max_element() <= 1.0 + 1e-5, "{albedo}");
    }
}
