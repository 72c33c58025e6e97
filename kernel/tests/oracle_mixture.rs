//! Diffuse, plastic, rough plastic and blended lobes against tables of Mitsuba 3.9.1.

mod common;

use common::oracle::{Row, relative_error, rows};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::fresnel::fresnel_diffuse_reflectance;
use halflight_kernel::bsdf::rough_transmittance::{self, ENTRIES, ROW};
use halflight_kernel::bsdf::{Bsdf, Lobe, lobe};
use halflight_kernel::scene::{MAX_LOBES, distribution, lobe_flag, lobe_kind};

/// Largest relative errors of value and density over the rows.
fn errors(lobe: &Lobe, data: &[f32], rows: &[Row]) -> (f32, f32) {
    let (mut value, mut density) = (0.0_f32, 0.0_f32);
    for row in rows {
        let f = lobe::eval_cosine(lobe, data, row.wi, row.wo) / row.wo.z.abs();
        for c in 0..3 {
            value = value.max(relative_error(f[c], row.f[c], 1e-4));
        }
        let p = lobe::pdf(lobe, data, row.wi, row.wo);
        density = density.max(relative_error(p, row.pdf, 1e-4));
    }
    (value, density)
}

fn plastic(kind: u32, nonlinear: bool) -> Lobe {
    let mut lobe = Lobe::NONE;
    lobe.kind = kind;
    lobe.reflectance = Vec3::new(0.1, 0.27, 0.36);
    lobe.specular_reflectance = Vec3::ONE;
    lobe.eta = Vec3::splat(1.49);
    lobe.internal_reflectance = fresnel_diffuse_reflectance(1.0 / 1.49);
    if nonlinear {
        lobe.flags |= lobe_flag::NONLINEAR;
    }
    lobe
}

#[track_caller]
fn check(lobe: &Lobe, data: &[f32], text: &str, tolerance: (f32, f32)) {
    let (value, density) = errors(lobe, data, &rows(text));
    assert!(value <= tolerance.0, "value differs by {value}");
    assert!(density <= tolerance.1, "density differs by {density}");
}

#[test]
fn diffuse_matches() {
    let mut lobe = Lobe::NONE;
    lobe.reflectance = Vec3::new(0.2, 0.5, 0.8);
    check(
        &lobe,
        &[],
        include_str!("oracle/mitsuba/diffuse.csv"),
        (1e-6, 1e-6),
    );
}

#[test]
fn plastic_matches() {
    // Mitsuba fits its internal diffuse reflectance by a polynomial, good to 5e-4 of 1 - F_int; ours is exact to 1e-5.
    check(
        &plastic(lobe_kind::PLASTIC, false),
        &[],
        include_str!("oracle/mitsuba/plastic.csv"),
        (1.5e-3, 1e-5),
    );
    check(
        &plastic(lobe_kind::PLASTIC, true),
        &[],
        include_str!("oracle/mitsuba/plastic-nonlinear.csv"),
        (3e-4, 1e-5),
    );
}

#[test]
fn rough_plastic_matches() {
    let (beckmann, ggx) = (distribution::BECKMANN, distribution::GGX);
    // Beckmann masking is a rational fit there with errors up to 0.35 % per direction. Densities depend on the
    // transmittance table, whose quadrature is coarser there; it decides only which part is sampled.
    let beckmann_tolerance = (7e-3, 8e-3);
    let ggx_tolerance = (4.5e-3, 4.5e-3);
    for (kind, alpha, nonlinear, text) in [
        (
            beckmann,
            0.1,
            false,
            include_str!("oracle/mitsuba/roughplastic-beckmann-0.1.csv"),
        ),
        (
            beckmann,
            0.3,
            false,
            include_str!("oracle/mitsuba/roughplastic-beckmann-0.3.csv"),
        ),
        (
            beckmann,
            0.1,
            true,
            include_str!("oracle/mitsuba/roughplastic-beckmann-0.1-nonlinear.csv"),
        ),
        (
            beckmann,
            0.3,
            true,
            include_str!("oracle/mitsuba/roughplastic-beckmann-0.3-nonlinear.csv"),
        ),
        (
            ggx,
            0.1,
            false,
            include_str!("oracle/mitsuba/roughplastic-ggx-0.1.csv"),
        ),
        (
            ggx,
            0.3,
            false,
            include_str!("oracle/mitsuba/roughplastic-ggx-0.3.csv"),
        ),
        (
            ggx,
            0.1,
            true,
            include_str!("oracle/mitsuba/roughplastic-ggx-0.1-nonlinear.csv"),
        ),
        (
            ggx,
            0.3,
            true,
            include_str!("oracle/mitsuba/roughplastic-ggx-0.3-nonlinear.csv"),
        ),
    ] {
        let mut lobe = plastic(lobe_kind::ROUGH_PLASTIC, nonlinear);
        lobe.distribution = kind;
        lobe.alpha = Vec2::splat(alpha);
        lobe.table = 0;
        let mut data = [0.0; ROW];
        rough_transmittance::fill_row(kind, alpha, 1.49, &mut data);
        lobe.internal_reflectance = data[ENTRIES];
        let tolerance = if kind == beckmann {
            beckmann_tolerance
        } else {
            ggx_tolerance
        };
        check(&lobe, &data, text, tolerance);
    }
}

#[test]
fn blend_matches() {
    let mut lobes = [Lobe::NONE; MAX_LOBES];
    lobes[0].reflectance = Vec3::new(0.2, 0.5, 0.8);
    lobes[0].weight = 0.7;
    lobes[1].kind = lobe_kind::ROUGH_CONDUCTOR;
    lobes[1].distribution = distribution::GGX;
    lobes[1].alpha = Vec2::splat(0.2);
    lobes[1].specular_reflectance = Vec3::ONE;
    lobes[1].eta = Vec3::new(0.143, 0.375, 1.442);
    lobes[1].k = Vec3::new(3.983, 2.386, 1.603);
    lobes[1].weight = 0.3;
    for row in rows(include_str!("oracle/mitsuba/blend.csv")) {
        // Densities differ by intention: we choose lobes by weight times colour, Mitsuba by weight.
        let bsdf = Bsdf::from_lobes(lobes, 2, &[], row.wi);
        let f = bsdf.eval_cosine(&[], row.wi, row.wo) / row.wo.z.abs();
        for c in 0..3 {
            let error = relative_error(f[c], row.f[c], 1e-4);
            assert!(error < 1e-3, "{row:?}: {f}, relative error {error}");
        }
        let weighted: f32 = (0..2)
            .map(|i| lobe::pdf(&lobes[i], &[], row.wi, row.wo) * lobes[i].weight)
            .sum();
        let error = relative_error(weighted, row.pdf, 1e-4);
        assert!(error < 1e-3, "{row:?}: {weighted}, relative error {error}");
    }
}
