//! Values of textures beyond what they are used as.

use crate::images::exr;
use crate::{Files, SENSOR, assert_mean};

/// A lamp that fills the film, with a texture for its radiance.
fn lamp(version: &str, texture: &str) -> Vec<u8> {
    format!(
        r#"<scene version="{version}">{SENSOR}<shape type="rectangle"><emitter type="area">{texture}</emitter></shape></scene>"#
    )
    .into_bytes()
}

const PATTERN: &str = r#"<texture name="radiance" type="checkerboard"><rgb name="color0" value="5"/><rgb name="color1" value="11"/><transform name="to_uv"><scale x="2" y="2"/></transform></texture>"#;

#[test]
fn patterns_of_light_may_be_brighter_than_one() {
    let files = Files::new(&[]);
    let older = PATTERN.replace("to_uv", "toUV");
    let grid = r#"<texture name="radiance" type="gridtexture"><rgb name="color0" value="6"/><rgb name="color1" value="6"/></texture>"#;
    let nested = PATTERN.replace("name=\"radiance\"", "").replace(
        "<texture",
        "<texture name=\"radiance\" type=\"scale\"><float name=\"scale\" value=\"0.5\"/><texture",
    ) + "</texture>";
    for (version, texture, mean) in [
        ("3.0.0", PATTERN, 8.0),
        ("0.6.0", &older, 8.0),
        ("0.6.0", grid, 6.0),
        ("3.0.0", &nested, 4.0),
    ] {
        let scene = files
            .load(&lamp(version, texture), true)
            .unwrap_or_else(|error| panic!("{texture}: {error}"));
        assert_mean(&scene, 16, mean, 1e-3);
    }
}

#[test]
fn one_pattern_may_be_light_and_a_reflectance() {
    let files = Files::new(&[]);
    let content = format!(
        r#"{}<shape type="sphere"><bsdf type="diffuse"><ref name="reflectance" id="p"/></bsdf></shape><shape type="rectangle"><emitter type="area"><ref name="radiance" id="p"/></emitter></shape>"#,
        PATTERN.replace("name=\"radiance\"", "id=\"p\"")
    );
    let scene = files.scene("3.0.0", &content).expect("a scene");
    let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings.iter().all(|w| w.contains("clamped to [0, 1]")));
    let of = |color: f32| {
        let textures = scene.tables.textures.iter();
        textures.filter(|t| t.color0.value == [color; 3]).count()
    };
    assert_eq!((of(1.0), of(5.0)), (1, 1));
}

#[test]
fn light_is_not_negative() {
    let files = Files::new(&[
        ("grey.exr", &exr([0.5, 0.5, 0.5, 1.0])),
        ("negative.exr", &exr([0.5, -0.25, 0.5, 1.0])),
    ]);
    let alone = |content: &str| {
        let text = format!(r#"<scene version="3.0.0">{SENSOR}{content}</scene>"#);
        let scene = files.load(text.as_bytes(), false).expect("a scene");
        let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
        warnings.join("\n")
    };
    let image = |file: &str, scale: &str| {
        format!(
            r#"<emitter type="envmap"><string name="filename" value="{file}"/><float name="scale" value="{scale}"/></emitter>"#
        )
    };
    assert_eq!(alone(&image("grey.exr", "2")), "");
    let cannot = "light cannot be negative";
    assert!(alone(&image("grey.exr", "-1")).contains(cannot));
    assert!(alone(&image("negative.exr", "1")).contains("go down to -0.25"));
    for name in ["scale", "sun_scale", "sky_scale"] {
        let sky = format!(r#"<emitter type="sunsky"><float name="{name}" value="-1"/></emitter>"#);
        assert!(alone(&sky).contains(cannot), "{name}");
    }
}

#[test]
fn of_several_layers_the_one_that_is_read_is_said() {
    use exr::prelude::{AnyChannel, AnyChannels, FlatSamples, Image, WritableImage};
    let image = |names: &[&str]| {
        let channel = |name: &&str| AnyChannel::new(*name, FlatSamples::F32(vec![0.5; 4]));
        let channels = AnyChannels::sort(names.iter().map(channel).collect());
        let mut bytes = std::io::Cursor::new(Vec::new());
        Image::from_channels((2, 2), channels)
            .write()
            .to_buffered(&mut bytes)
            .expect("an image");
        bytes.into_inner()
    };
    let files = Files::new(&[
        (
            "two.exr",
            &image(&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"]),
        ),
        ("one.exr", &image(&["a.R", "a.G", "a.B"])),
        ("main.exr", &image(&["R", "G", "B", "b.R", "b.G", "b.B"])),
    ]);
    let wall = |file: &str| {
        format!(
            r#"<shape type="rectangle"><bsdf type="diffuse"><texture name="reflectance" type="bitmap"><string name="filename" value="{file}"/></texture></bsdf></shape>"#
        )
    };
    let one = files.clean("3.0.0", &wall("one.exr"));
    assert_eq!(files.clean("3.0.0", &wall("main.exr")), one);
    assert_eq!(
        files.warned("3.0.0", &wall("two.exr"), "\"a\" is read"),
        one
    );
}

#[test]
fn bitmaps_beyond_what_they_are_used_as_are_said() {
    let files = Files::new(&[
        ("negative.exr", &exr([0.5, -0.25, 0.5, 1.0])),
        ("three.exr", &exr([3.0, 0.5, 0.5, 1.0])),
        ("white.exr", &exr([1.0, 1.0005, 0.5, 1.0])),
    ]);
    let bitmap = |name: &str, file: &str| {
        format!(
            r#"<texture name="{name}" type="bitmap"><string name="filename" value="{file}"/></texture>"#
        )
    };
    let wall = |file: &str| {
        format!(
            r#"<shape type="rectangle"><bsdf type="diffuse">{}</bsdf></shape>"#,
            bitmap("reflectance", file)
        )
    };
    let light = |file: &str| {
        format!(
            r#"<shape type="rectangle"><emitter type="area">{}</emitter></shape>"#,
            bitmap("radiance", file)
        )
    };
    files.warned("3.0.0", &wall("negative.exr"), "go down to -0.25");
    files.warned("0.6.0", &light("negative.exr"), "go down to -0.25");
    files.warned("0.6.0", &wall("three.exr"), "go up to 3;");
    files.clean("3.0.0", &light("three.exr"));
    files.clean("3.0.0", &wall("white.exr"));
    // What only scaling makes too bright, and what it makes dark enough.
    let scaled = |file: &str, factor: &str| {
        let inner = bitmap("", file).replace("name=\"\" ", "");
        wall(file).replace(
            &bitmap("reflectance", file),
            &format!(
                r#"<texture name="reflectance" type="scale"><float name="scale" value="{factor}"/>{inner}</texture>"#
            ),
        )
    };
    files.warned("0.6.0", &scaled("white.exr", "2"), "go up to 2.001;");
    files.clean("0.6.0", &scaled("three.exr", "0.25"));
    // As a number, whose range is another.
    let rough = format!(
        r#"<shape type="rectangle"><bsdf type="roughconductor">{}</bsdf></shape>"#,
        bitmap("eta", "three.exr") + &bitmap("k", "three.exr")
    );
    files.clean("3.0.0", &rough);
}
