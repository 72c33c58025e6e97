//! Emitters with loops of their own, those without, and several at once.

use crate::files::Files;
use crate::room::{CONSTANT, LAMP, POINT, Room, path};
use crate::samples;

/// What is looked at in the light: something diffuse, rough or smooth.
const MATERIALS: [&str; 3] = [
    r#"<bsdf type="diffuse"/>"#,
    r#"<bsdf type="roughplastic"><string name="distribution" value="ggx"/></bsdf>"#,
    r#"<bsdf type="dielectric"/>"#,
];

/// The room in this light.
fn agrees(files: &Files, emitters: &str, least: f32) {
    for material in MATERIALS {
        let room = Room {
            emitters: emitters.into(),
            least,
            ..Room::with_material(material)
        };
        room.agrees(files);
    }
}

/// An emitting shape between the camera and the things, in sight; `place` follows what the shape holds.
fn lamp(plugin: &str, place: &str, radiance: &str) -> String {
    format!(
        r#"<shape type="{plugin}">{place}<emitter type="area">{radiance}</emitter>
        <bsdf type="plastic"/></shape>"#
    )
}

const BRIGHT: &str = r#"<rgb name="radiance" value="9, 8, 6"/>"#;
const TURNED: &str = r#"<transform name="to_world"><scale x="0.5" y="0.3" z="0.4"/><rotate x="1" angle="70"/>
    <translate x="0.2" y="1" z="0.8"/></transform>"#;

#[test]
fn emitting_meshes() {
    let files = Files::new();
    agrees(&files, LAMP, 0.2);
    agrees(&files, &lamp("cube", TURNED, BRIGHT), 0.2);
    let ball = format!(r#"<string name="filename" value="ball.obj"/>{TURNED}"#);
    agrees(&files, &lamp("obj", &ball, BRIGHT), 0.2);
    let flipped = format!(r#"{TURNED}<boolean name="flip_normals" value="true"/>"#);
    agrees(&files, &lamp("rectangle", &flipped, BRIGHT), 0.05);
}

#[test]
fn emitting_quadrics() {
    let files = Files::new();
    let sphere =
        r#"<point name="center" x="0.2" y="1" z="0.8"/><float name="radius" value="0.25"/>"#;
    agrees(&files, &lamp("sphere", sphere, BRIGHT), 0.2);
    // An ellipsoid, and one that holds everything.
    agrees(&files, &lamp("sphere", TURNED, BRIGHT), 0.2);
    let around = r#"<float name="radius" value="9"/><boolean name="flip_normals" value="true"/>"#;
    agrees(&files, &lamp("sphere", around, BRIGHT), 0.2);
    agrees(&files, &lamp("disk", TURNED, BRIGHT), 0.1);
    let cylinder = r#"<point name="p0" x="-0.5" y="1" z="0.8"/><point name="p1" x="0.5" y="1.2" z="0.9"/>
        <float name="radius" value="0.1"/>"#;
    agrees(&files, &lamp("cylinder", cylinder, BRIGHT), 0.2);
}

#[test]
fn emitters_with_textures() {
    let files = Files::new();
    let image = r#"<texture name="radiance" type="bitmap"><string name="filename" value="sky.hdr"/></texture>"#;
    let board = r#"<texture name="radiance" type="checkerboard"><rgb name="color0" value="1"/>
        <rgb name="color1" value="0"/></texture>"#;
    for radiance in [image, board] {
        agrees(&files, &lamp("cube", TURNED, radiance), 0.1);
        agrees(&files, &lamp("sphere", TURNED, radiance), 0.1);
    }
    let tinted = format!(r#"<string name="filename" value="tinted.ply"/>{TURNED}"#);
    for name in ["vertex_color", "face_color"] {
        let attribute = format!(
            r#"<texture name="radiance" type="mesh_attribute"><string name="name" value="{name}"/></texture>"#
        );
        agrees(&files, &lamp("ply", &tinted, &attribute), 0.1);
    }
}

/// Emitters without an extent.
const DELTA: [&str; 6] = [
    POINT,
    r#"<emitter type="spot"><transform name="to_world"><lookat origin="1, 2, 3" target="0, 0, 0" up="0, 1, 0"/>
        </transform><float name="cutoff_angle" value="35"/><rgb name="intensity" value="20, 10, 5"/></emitter>"#,
    r#"<emitter type="spot"><transform name="to_world"><lookat origin="1, 2, 3" target="0, 0, 0" up="0, 1, 0"/>
        </transform><float name="cutoff_angle" value="35"/><float name="beam_width" value="35"/>
        <texture name="texture" type="bitmap"><string name="filename" value="color.png"/></texture></emitter>"#,
    r#"<emitter type="directional"><vector name="direction" x="0.4" y="-1" z="-0.7"/></emitter>"#,
    r#"<emitter type="projector"><transform name="to_world"><lookat origin="0, 1, 3.5" target="0, 0, 0" up="0, 1, 0"/>
        </transform><float name="fov" value="50"/>
        <texture name="irradiance" type="bitmap"><string name="filename" value="color.png"/></texture></emitter>"#,
    r#"<emitter type="projector"><float name="fov" value="45"/><transform name="to_world"><lookat origin="0, 1, 3.5" target="0, 0, 0" up="0, 1, 0"/>
        </transform><float name="scale" value="3"/></emitter>"#,
];

#[test]
fn emitters_without_extent() {
    let files = Files::new();
    for emitter in DELTA {
        agrees(&files, emitter, 0.1);
    }
    agrees(&files, &DELTA.concat(), 0.2);
}

/// An environment with a transform.
fn sky(file: &str, transform: &str) -> String {
    format!(
        r#"<emitter type="envmap"><string name="filename" value="{file}"/><float name="scale" value="0.8"/>
        <transform name="to_world">{transform}</transform></emitter>"#
    )
}

#[test]
fn environments() {
    let files = Files::new();
    agrees(&files, CONSTANT, 0.9);
    for transform in [
        "",
        r#"<rotate y="1" angle="75"/>"#,
        r#"<rotate x="1" angle="-40"/><rotate z="1" angle="130"/>"#,
        r#"<scale x="-1"/><rotate y="1" angle="200"/>"#,
    ] {
        agrees(&files, &sky("sky.hdr", transform), 0.9);
    }
    // Of bytes; of one texel.
    for file in ["color.png", "grey.png", "dot.hdr"] {
        agrees(&files, &sky(file, r#"<rotate y="1" angle="30"/>"#), 0.9);
    }
}

#[test]
fn environments_behind_masks_and_other_emitters() {
    let files = Files::new();
    let window = r#"<shape type="rectangle"><transform name="to_world"><scale x="1" y="0.5" z="1"/>
        <translate y="0.8" z="1.5"/></transform>
        <bsdf type="mask"><float name="opacity" value="0.3"/><bsdf type="diffuse"/></bsdf></shape>"#;
    let turned = sky("sky.hdr", r#"<rotate y="1" angle="75"/>"#);
    agrees(&files, &format!("{window}{turned}"), 0.9);
    agrees(&files, &format!("{window}{turned}{LAMP}{POINT}"), 0.9);
    agrees(&files, &format!("{LAMP}{CONSTANT}{POINT}"), 0.9);
}

#[test]
fn few_and_many_emitters() {
    let files = Files::new();
    // As many as are compared with each other, and more than that.
    for count in [2, 24, 25, 60] {
        let emitters: String = (0..count)
            .map(|i| {
                let (x, z) = ((i % 8) as f32 * 0.4 - 1.4, (i / 8) as f32 * 0.5 - 1.0);
                let place = format!(
                    r#"<transform name="to_world"><scale value="0.1"/><rotate x="1" angle="90"/>
                    <translate x="{x}" y="1.5" z="{z}"/></transform>"#
                );
                lamp(
                    ["rectangle", "sphere", "disk", "cube"][i % 4],
                    &place,
                    BRIGHT,
                )
            })
            .collect();
        agrees(&files, &emitters, 0.2);
        agrees(&files, &format!("{emitters}{CONSTANT}"), 0.9);
    }
}

#[test]
fn weights_of_emitters() {
    let files = Files::new();
    let weighted = |emitter: &str, weight: f32| {
        let weight = format!(r#"<float name="sampling_weight" value="{weight}"/></emitter>"#);
        emitter.replace("</emitter>", &weight)
    };
    let emitters = [
        weighted(LAMP, 3.0),
        weighted(POINT, 0.2),
        weighted(CONSTANT, 0.0),
    ]
    .concat();
    agrees(&files, &emitters, 0.9);
    let emitters = [weighted(LAMP, 0.0), weighted(POINT, 0.0)].concat();
    agrees(&files, &emitters, 0.01);
}

#[test]
fn lamps_on_which_paths_end_or_go_on() {
    let files = Files::new();
    for depth in [1, 2, 3] {
        for hides in [false, true] {
            // One edge sees emitters only.
            let least = if hides && depth == 1 { 0.0 } else { 0.1 };
            let depth = format!(r#"<integer name="max_depth" value="{depth}"/>"#);
            let hides = format!(r#"<boolean name="hide_emitters" value="{hides}"/>"#);
            let room = Room {
                integrator: path(&format!("{depth}{hides}")),
                emitters: format!("{}{CONSTANT}", lamp("cube", TURNED, BRIGHT)),
                least,
                ..Room::with_material(r#"<bsdf type="roughconductor"/>"#)
            };
            room.agrees(&files);
        }
    }
}

#[test]
fn darkness() {
    let files = Files::new();
    let dark = POINT.replace("2, 3, 4", "0");
    agrees(&files, &dark, 0.0);
    let dark = r#"<emitter type="constant"><rgb name="radiance" value="0"/></emitter>"#;
    agrees(&files, dark, 0.0);
    let none = Room {
        emitters: String::new(),
        ..Room::new()
    };
    let scene = samples::scene(&none.text(), files.folder(), false);
    assert!(scene.tables.emitters.is_empty());
    assert_eq!(samples::agrees(&scene, &none.text()), 0.0);
}
