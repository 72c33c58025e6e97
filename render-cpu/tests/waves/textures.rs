//! Textures on surfaces: bitmaps of all forms, nested ones, attributes of meshes.

use crate::files::Files;
use crate::materials::ROUGHNESS;
use crate::room::{CONSTANT, Room};
use halflight_kernel::scene::texel_format;

/// A bitmap as the parameter `name`.
fn bitmap(name: &str, file: &str, parameters: &str) -> String {
    format!(
        r#"<texture name="{name}" type="bitmap"><string name="filename" value="{file}"/>{parameters}</texture>"#
    )
}

fn diffuse(reflectance: &str) -> String {
    format!(r#"<bsdf type="diffuse">{reflectance}</bsdf>"#)
}

/// Textured things between textured walls, whose coordinates run from -1 to 2.
fn agrees(files: &Files, material: &str) {
    let mut room = Room {
        walls: material.into(),
        ..Room::with_material(material)
    };
    room.emitters += CONSTANT;
    room.least = 0.1;
    room.agrees(files);
}

#[test]
fn bitmaps_between_and_beyond_their_texels() {
    let files = Files::new();
    let beyond = r#"<transform name="to_uv"><translate x="-0.3" y="-0.4"/><rotate z="1" angle="20"/>
        <scale x="3" y="2.5"/></transform>"#;
    for filter in ["nearest", "bilinear"] {
        for wrap in ["repeat", "mirror", "clamp", "zero", "one"] {
            let parameters = format!(
                r#"{beyond}<string name="filter_type" value="{filter}"/><string name="wrap_mode" value="{wrap}"/>"#
            );
            agrees(
                &files,
                &diffuse(&bitmap("reflectance", "color.png", &parameters)),
            );
        }
    }
}

#[test]
fn bitmaps_of_all_formats() {
    let files = Files::new();
    let mut formats = Vec::new();
    for file in [
        "color.png",
        "color.bmp",
        "grey.png",
        "alpha.png",
        "deep.png",
        "sky.hdr",
        "dot.hdr",
    ] {
        for raw in [false, true] {
            let raw = format!(r#"<boolean name="raw" value="{raw}"/>"#);
            let room = Room::with_material(&diffuse(&bitmap("reflectance", file, &raw)));
            room.agrees(&files);
            formats.extend(room.build(&files).tables.textures.iter().map(|t| t.data[3]));
        }
    }
    for format in [
        texel_format::RGBA8_SRGB,
        texel_format::RGBA8_LINEAR,
        texel_format::RGB32F,
    ] {
        assert!(formats.contains(&format), "{format}");
    }
}

#[test]
fn nested_textures() {
    let files = Files::new();
    let turned =
        r#"<transform name="to_uv"><scale x="3" y="2"/><rotate z="1" angle="30"/></transform>"#;
    let image = bitmap("color0", "color.png", "");
    let board = format!(
        r#"<texture name="color1" type="checkerboard">{turned}{image}<rgb name="color1" value="0.9, 0.1, 0.2"/></texture>"#
    );
    let scaled = format!(
        r#"<texture name="color0" type="scale"><rgb name="scale" value="0.5, 0.9, 0.7"/>{}</texture>"#,
        bitmap("nested", "deep.png", "")
    );
    for texture in [
        r#"<texture name="reflectance" type="checkerboard"/>"#.to_string(),
        format!(r#"<texture name="reflectance" type="checkerboard">{image}{board}</texture>"#),
        format!(
            r#"<texture name="reflectance" type="checkerboard">{scaled}{board}{turned}</texture>"#
        ),
    ] {
        agrees(&files, &diffuse(&texture));
    }
}

/// A bitmap or a colour below `depth` textures.
fn nested(depth: usize, inner: &str) -> String {
    (1..depth).fold(inner.to_string(), |inner, _| {
        format!(
            r#"<texture name="nested" type="scale"><float name="scale" value="0.97"/>{inner}</texture>"#
        )
    })
}

#[test]
fn textures_nested_as_deeply_as_they_may_be_and_deeper() {
    let files = Files::new();
    for depth in 5..12 {
        let board = r#"<texture name="nested" type="checkerboard"/>"#;
        for inner in [board, &bitmap("nested", "color.png", "")] {
            let texture = nested(depth, inner);
            let (first, rest) = texture.split_once("nested").expect("a name");
            let room = Room {
                // Other paths of the class have nothing to follow.
                shapes: format!(
                    r#"<shape type="cube"><transform name="to_world"><scale value="0.4"/>
                    <translate x="0.2" y="0.6" z="1"/></transform>{}</shape>"#,
                    diffuse(&bitmap("reflectance", "grey.png", ""))
                ),
                ..Room::with_material(&diffuse(&format!("{first}reflectance{rest}")))
            };
            room.agrees(&files);
        }
    }
}

#[test]
fn attributes_of_meshes() {
    let files = Files::new();
    let attribute = |parameter: &str, name: &str| {
        format!(
            r#"<texture name="{parameter}" type="mesh_attribute"><string name="name" value="{name}"/></texture>"#
        )
    };
    let scaled = format!(
        r#"<texture name="reflectance" type="scale"><float name="scale" value="0.6"/>{}</texture>"#,
        attribute("nested", "vertex_color")
    );
    let chosen = format!(
        r#"<texture name="reflectance" type="checkerboard">{}{}</texture>"#,
        attribute("color0", "vertex_color"),
        attribute("color1", "face_color")
    );
    for material in [
        diffuse(&attribute("reflectance", "vertex_color")),
        diffuse(&attribute("reflectance", "face_color")),
        diffuse(&scaled),
        diffuse(&chosen),
        format!(
            r#"<bsdf type="roughplastic">{}</bsdf>"#,
            attribute("alpha", "vertex_rough")
        ),
        format!(
            r#"<bsdf type="roughconductor">{}</bsdf>"#,
            attribute("alpha", "vertex_rough")
        ),
    ] {
        let room = Room {
            shapes: format!(
                r#"<shape type="ply"><string name="filename" value="tinted.ply"/><transform name="to_world">
                <scale x="1.4" y="0.6" z="1"/><rotate x="1" angle="-20"/><translate y="0.5" z="1"/></transform>
                <bsdf type="twosided">{material}</bsdf></shape>"#
            ),
            ..Room::with_material(&diffuse(&bitmap("reflectance", "color.png", "")))
        };
        room.agrees(&files);
    }
}

#[test]
fn textures_in_every_parameter() {
    let files = Files::new();
    let image = |name| bitmap(name, "color.png", "");
    let glass = [
        image("specular_reflectance"),
        image("specular_transmittance"),
    ]
    .concat();
    let metal = [
        bitmap("eta", "deep.png", ""),
        bitmap("k", "sky.hdr", ""),
        image("specular_reflectance"),
    ]
    .concat();
    let plastic = [image("diffuse_reflectance"), image("specular_reflectance")].concat();
    let rough = format!("<texture {ROUGHNESS}</texture>");
    for (plugin, parameters) in [
        ("conductor", &metal),
        ("dielectric", &glass),
        ("thindielectric", &glass),
        ("plastic", &plastic),
    ] {
        agrees(
            &files,
            &format!(r#"<bsdf type="{plugin}">{parameters}</bsdf>"#),
        );
    }
    for facets in ["beckmann", "ggx"] {
        let facets = format!(r#"<string name="distribution" value="{facets}"/>"#);
        for (plugin, parameters) in [
            ("roughconductor", &metal),
            ("roughdielectric", &glass),
            ("roughplastic", &plastic),
        ] {
            agrees(
                &files,
                &format!(r#"<bsdf type="{plugin}">{facets}{parameters}{rough}</bsdf>"#),
            );
        }
    }
}
