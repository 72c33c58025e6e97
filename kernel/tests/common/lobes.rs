//! The lobes and mixtures that the statistical tests go through.

use super::coated::{coated_cases, under_two_coats};
use super::direction_at;
use super::measured::measured_case;
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::Lobe;
use halflight_kernel::bsdf::fresnel::fresnel_diffuse_reflectance;
use halflight_kernel::bsdf::rough_transmittance::{self, ENTRIES, ROW};
use halflight_kernel::math::Frame;
use halflight_kernel::scene::{MAX_LOBES, distribution, lobe_flag, lobe_kind};

/// A lobe under test with the table that it reads.
#[derive(Clone)]
pub struct Case {
    /// For messages.
    pub name: String,
    /// The lobe.
    pub lobe: Lobe,
    /// What it reads.
    pub data: Vec<f32>,
}

/// A lobe of a kind, white, on both sides, between air and glass.
pub fn white(kind: u32) -> Lobe {
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

/// A white lobe of microfacets, or a smooth one that ignores them.
pub fn specular(kind: u32, distribution: u32, alpha: Vec2, eta: f32) -> Lobe {
    Lobe {
        distribution,
        eta: Vec3::splat(eta),
        k: Vec3::splat(2.0),
        alpha,
        ..white(kind)
    }
}

/// A lobe without a table.
pub fn case(name: &str, lobe: Lobe) -> Case {
    Case {
        name: name.into(),
        lobe,
        data: Vec::new(),
    }
}

/// A gold-like conductor, smooth or rough.
pub fn conductor(kind: u32) -> Lobe {
    let mut lobe = white(kind);
    lobe.eta = Vec3::new(0.143, 0.375, 1.442);
    lobe.k = Vec3::new(3.983, 2.386, 1.603);
    lobe
}

/// Lobes with a density, over kinds, distributions and roughnesses.
pub fn smooth_cases() -> Vec<Case> {
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
                let mut data = vec![0.0; ROW];
                rough_transmittance::fill_row(kind, alpha.x, 1.5, &mut data);
                lobe.internal_reflectance = data[ENTRIES];
                cases.push(Case {
                    name: name("rough plastic"),
                    lobe,
                    data,
                });
            }
        }
    }
    cases.extend(coated_cases());
    cases.push(measured_case());
    cases.extend(super::rough_cases::cases());
    cases
}

/// Rough lobes with the distributions that the paper bounds, not so narrow that quadrature has trouble.
pub fn rough_cases() -> Vec<Case> {
    let mut cases: Vec<Case> = smooth_cases();
    cases.retain(|c| {
        let lobe = &c.lobe;
        let kind = lobe.kind == lobe_kind::ROUGH_CONDUCTOR
            || lobe.kind == lobe_kind::ROUGH_DIELECTRIC
            || lobe.kind == lobe_kind::ROUGH_PLASTIC;
        let bounded =
            lobe.distribution == distribution::BECKMANN || lobe.distribution == distribution::GGX;
        kind && bounded && lobe.alpha.min_element() >= 0.05 && lobe.coat_count == 0
    });
    assert!(cases.len() >= 10, "{}", cases.len());
    cases
}

/// Lobes of discrete directions.
pub fn delta_cases() -> Vec<Case> {
    vec![
        case("coat", white(lobe_kind::COAT)),
        case(
            "conductor under two coats",
            under_two_coats(conductor(lobe_kind::CONDUCTOR)),
        ),
        case("conductor", conductor(lobe_kind::CONDUCTOR)),
        case("dielectric", white(lobe_kind::DIELECTRIC)),
        case("thin dielectric", white(lobe_kind::THIN_DIELECTRIC)),
        case("null", white(lobe_kind::NULL)),
    ]
}

/// Incidences from both sides, normal to grazing.
pub fn incidences() -> [Vec3; 4] {
    [
        direction_at(0.0, 0.0),
        direction_at(50.0, 25.0),
        direction_at(85.0, 110.0),
        direction_at(130.0, 300.0),
    ]
}

/// A mixture with a mask, a mirror and three smooth lobes.
pub fn mixture() -> ([Lobe; MAX_LOBES], u32) {
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
pub fn mixtures() -> Vec<(&'static str, [Lobe; MAX_LOBES], u32)> {
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
