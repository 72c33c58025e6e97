//! `halflight material`: names, files, pictures, and what is wrong in one line.

use super::Place;

#[test]
fn materials_are_drawn() {
    let place = Place::with_scene();
    assert!(
        place
            .succeed(&["material", "--list"])
            .contains("roughcoating")
    );
    for arguments in [
        &["material", "Cu", "--spp", "1"][..],
        &["material", "scene.xml", "--spp", "1"],
    ] {
        let printed = place.succeed(arguments);
        assert_eq!(printed.trim(), "material.png");
        let picture = std::fs::read(place.path("material.png")).expect("the picture");
        assert!(picture.starts_with(b"\x89PNG") && picture.len() > 20_000);
        std::fs::remove_file(place.path("material.png")).expect("a file");
    }
}

#[test]
fn what_is_no_material_is_one_clear_line() {
    let place = Place::with_scene();
    place.write("short.binary", [1; 20]);
    place.write("empty.xml", "<scene version=\"3.0.0\"/>");
    let cases: &[(&[&str], &str)] = &[
        (&["material", "roughplastik"], "\"roughplastic\""),
        (&["material", "empty.xml"], "no bsdf"),
        (&["material", "scene.xml", "--id", "lost"], "\"lost\""),
        (&["material", "short.binary"], "cells"),
    ];
    for (arguments, wanted) in cases {
        let output = place.run(arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(
            message.starts_with("error: ") && message.contains(wanted),
            "{message}"
        );
        assert!(!message.contains("panicked"), "{message}");
        assert!(!place.path("material.png").exists());
    }
}
