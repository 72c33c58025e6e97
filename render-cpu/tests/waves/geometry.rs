//! Surfaces with and without loops of their own: meshes with any normals, quadrics, instances.

use crate::files::Files;
use crate::room::{CONSTANT, Room};
use crate::samples;

const MATERIALS: [&str; 3] = [
    r#"<bsdf type="diffuse"><texture name="reflectance" type="checkerboard"/></bsdf>"#,
    r#"<bsdf type="twosided"><bsdf type="roughconductor"><float name="alpha_u" value="0.1"/>
        <float name="alpha_v" value="0.4"/></bsdf></bsdf>"#,
    r#"<bsdf type="roughdielectric"/>"#,
];

/// A shape in the room, `parameters` before its material.
fn agrees(files: &Files, plugin: &str, parameters: &str) {
    for material in MATERIALS {
        let mut room = Room {
            shapes: format!(r#"<shape type="{plugin}">{parameters}{material}</shape>"#),
            ..Room::with_material(r#"<bsdf type="plastic"/>"#)
        };
        room.emitters += CONSTANT;
        room.agrees(files);
    }
}

const PLACE: &str = r#"<transform name="to_world"><scale x="0.9" y="0.4" z="0.6"/><rotate y="1" angle="40"/>
    <rotate x="1" angle="35"/><translate x="0.2" y="0.7" z="1.2"/></transform>"#;
const MIRRORED: &str = r#"<transform name="to_world"><scale x="-0.9" y="0.4" z="0.6"/><rotate y="1" angle="40"/>
    <translate x="0.2" y="0.7" z="1.2"/></transform>"#;

#[test]
fn normals_of_meshes() {
    let files = Files::new();
    for (plugin, file) in [
        ("obj", r#"<string name="filename" value="ball.obj"/>"#),
        ("ply", r#"<string name="filename" value="tinted.ply"/>"#),
        ("cube", ""),
        ("rectangle", ""),
    ] {
        for place in [PLACE, MIRRORED] {
            agrees(&files, plugin, &format!("{file}{place}"));
        }
        let flipped = r#"<boolean name="flip_normals" value="true"/>"#;
        agrees(&files, plugin, &format!("{file}{PLACE}{flipped}"));
    }
    let flat =
        r#"<string name="filename" value="ball.obj"/><boolean name="face_normals" value="true"/>"#;
    agrees(&files, "obj", &format!("{flat}{PLACE}"));
}

#[test]
fn quadrics() {
    let files = Files::new();
    for plugin in ["sphere", "disk", "cylinder"] {
        for place in [PLACE, MIRRORED] {
            agrees(&files, plugin, place);
        }
    }
}

#[test]
fn instances() {
    let files = Files::new();
    for material in MATERIALS {
        let mut room = Room {
            shapes: format!(
                r#"<shape type="shapegroup" id="group"><shape type="cube"><transform name="to_world">
                    <scale value="0.5"/></transform>{material}</shape>
                <shape type="sphere"><point name="center" x="0" y="0.8" z="0"/><float name="radius" value="0.4"/>
                    {material}</shape></shape>
                <shape type="instance"><ref id="group"/>{PLACE}</shape>
                <shape type="instance"><ref id="group"/><transform name="to_world"><scale x="-0.5" y="0.5" z="0.5"/>
                    <translate x="-0.7" y="1" z="1"/></transform></shape>"#
            ),
            ..Room::with_material(material)
        };
        room.emitters += CONSTANT;
        room.agrees(&files);
    }
}

#[test]
fn nothing_to_meet_but_the_sky() {
    let files = Files::new();
    // Behind the camera.
    let mut room = Room::new();
    room.emitters = CONSTANT.into();
    let text = room
        .text()
        .replace(r#"target="0, 0, 0""#, r#"target="0, 0, 9""#);
    let scene = samples::scene(&text, files.folder(), true);
    assert_eq!(samples::agrees(&scene, &text), 1.0);
}
