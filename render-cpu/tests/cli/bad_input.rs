//! Every kind of bad input ends in one clear line and exit code 1, without an image and without a panic.

use super::{Place, SCENE};

/// Renders `scene` and returns the error line.
fn rejected(place: &Place, scene: &str, arguments: &[&str]) -> String {
    place.write("bad.xml", scene);
    let mut all = vec!["render", "bad.xml", "-o", "bad.exr"];
    all.extend(arguments);
    let output = place.run(&all);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{scene}\n{message}");
    assert!(!message.contains("panicked"), "{message}");
    assert!(!place.path("bad.exr").exists() && !place.path("bad.png").exists());
    let errors: Vec<_> = message
        .lines()
        .filter(|l| l.starts_with("error: "))
        .collect();
    assert_eq!(errors.len(), 1, "{message}");
    errors[0].to_string()
}

/// The scene with its sphere replaced.
fn with_shape(shape: &str) -> String {
    let start = SCENE.find("<shape type=\"sphere\">").expect("the sphere");
    let end = start + SCENE[start..].find("</shape>").expect("its end") + "</shape>".len();
    format!("{}{shape}{}", &SCENE[..start], &SCENE[end..])
}

fn mesh(plugin: &str, file: &str) -> String {
    with_shape(&format!(
        "<shape type=\"{plugin}\"><string name=\"filename\" value=\"{file}\"/></shape>"
    ))
}

#[test]
fn scene_files() {
    let place = Place::with_scene();
    let cases: &[(&str, String, &[&str])] = &[
        ("malformed XML", SCENE.replace("</scene>", ""), &["bad.xml"]),
        (
            "no sensor",
            "<scene version=\"3.0.0\"></scene>".into(),
            &["no sensor"],
        ),
        (
            "a word for a number",
            SCENE.replace("value=\"45\"", "value=\"wide\""),
            &["bad.xml:5", "fov"],
        ),
        (
            "a missing parameter",
            SCENE.replace("\"$spp\"", "\"$samples\""),
            &["bad.xml:7", "samples"],
        ),
        (
            "a dangling reference",
            SCENE.replace("<bsdf type=\"dielectric\"/>", "<ref id=\"glass\"/>"),
            &["glass"],
        ),
        (
            "an absurd size",
            SCENE.replace("value=\"24\"", "value=\"4000000000\""),
            &["width"],
        ),
        (
            "a negative radius",
            SCENE.replace("value=\"0.7\"", "value=\"-0.7\""),
            &["radius"],
        ),
        (
            "not a number",
            SCENE.replace("value=\"0.7\"", "value=\"NaN\""),
            &["radius"],
        ),
        (
            "no photons",
            SCENE.replace(
                "<integer name=\"max_depth\" value=\"8\"/>",
                "<integer name=\"photonCount\" value=\"0\"/>",
            ),
            &["bad.xml:3", "photonCount"],
        ),
        (
            "a gather radius below zero",
            SCENE.replace(
                "<integer name=\"max_depth\" value=\"8\"/>",
                "<float name=\"initial_radius\" value=\"-1\"/>",
            ),
            &["bad.xml:3", "initial_radius"],
        ),
        (
            "radii that grow",
            SCENE.replace(
                "<integer name=\"max_depth\" value=\"8\"/>",
                "<float name=\"alpha\" value=\"1.5\"/>",
            ),
            &["bad.xml:3", "alpha"],
        ),
        (
            "an endless include",
            SCENE.replace("</scene>", "<include filename=\"bad.xml\"/></scene>"),
            &["bad.xml"],
        ),
    ];
    for (what, scene, parts) in cases {
        let error = rejected(&place, scene, &[]);
        for part in *parts {
            assert!(
                error.contains(part),
                "{what}: \"{part}\" is missing in {error}"
            );
        }
    }
    let missing = place.run(&["render", "nowhere.xml"]);
    assert_eq!(missing.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&missing.stderr).contains("nowhere.xml"));
}

#[test]
fn meshes_and_images() {
    let place = Place::with_scene();
    place.write("empty.obj", "");
    place.write("word.obj", "v 0 0 0\nv 1 0 0\nv zero 1 0\nf 1 2 3\n");
    place.write("huge.ply", "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nelement face 4000000000\nproperty list uchar int vertex_indices\nend_header\n");
    place.write("short.serialized", [0x1c, 0x04, 0x04, 0x00, 1, 2, 3]);
    place.write("short.exr", [0x76, 0x2f, 0x31, 0x01, 2, 0, 0, 0, 1]);
    for (plugin, file) in [
        ("obj", "missing.obj"),
        ("obj", "empty.obj"),
        ("obj", "word.obj"),
        ("ply", "huge.ply"),
        ("serialized", "short.serialized"),
    ] {
        let error = rejected(&place, &mesh(plugin, file), &[]);
        assert!(
            error.contains(file) && error.contains("bad.xml:14"),
            "{error}"
        );
    }
    let lit = SCENE.replace(
        "</scene>",
        "<emitter type=\"envmap\"><string name=\"filename\" value=\"short.exr\"/></emitter></scene>",
    );
    assert!(rejected(&place, &lit, &[]).contains("short.exr"));
}

#[test]
fn requests() {
    let place = Place::with_scene();
    for arguments in [
        &["--crop", "20,0,10,4"][..],
        &["--size", "0x10"],
        &["--integrator", "magic"],
        &["--sampler", "dice"],
        &["--photons", "1000"],
        &["--integrator", "bdpt", "--radius", "0.1"],
        &["--sensor", "3"],
        &["-D", "unheard=1"],
        &["-o", "folder/that/is/not/there.exr"],
        &["-o", "picture.gif"],
    ] {
        let mut all = vec!["render", "scene.xml"];
        if !arguments.contains(&"-o") {
            all.extend(["-o", "bad.exr"]);
        }
        all.extend(arguments);
        let output = place.run(&all);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
        assert_eq!(message.matches("error: ").count(), 1, "{message}");
        assert_eq!(place.files(), ["scene.xml"], "{arguments:?}");
    }
}

#[test]
fn unknown_plugins_warn_or_stop() {
    let place = Place::with_scene();
    for (from, to) in [
        ("type=\"dielectric\"", "type=\"velvet\""),
        ("type=\"path\"", "type=\"pathos\""),
        ("type=\"sphere\"", "type=\"teapot\""),
    ] {
        let scene = SCENE.replace(from, to);
        assert!(rejected(&place, &scene, &["--strict"]).contains("not supported"));
        let output = place.run(&["render", "bad.xml", "-o", "lenient.exr"]);
        assert!(output.status.success());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            message.contains("not supported") && message.contains("bad.xml:"),
            "{message}"
        );
    }
}

#[test]
fn a_flattened_sphere_is_left_out_or_stops() {
    let place = Place::with_scene();
    let flat = SCENE.replace(
        "<bsdf type=\"dielectric\"/>",
        "<transform name=\"to_world\"><scale x=\"0\" y=\"1\" z=\"1\"/></transform>",
    );
    let error = rejected(&place, &flat, &["--strict"]);
    assert!(
        error.contains("bad.xml:14") && error.contains("flattens"),
        "{error}"
    );
    let output = place.run(&["render", "bad.xml", "-o", "lenient.exr"]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(
        output.status.success() && message.contains("the shape is left out"),
        "{message}"
    );
}
