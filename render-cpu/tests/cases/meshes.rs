//! Meshes: degenerate ones, materials by name, sharp edges.

use crate::Files;

pub const CUBE: &str =
    "v -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n";
pub const BOTTOM: &str = "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\n";
pub const TOP: &str = "f 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

pub fn shape(plugin: &str, file: &str, properties: &str) -> String {
    format!(
        r#"<shape type="{plugin}"><string name="filename" value="{file}"/>{properties}</shape>"#
    )
}

pub const FLAT: &str = r#"<boolean name="face_normals" value="true"/>"#;

pub fn ply(header: &str, body: &str) -> Vec<u8> {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n{header}end_header\n{body}"
    )
    .into_bytes()
}

#[test]
fn a_shape_without_a_usable_face_is_left_out() {
    let empty_ply = ply(
        "element face 0\nproperty list uchar int vertex_indices\n",
        "0 0 0\n1 0 0\n0 1 0\n",
    );
    let small_ply = ply(
        "element face 1\nproperty list uchar int vertex_indices\n",
        "0 0 0\n1 0 0\n0 1 0\n2 0 1\n",
    );
    let no_faces = ply("", "0 0 0\n1 0 0\n0 1 0\n");
    let files = Files::new(&[
        ("points.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
        ("empty.ply", &empty_ply),
        ("nofaces.ply", &no_faces),
        ("sliver.obj", b"v 0 0 0\nv 0 1 0\nv 0 2 0\nf 1 2 3\n"),
        ("small.ply", &small_ply),
        ("flat.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    ]);
    let rest = r#"<shape type="sphere"/>"#;
    let without = files.clean("3.0.0", rest);
    for (plugin, file) in [
        ("obj", "points.obj"),
        ("ply", "empty.ply"),
        ("ply", "nofaces.ply"),
    ] {
        let content = shape(
            plugin,
            file,
            r#"<bsdf type="diffuse"/><emitter type="area"/>"#,
        ) + rest;
        assert_eq!(files.warned("3.0.0", &content, file), without, "{file}");
    }
    // What makes them empty is said as well.
    for (plugin, file, why) in [
        ("obj", "sliver.obj", "no area"),
        ("ply", "small.ply", "fewer than three"),
    ] {
        let scene = files
            .scene("3.0.0", &(shape(plugin, file, "") + rest))
            .unwrap();
        let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
        assert!(
            warnings[0].contains(why) && warnings[1].contains("left out"),
            "{warnings:?}"
        );
        assert_eq!(scene.tables.fingerprint(), without);
    }
    // Flattened until nothing is left, by a transform or by their own parameters.
    let flat = r#"<transform name="to_world"><scale x="1" y="0" z="1"/></transform>"#;
    let line = r#"<transform name="to_world"><scale x="1" y="0" z="0"/></transform>"#;
    for content in [
        format!(r#"<shape type="sphere">{flat}</shape>"#),
        format!(r#"<shape type="disk">{line}</shape>"#),
        r#"<shape type="sphere"><float name="radius" value="0"/></shape>"#.into(),
        r#"<shape type="cylinder"><point name="p1" value="0 0 0"/></shape>"#.into(),
        format!(
            r#"<shape type="shapegroup" id="g"><shape type="sphere"/></shape><shape type="instance"><ref id="g"/>{flat}</shape>"#
        ),
    ] {
        assert_eq!(
            files.warned("3.0.0", &(content.clone() + rest), "left out"),
            without,
            "{content}"
        );
    }
    let content = shape("obj", "flat.obj", flat) + rest;
    let scene = files.scene("3.0.0", &content).unwrap();
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    assert_eq!(scene.tables.fingerprint(), without);
}

#[test]
fn a_flattened_mesh_keeps_the_faces_that_are_left() {
    let files = Files::new(&[]);
    let content = r#"<shape type="cube"><transform name="to_world"><scale x="1" y="1" z="0"/></transform></shape>"#;
    let scene = files.scene("3.0.0", content).unwrap();
    assert_eq!(scene.tables.triangles.len(), 4);
    assert!(
        scene.warnings[0].to_string().contains("8 of 12 triangles"),
        "{:?}",
        scene.warnings
    );
}

#[test]
fn a_scene_may_be_left_without_a_shape() {
    let files = Files::new(&[("points.obj", b"v 0 0 0\n")]);
    let scene = files
        .scene("3.0.0", &shape("obj", "points.obj", ""))
        .unwrap();
    crate::assert_mean(&scene, 1, 1.0, 1e-6);
    let group = format!(
        r#"<shape type="shapegroup" id="g">{}</shape><shape type="instance"><ref id="g"/></shape>"#,
        shape("obj", "points.obj", "")
    );
    crate::assert_mean(&files.scene("3.0.0", &group).unwrap(), 1, 1.0, 1e-6);
}

#[test]
fn materials_of_an_obj_file_choose_among_named_surfaces() {
    let one = format!("{CUBE}usemtl red\n{BOTTOM}usemtl blue\n{TOP}");
    let mixed = format!(
        "{CUBE}g a\nusemtl red\nf 4 3 2 1\nusemtl blue\nf 2 3 7 6\nusemtl red\nf 5 6 7 8\nf 1 2 6 5\nusemtl  blue \nf 3 4 8 7\nf 4 1 5 8\n"
    );
    let before = format!("{CUBE}{BOTTOM}usemtl blue\n{TOP}");
    let odd = format!("{CUBE}usemtl red #1 of 2\n{BOTTOM}usemtl blue\\\n\n{TOP}");
    let (red_file, blue_file) = (format!("{CUBE}{BOTTOM}"), format!("{CUBE}{TOP}"));
    let files = Files::new(&[
        ("one.obj", one.as_bytes()),
        ("mixed.obj", mixed.as_bytes()),
        ("before.obj", before.as_bytes()),
        ("odd.obj", odd.as_bytes()),
        ("red.obj", red_file.as_bytes()),
        ("blue.obj", blue_file.as_bytes()),
    ]);
    let color = |attributes: &str, rgb: &str| {
        format!(
            r#"<bsdf {attributes} type="diffuse"><rgb name="reflectance" value="{rgb}"/></bsdf>"#
        )
    };
    let (red, blue) = ("0.7 0 0", "0 0 0.7");
    let apart = files.clean(
        "0.6.0",
        &(shape("obj", "red.obj", &color("", red)) + &shape("obj", "blue.obj", &color("", blue))),
    );
    let both = color("name=\"red\"", red) + &color("name=\"blue\"", blue);
    let defined = color("id=\"r\"", red) + &color("id=\"b\"", blue);
    let referred = r#"<ref name="red" id="r"/><ref name="blue" id="b"/>"#;
    for content in [
        shape("obj", "one.obj", &both),
        shape("obj", "mixed.obj", &both),
        defined.clone() + &shape("obj", "one.obj", referred),
        // One without a name is for all others.
        shape(
            "obj",
            "one.obj",
            &(color("name=\"red\"", red) + &color("", blue)),
        ),
        shape(
            "obj",
            "before.obj",
            &(color("name=\"blue\"", blue) + &color("", red)),
        ),
        shape(
            "obj",
            "odd.obj",
            &(color("name=\"red\"", red) + &color("", blue)),
        ),
    ] {
        assert_eq!(files.clean("0.6.0", &content), apart, "{content}");
    }
    files.warned(
        "0.6.0",
        &shape(
            "obj",
            "one.obj",
            &(both.clone() + &color("name=\"green\"", blue)),
        ),
        "red, blue",
    );
    files.warned(
        "0.6.0",
        &shape("obj", "one.obj", &color("name=\"red\"", red)),
        "\"blue\" (usemtl)",
    );
    // Without any, 0.6 would look for a library of materials.
    files.warned("0.6.0", &shape("obj", "one.obj", ""), "mtllib");
    files.clean(
        "0.6.0",
        &shape(
            "obj",
            "one.obj",
            r#"<boolean name="loadMaterials" value="false"/>"#,
        ),
    );
    files.clean("3.0.0", &shape("obj", "one.obj", ""));
    // Later versions give one surface to the whole shape, whatever its name.
    let whole = files.clean(
        "3.0.0",
        &shape("obj", "one.obj", &color("name=\"red\"", red)),
    );
    assert_eq!(
        whole,
        files.clean("3.0.0", &shape("obj", "one.obj", &color("", red)))
    );
    let error = files.error(
        "0.6.0",
        &shape(
            "obj",
            "one.obj",
            &(both + &color("", red) + &color("", blue)),
        ),
    );
    assert!(error.contains("already"), "{error}");
    let error = files.error(
        "0.6.0",
        &format!(
            "<shape type=\"sphere\">{}{}</shape>",
            color("", red),
            color("", blue)
        ),
    );
    assert!(error.contains("takes only one bsdf"), "{error}");
}

#[test]
fn edges_beyond_the_largest_smooth_angle_are_sharp() {
    let cube = format!("{CUBE}{BOTTOM}{TOP}");
    let faces: Vec<String> = format!("{BOTTOM}{TOP}")
        .lines()
        .map(|line| {
            format!(
                "4 {}",
                line[2..]
                    .split(' ')
                    .map(|i| (i.parse::<u32>().unwrap() - 1).to_string())
                    .collect::<Vec<_>>()
                    .join(" ")
            )
        })
        .collect();
    let vertices = CUBE.replace("v ", "");
    let ply = format!(
        "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement face 6\nproperty list uchar int vertex_indices\nend_header\n{vertices}{}\n",
        faces.join("\n")
    );
    let files = Files::new(&[("cube.obj", cube.as_bytes()), ("cube.ply", ply.as_bytes())]);
    let angle = |degrees: f64| format!(r#"<float name="maxSmoothAngle" value="{degrees}"/>"#);
    for (plugin, file) in [("obj", "cube.obj"), ("ply", "cube.ply")] {
        let normals = |properties: &str| {
            let scene = files
                .scene("0.6.0", &shape(plugin, file, properties))
                .unwrap();
            assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
            scene.tables.normals
        };
        for sharp in [0.0, 30.0, 89.0] {
            let normals = normals(&angle(sharp));
            assert_eq!(normals.len(), 24);
            let is_along_an_axis = |n: &[f32; 3]| n.iter().filter(|x| **x == 0.0).count() == 2;
            assert!(normals.iter().all(is_along_an_axis), "{normals:?}");
        }
        assert_eq!(normals(&angle(91.0)), normals(""));
        // Angles are those of the placed mesh: a cube sheared until its corners are blunt.
        let sheared = r#"<transform name="toWorld"><matrix value="1 0.9 0 0 0 1 0 0 0 0 1 0 0 0 0 1"/></transform>"#;
        assert!(normals(&(angle(60.0) + sheared)).len() < 24);
        let both = angle(30.0) + r#"<boolean name="faceNormals" value="true"/>"#;
        assert!(
            files
                .error("0.6.0", &shape(plugin, file, &both))
                .contains("together with face normals")
        );
        assert!(
            files
                .error("0.6.0", &shape(plugin, file, &angle(200.0)))
                .contains("180")
        );
    }
}
