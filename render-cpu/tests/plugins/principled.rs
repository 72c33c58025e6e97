//! `principled` as flattened lobes, against values of Mitsuba 3.9.1.

use crate::{bsdf, build};
use glam::Vec3;

#[track_caller]
fn matches(plugin: &str, properties: &str, oracle: &str) {
    let scene = build(
        "3.0.0",
        &format!(r#"<shape type="sphere"><bsdf type="{plugin}">{properties}</bsdf></shape>"#),
    );
    let tables = scene.tables.view();
    let mut positive = 0;
    for line in oracle.lines().filter(|l| !l.starts_with(['#', 'w'])) {
        let v: Vec<f32> = line
            .split(',')
            .map(|x| x.parse().expect("a number"))
            .collect();
        let (wi, wo) = (Vec3::from_slice(&v[..3]), Vec3::from_slice(&v[3..6]));
        let f = bsdf(&tables, wi).eval_cosine(tables.data, wi, wo) / wo.z.abs();
        for c in 0..3 {
            let expected = v[6 + c];
            // Single precision on both sides, magnified by narrow peaks.
            let error = (f[c] - expected).abs() / expected.abs().max(1e-3);
            assert!(
                error < 2e-3,
                "{properties} {wi} {wo}: {f}, not {:?}",
                &v[6..9]
            );
        }
        positive += u32::from(v[6] > 0.0);
    }
    assert!(positive > 20, "{positive}");
}

const BASE: &str = r#"<rgb name="base_color" value="0.8 0.4 0.1"/>"#;

fn floats(values: &[(&str, f64)]) -> String {
    values
        .iter()
        .map(|(name, value)| format!(r#"<float name="{name}" value="{value}"/>"#))
        .collect()
}

#[test]
fn values_are_those_of_mitsuba() {
    matches(
        "principled",
        "",
        include_str!("../oracle/principled/default.csv"),
    );
    for (values, oracle) in [
        (
            &[("roughness", 0.9), ("specular", 0.2)][..],
            include_str!("../oracle/principled/rough.csv"),
        ),
        (
            &[("roughness", 0.4), ("metallic", 1.0), ("anisotropic", 0.7)],
            include_str!("../oracle/principled/metal.csv"),
        ),
        (
            &[("roughness", 0.3), ("metallic", 0.3), ("spec_tint", 0.6)],
            include_str!("../oracle/principled/mixed.csv"),
        ),
        (
            &[
                ("roughness", 0.4),
                ("sheen", 0.8),
                ("sheen_tint", 0.5),
                ("flatness", 0.4),
            ],
            include_str!("../oracle/principled/cloth.csv"),
        ),
        (
            &[
                ("roughness", 0.4),
                ("clearcoat", 0.9),
                ("clearcoat_gloss", 0.3),
                ("metallic", 0.5),
            ],
            include_str!("../oracle/principled/coat.csv"),
        ),
        (
            &[("roughness", 0.5), ("spec_trans", 0.7), ("eta", 1.4)],
            include_str!("../oracle/principled/glass.csv"),
        ),
        (
            &[
                ("roughness", 0.4),
                ("metallic", 0.2),
                ("spec_trans", 0.4),
                ("spec_tint", 0.3),
                ("sheen", 0.5),
                ("sheen_tint", 0.7),
                ("flatness", 0.6),
                ("clearcoat", 0.5),
                ("clearcoat_gloss", 0.8),
                ("anisotropic", 0.4),
                ("eta", 1.6),
            ],
            include_str!("../oracle/principled/all.csv"),
        ),
    ] {
        matches("principled", &(BASE.to_owned() + &floats(values)), oracle);
    }
}

#[test]
fn a_texture_of_gloss_is_the_number_that_it_holds() {
    let values = floats(&[("roughness", 0.4), ("clearcoat", 0.9), ("metallic", 0.5)]);
    let gloss = r#"<texture name="clearcoat_gloss" type="checkerboard">
        <rgb name="color0" value="0.3"/><rgb name="color1" value="0.3"/></texture>"#;
    matches(
        "principled",
        &(BASE.to_owned() + &values + gloss),
        include_str!("../oracle/principled/coat.csv"),
    );
}

#[test]
fn values_of_thin_sheets_are_those_of_mitsuba() {
    for (values, oracle) in [
        (
            &[("roughness", 0.9)][..],
            include_str!("../oracle/principledthin/opaque.csv"),
        ),
        (
            &[
                ("roughness", 0.6),
                ("diff_trans", 1.2),
                ("sheen", 0.6),
                ("sheen_tint", 0.5),
                ("flatness", 0.3),
            ],
            include_str!("../oracle/principledthin/paper.csv"),
        ),
        (
            &[
                ("roughness", 0.5),
                ("spec_trans", 1.0),
                ("eta", 1.7),
                ("anisotropic", 0.5),
                ("spec_tint", 0.4),
            ],
            include_str!("../oracle/principledthin/glass.csv"),
        ),
        (
            &[
                ("roughness", 0.5),
                ("spec_trans", 0.4),
                ("eta", 1.4),
                ("anisotropic", 0.3),
                ("spec_tint", 0.3),
                ("sheen", 0.5),
                ("sheen_tint", 0.2),
                ("flatness", 0.4),
                ("diff_trans", 0.8),
            ],
            include_str!("../oracle/principledthin/all.csv"),
        ),
    ] {
        matches(
            "principledthin",
            &(BASE.to_owned() + &floats(values)),
            oracle,
        );
    }
}

#[test]
fn parameters_may_be_textures_of_the_same_value() {
    let sheet = |metallic: &str, roughness: &str| {
        build(
            "3.0.0",
            &format!(
                r#"<shape type="rectangle"><bsdf type="principled">{BASE}{metallic}{roughness}</bsdf></shape>"#
            ),
        )
    };
    let grey = |name: &str, value: f64| {
        format!(
            r#"<texture name="{name}" type="checkerboard"><rgb name="color0" value="{value}"/><rgb name="color1" value="{value}"/></texture>"#
        )
    };
    let constant = sheet(
        &floats(&[("metallic", 0.25)]),
        &floats(&[("roughness", 0.5)]),
    );
    let textured = sheet(&grey("metallic", 0.25), &grey("roughness", 0.5));
    let (a, b) = (constant.tables.view(), textured.tables.view());
    for (wi, wo) in [
        (Vec3::new(0.3, 0.1, 0.9), Vec3::new(-0.4, 0.0, 0.8)),
        (Vec3::new(0.8, 0.1, 0.3), Vec3::new(-0.7, -0.1, 0.4)),
    ] {
        let (wi, wo) = (wi.normalize(), wo.normalize());
        let f = bsdf(&a, wi).eval_cosine(a.data, wi, wo);
        let g = bsdf(&b, wi).eval_cosine(b.data, wi, wo);
        assert!(
            (f - g).abs().max_element() < 1e-5 * f.max_element(),
            "{f} {g}"
        );
    }
}
