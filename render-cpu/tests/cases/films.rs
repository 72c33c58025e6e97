//! What films ask of the image file: it is done, or said not to be.

use crate::{SENSOR, SKY};
use halflight::film::aov::Aov;
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use std::path::Path;

fn load(version: &str, plugin: &str, property: &str, strict: bool) -> Result<Scene, String> {
    let sensor = SENSOR.replace(
        "type=\"hdrfilm\">",
        &format!("type=\"{plugin}\">{property}"),
    );
    let text = format!("<scene version=\"{version}\">{sensor}{SKY}</scene>");
    let parsed = parse_scene_from_str(&text, Path::new("s.xml"), &[], strict);
    let parsed = parsed.map_err(|error| error.to_string())?;
    build_scene(&parsed, &BuildOptions::default()).map_err(|error| error.to_string())
}

#[test]
fn an_alpha_channel_is_a_layer() {
    for (version, property, expected) in [
        (
            "0.6.0",
            r#"<string name="pixelFormat" value="rgba"/>"#,
            true,
        ),
        (
            "3.0.0",
            r#"<string name="pixel_format" value="RGBA"/>"#,
            true,
        ),
        (
            "3.0.0",
            r#"<string name="pixel_format" value="rgb"/>"#,
            false,
        ),
        ("3.0.0", "", false),
    ] {
        let scene = load(version, "hdrfilm", property, true).unwrap();
        assert_eq!(scene.layers.contains(Aov::Alpha), expected, "{property}");
    }
}

#[test]
fn what_is_not_written_as_asked_is_said() {
    for (version, plugin, property) in [
        (
            "0.6.0",
            "hdrfilm",
            r#"<string name="pixelFormat" value="luminance"/>"#,
        ),
        (
            "0.6.0",
            "hdrfilm",
            r#"<string name="pixelFormat" value="spectrumAlpha"/>"#,
        ),
        (
            "3.0.0",
            "hdrfilm",
            r#"<string name="pixel_format" value="xyz"/>"#,
        ),
        (
            "3.0.0",
            "hdrfilm",
            r#"<string name="pixel_format" value="blub"/>"#,
        ),
        (
            "0.6.0",
            "hdrfilm",
            r#"<string name="componentFormat" value="uint32"/>"#,
        ),
        (
            "3.0.0",
            "hdrfilm",
            r#"<string name="component_format" value="blub"/>"#,
        ),
        (
            "0.6.0",
            "hdrfilm",
            r#"<string name="fileFormat" value="rgbe"/>"#,
        ),
        (
            "0.6.0",
            "ldrfilm",
            r#"<string name="fileFormat" value="jpeg"/>"#,
        ),
        ("0.6.0", "ldrfilm", r#"<float name="gamma" value="1"/>"#),
        ("0.6.0", "ldrfilm", r#"<float name="exposure" value="2"/>"#),
        (
            "0.6.0",
            "ldrfilm",
            r#"<string name="tonemapMethod" value="reinhard"/>"#,
        ),
    ] {
        let scene = load(version, plugin, property, false).unwrap();
        let said: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
        assert_eq!(said.len(), 1, "{property}: {said:?}");
        let name = property.split('"').nth(1).unwrap();
        assert!(said[0].contains(name), "{said:?}");
        load(version, plugin, property, true).expect_err("strictly an error");
    }
    for (plugin, property) in [
        (
            "hdrfilm",
            r#"<string name="componentFormat" value="float16"/>"#,
        ),
        ("hdrfilm", r#"<string name="fileFormat" value="openexr"/>"#),
        (
            "ldrfilm",
            r#"<string name="fileFormat" value="png"/><float name="gamma" value="2.2"/>"#,
        ),
        (
            "ldrfilm",
            r#"<float name="gamma" value="-1"/><boolean name="banner" value="false"/>"#,
        ),
    ] {
        load("0.6.0", plugin, property, true).unwrap();
    }
}
