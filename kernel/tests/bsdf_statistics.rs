//! Samplers of every scattering model and of mixtures follow their densities: chi-square over the sphere.

mod common;

use common::chi_square::ChiSquare;
use common::coated::coated_cases;
use common::lobes::{Case, incidences, mixtures, smooth_cases, white};
use common::{Random, direction_at};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::{Bsdf, BsdfSample, event, lobe};
use halflight_kernel::scene::lobe_kind;
use std::f32::consts::PI;

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
    samples: u32,
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
        samples,
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

/// Chi-square of the cases of one kind without coats at all incidences.
fn lobes_of_kind_follow(kind: u32) {
    let cases: Vec<Case> = smooth_cases()
        .into_iter()
        .filter(|case| case.lobe.kind == kind && case.lobe.coat_count == 0)
        .collect();
    cases_follow(&cases);
}

fn cases_follow(cases: &[Case]) {
    let family = (cases.len() * incidences().len()) as u32;
    // At least a million per model, though one incidence in four may be black.
    let samples = (4 * 1_000_000 / (3 * family)).max(30_000);
    let (mut tested, mut failures) = (0, Vec::new());
    for case in cases {
        for wi in incidences() {
            tested += u32::from(follows(
                &format!("{}, wi {wi}", case.name),
                family,
                samples,
                |u1, u2| lobe::sample(&case.lobe, &case.data, wi, u1, u2),
                |wo| lobe::pdf(&case.lobe, &case.data, wi, wo),
                &mut failures,
            ));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    // The incidence from below is black for reflecting lobes, and grazing ones for thinner coats.
    assert!(tested >= family * 2 / 3, "{tested} of {family} were tested");
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

#[test]
fn rough_coat_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::ROUGH_COAT);
}

#[test]
fn measured_lobe_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::MERL);
}

#[test]
fn coated_lobes_sample_their_density() {
    let mut cases = coated_cases();
    cases.retain(|case| case.lobe.coat_count > 0);
    cases_follow(&cases);
}

#[test]
fn rough_diffuse_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::ROUGH_DIFFUSE);
}

#[test]
fn diffracting_conductor_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::DIFFRACTING_CONDUCTOR);
}

#[test]
fn phong_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::PHONG);
}

#[test]
fn ward_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::WARD);
}

#[test]
fn diffuse_transmission_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::DIFFUSE_TRANSMISSION);
}

#[test]
fn principled_diffuse_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::PRINCIPLED_DIFFUSE);
}

#[test]
fn sheen_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::SHEEN);
}

#[test]
fn schlick_reflection_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::SCHLICK_REFLECTION);
}

#[test]
fn clearcoat_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::CLEARCOAT);
}

#[test]
fn thin_transmission_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::THIN_TRANSMISSION);
}

#[test]
fn scattering_layer_samples_its_density() {
    lobes_of_kind_follow(lobe_kind::HANRAHAN_KRUEGER);
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
                100_000,
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
