//! A colour where a number is wanted counts by its luminance.

use crate::Files;

const COATED: &str = r#"<float name="clearcoat" value="1"/>"#;

/// Content with a number said in every way that gives 0.3, and as the luminance of a colour.
fn same(content: impl Fn(&str) -> String, name: &str) {
    let files = Files::new(&[]);
    let number = |value: f64| {
        files.clean(
            "3.0.0",
            &content(&format!(r#"<float name="{name}" value="{value}"/>"#)),
        )
    };
    for way in [
        format!(r#"<rgb name="{name}" value="0.3"/>"#),
        format!(r#"<rgb name="{name}" value="0.3 0.3 0.3"/>"#),
        format!(r#"<spectrum name="{name}" value="0.3"/>"#),
        format!(
            r#"<spectrum name="{name}" type="uniform"><float name="value" value="0.3"/></spectrum>"#
        ),
        format!(r#"<texture name="{name}" type="srgb"><rgb name="color" value="0.3"/></texture>"#),
        format!(
            r#"<texture name="{name}" type="uniform"><float name="value" value="0.3"/></texture>"#
        ),
    ] {
        assert_eq!(files.clean("3.0.0", &content(&way)), number(0.3), "{way}");
    }
    // The luminance of a colour whose channels are powers of two is the same however it is summed.
    let coloured = content(&format!(r#"<rgb name="{name}" value="0.5 0.25 0"/>"#));
    let luminance = f64::from(0.212_671_f32 * 0.5 + 0.715_160 * 0.25);
    assert_eq!(files.clean("3.0.0", &coloured), number(luminance));
}

#[test]
fn the_opacity_of_a_mask() {
    let mask = |opacity: &str| {
        format!(
            r#"<shape type="rectangle"><bsdf type="mask">{opacity}<bsdf type="diffuse"/></bsdf></shape>"#
        )
    };
    same(mask, "opacity");
}

#[test]
fn the_weight_of_a_blend() {
    let blend = |weight: &str| {
        format!(
            r#"<shape type="rectangle"><bsdf type="blendbsdf">{weight}<bsdf type="diffuse"/><bsdf type="conductor"/></bsdf></shape>"#
        )
    };
    same(blend, "weight");
}

#[test]
fn the_roughness_of_facets() {
    for name in ["alpha", "alpha_u", "alpha_v"] {
        let rough = |alpha: &str| {
            format!(
                r#"<shape type="sphere"><bsdf type="roughconductor"><string name="material" value="Au"/>{alpha}</bsdf></shape>"#
            )
        };
        same(rough, name);
    }
}

#[test]
fn the_roughness_of_grooves_and_the_exponent_of_facets() {
    let grooves = |alpha: &str| {
        format!(r#"<shape type="sphere"><bsdf type="roughdiffuse">{alpha}</bsdf></shape>"#)
    };
    same(grooves, "alpha");
    let facets = |exponent: &str| {
        format!(
            r#"<shape type="sphere"><bsdf type="roughdielectric"><string name="distribution" value="epd"/>{exponent}</bsdf></shape>"#
        )
    };
    same(facets, "exponent");
}

#[test]
fn the_numbers_of_models_from_other_programs() {
    let surface = |plugin: &'static str| {
        move |number: &str| {
            format!(r#"<shape type="sphere"><bsdf type="{plugin}">{COATED}{number}</bsdf></shape>"#)
        }
    };
    for name in [
        "roughness",
        "anisotropic",
        "metallic",
        "spec_trans",
        "spec_tint",
        "sheen",
        "sheen_tint",
        "flatness",
        "clearcoat_gloss",
    ] {
        same(surface("principled"), name);
    }
    for (plugin, names) in [
        ("principledthin", &["roughness", "diff_trans", "sheen"][..]),
        ("phong", &["exponent"]),
        ("ward", &["alphaU", "alphaV"]),
    ] {
        for name in names {
            let plain = |number: &str| surface(plugin)(number).replace(COATED, "");
            same(plain, name);
        }
    }
}
