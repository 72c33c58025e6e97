//! Lobes with layers: absorbing plastics, rough coats, and bases under one or two coats.

use super::lobes::{Case, case, conductor, white};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::fresnel::fresnel_diffuse_reflectance;
use halflight_kernel::bsdf::rough_transmittance::{ENTRIES, ROW, ROWS, fill, fill_row};
use halflight_kernel::bsdf::{Coat, Lobe};
use halflight_kernel::math::Frame;
use halflight_kernel::scene::{distribution, lobe_flag, lobe_kind};

/// A coat of an index with a little coloured absorption.
pub fn coat(eta: f32) -> Coat {
    Coat {
        eta,
        optical_depth: Vec3::new(0.02, 0.2, 0.6),
        ..Coat::NONE
    }
}

/// `lobe` under one coat.
pub fn under_coat(mut lobe: Lobe, coat: Coat) -> Lobe {
    lobe.coat_count = 1;
    lobe.coats[0] = coat;
    lobe
}

/// `lobe` under two coats.
pub fn under_two_coats(mut lobe: Lobe) -> Lobe {
    lobe.coat_count = 2;
    lobe.coats = [coat(1.3), coat(1.4)];
    lobe
}

/// All of them.
pub fn coated_cases() -> Vec<Case> {
    let mut rough = conductor(lobe_kind::ROUGH_CONDUCTOR);
    rough.distribution = distribution::GGX;
    rough.alpha = Vec2::splat(0.3);
    let mut plastic = white(lobe_kind::PLASTIC);
    plastic.reflectance = Vec3::new(0.9, 0.5, 0.1);
    plastic.internal_reflectance = fresnel_diffuse_reflectance(1.0 / 1.5);
    plastic.flags |= lobe_flag::NONLINEAR;
    let mut absorbing = plastic;
    absorbing.optical_depth = Vec3::new(0.1, 0.5, 1.0);
    let mut cases = vec![
        case("absorbing plastic", absorbing),
        case(
            "diffuse under a coat",
            under_coat(white(lobe_kind::DIFFUSE), coat(1.5)),
        ),
        // Total reflection on the way in.
        case(
            "diffuse under a thinner coat",
            under_coat(white(lobe_kind::DIFFUSE), coat(0.8)),
        ),
        case(
            "diffuse under a dye",
            under_coat(white(lobe_kind::DIFFUSE), coat(1.0)),
        ),
        case("plastic under a coat", under_coat(plastic, coat(1.3))),
        case("rough conductor under a coat", under_coat(rough, coat(1.5))),
        case("rough conductor under two coats", under_two_coats(rough)),
    ];
    let mut perturbed = under_two_coats(rough);
    perturbed.frame = Frame::from_normal(Vec3::new(0.2, -0.3, 0.9).normalize());
    perturbed.has_frame = true;
    cases.push(case("coats in a perturbed frame", perturbed));
    perturbed.flags |= lobe_flag::COATS_OUTSIDE_FRAME;
    cases.push(case("coats above a perturbed frame", perturbed));
    for (kind, alpha) in [
        (distribution::GGX, Vec2::splat(0.1)),
        (distribution::BECKMANN, Vec2::new(0.1, 0.4)),
        (distribution::GGX, Vec2::splat(0.6)),
    ] {
        let mut lobe = white(lobe_kind::ROUGH_COAT);
        lobe.distribution = kind;
        lobe.alpha = alpha;
        cases.push(case(
            &format!("rough coat, distribution {kind}, alpha {alpha}"),
            lobe,
        ));
    }
    let mut data = vec![0.0; ROW];
    fill_row(distribution::GGX, 0.2, 1.5, &mut data);
    let tabulated = Coat {
        table: 0,
        ..coat(1.5)
    };
    cases.push(Case {
        name: "rough conductor under a rough coat".into(),
        lobe: under_coat(rough, tabulated),
        data,
    });
    let mut lobe = absorbing;
    lobe.kind = lobe_kind::ROUGH_PLASTIC;
    lobe.distribution = distribution::GGX;
    lobe.alpha = Vec2::splat(0.25);
    let mut data = vec![0.0; ROWS * ROW];
    fill(distribution::GGX, 1.5, &mut data);
    (lobe.table, lobe.table_rows) = (0, ROWS as u32);
    // The row at a roughness of 0.16.
    lobe.internal_reflectance = data[6 * ROW + ENTRIES];
    cases.push(Case {
        name: "absorbing rough plastic of a textured roughness".into(),
        lobe,
        data,
    });
    cases
}
