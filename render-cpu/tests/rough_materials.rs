//! Plugins of rough surfaces become the lobes that their parameters say, and mistakes in them are named.

use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use halflight_kernel::bsdf::diffraction_table::{WORDS, fine_scale};
use halflight_kernel::scene::{LobeRecord, NONE, distribution, lobe_kind};
use std::path::Path;

fn build(bsdf: &str) -> Result<Scene, String> {
    let text = format!(
        r#"<scene version="3.0.0"><sensor type="perspective"/><emitter type="constant"/><shape type="rectangle">{bsdf}</shape></scene>"#
    );
    let parsed =
        parse_scene_from_str(&text, Path::new("test.xml"), &[], true).map_err(|e| e.to_string())?;
    build_scene(&parsed, &BuildOptions::default()).map_err(|e| e.to_string())
}

/// The only lobe of a BSDF, and the data table.
fn lobe(bsdf: &str) -> (LobeRecord, Vec<f32>) {
    let scene = build(bsdf).expect("a scene");
    let tables = &scene.tables;
    let material = tables.materials[tables.shapes[0].material as usize];
    assert_eq!(material.lobe_count, 1);
    (
        tables.lobes[material.first_lobe as usize],
        tables.data.to_vec(),
    )
}

#[test]
fn distributions_have_their_names() {
    for (name, kind) in [
        ("beckmann", distribution::BECKMANN),
        ("ggx", distribution::GGX),
        ("phong", distribution::PHONG),
        ("as", distribution::PHONG),
        ("epd", distribution::EXPONENTIAL_POWER),
    ] {
        // The others warn of a parameter that they do not read.
        let exponent = if name == "epd" {
            r#"<float name="exponent" value="0.5"/>"#
        } else {
            ""
        };
        for plugin in ["roughconductor", "roughdielectric"] {
            let (l, _) = lobe(&format!(
                r#"<bsdf type="{plugin}"><string name="distribution" value="{name}"/>
                <float name="alphaU" value="0.2"/><float name="alpha_v" value="0.3"/>
                {exponent}</bsdf>"#
            ));
            assert_eq!(l.distribution, kind, "{plugin} {name}");
            assert_eq!((l.alpha_u.value, l.alpha_v.value), (0.2, 0.3));
            if kind == distribution::EXPONENTIAL_POWER {
                assert_eq!(l.exponent.value, 0.5);
            }
        }
    }
}

#[test]
fn rough_diffuse_takes_a_textured_roughness() {
    let (l, _) = lobe(
        r#"<bsdf type="roughdiffuse"><rgb name="reflectance" value="0.1, 0.2, 0.3"/>
        <texture type="checkerboard" name="alpha"/><boolean name="useFastApprox" value="true"/></bsdf>"#,
    );
    assert_eq!(l.kind, lobe_kind::ROUGH_DIFFUSE);
    assert_eq!(l.reflectance.value, [0.1, 0.2, 0.3]);
    assert_ne!(l.alpha_u.texture, NONE);
    let (l, _) = lobe(r#"<bsdf type="roughdiffuse"/>"#);
    assert_eq!(l.alpha_u.value, 0.2);
}

#[test]
fn diffracting_conductors_have_their_table() {
    let (l, data) = lobe(
        r#"<bsdf type="ctd"><string name="material" value="Al"/><float name="alpha" value="0.2"/>
        <float name="exponent" value="0.7"/><float name="sigma" value="0.04"/>
        <float name="correlation_length" value="1.5"/><float name="decay" value="2.5"/>
        <vector name="wavelengths" value="0.65, 0.55, 0.45"/></bsdf>"#,
    );
    assert_eq!(l.kind, lobe_kind::DIFFRACTING_CONDUCTOR);
    assert_eq!(l.distribution, distribution::EXPONENTIAL_POWER);
    assert_eq!((l.alpha_u.value, l.exponent.value), (0.2, 0.7));
    assert!(data.len() >= l.table as usize + WORDS);
    let scale = fine_scale(&data, l.table);
    assert_eq!(scale.wavelengths, [0.65, 0.55, 0.45]);
    assert_eq!((scale.sigma, scale.b, scale.c), (0.04, 1.5, 2.5));
}

#[test]
fn values_outside_of_the_models_are_named() {
    for (bsdf, wanted) in [
        (
            r#"<bsdf type="ctd"><float name="decay" value="1"/></bsdf>"#,
            "decay",
        ),
        (
            r#"<bsdf type="ctd"><float name="exponent" value="9"/></bsdf>"#,
            "exponent",
        ),
        (
            r#"<bsdf type="ctd"><vector name="wavelengths" value="600, 550, 450"/></bsdf>"#,
            "micrometres",
        ),
        (
            r#"<bsdf type="roughplastic"><string name="distribution" value="epd"/></bsdf>"#,
            "a coat cannot be",
        ),
    ] {
        let Err(error) = build(bsdf) else {
            panic!("{bsdf} is accepted");
        };
        assert!(error.contains(wanted), "{bsdf}: {error}");
    }
}
