//! Materials of OBJ files: their names are those of the file, to the letter.

use crate::Files;
use crate::meshes::{BOTTOM, CUBE, TOP, shape};

fn color(attributes: &str, rgb: &str) -> String {
    format!(r#"<bsdf {attributes} type="diffuse"><rgb name="reflectance" value="{rgb}"/></bsdf>"#)
}

#[test]
fn names_of_materials_keep_their_capitals() {
    let (red, blue) = ("0.7 0 0", "0 0 0.7");
    let small = format!("{CUBE}usemtl red\n{BOTTOM}usemtl blue\n{TOP}");
    for [first, second] in [
        ["MatRed", "MatBlue"],
        ["MatRed", "mat_red"],
        ["Material.001", "aB"],
        ["intIOR", "toWorld"],
    ] {
        let obj = format!("{CUBE}usemtl {first}\n{BOTTOM}usemtl {second}\n{TOP}");
        let files = Files::new(&[
            ("small.obj", small.as_bytes()),
            ("large.obj", obj.as_bytes()),
        ]);
        let expected = files.clean(
            "0.6.0",
            &shape(
                "obj",
                "small.obj",
                &(color("name=\"red\"", red) + &color("name=\"blue\"", blue)),
            ),
        );
        let name = |name: &str| format!("name=\"{name}\"");
        let nested = color(&name(first), red) + &color(&name(second), blue);
        let defined = color("id=\"r\"", red) + &color("id=\"b\"", blue);
        let referred = format!(r#"<ref name="{first}" id="r"/><ref name="{second}" id="b"/>"#);
        for content in [
            shape("obj", "large.obj", &nested),
            defined + &shape("obj", "large.obj", &referred),
            // One without a name is for all others.
            shape(
                "obj",
                "large.obj",
                &(color(&name(first), red) + &color("", blue)),
            ),
        ] {
            assert_eq!(files.clean("0.6.0", &content), expected, "{content}");
        }
        // Another spelling is another material.
        let content = shape("obj", "large.obj", &color(&name("MATRED"), red));
        let whole = files.warned("0.6.0", &content, "no face of the file has this material");
        let all = files.clean("3.0.0", &shape("obj", "small.obj", &color("", red)));
        assert_eq!(whole, all);
    }
}

#[test]
fn messages_quote_names_as_the_file_has_them() {
    let files = Files::new(&[]);
    let unknown = r#"<shape type="sphere"><float name="someSize" value="1"/></shape>"#;
    files.warned("0.6.0", unknown, "does not use this");
    let said = files.scene("0.6.0", unknown).unwrap().warnings[0].to_string();
    assert!(said.contains("<float name=\"someSize\">"), "{said}");
    let wrong = r#"<shape type="sphere"><string name="flipNormals" value="yes"/></shape>"#;
    let said = files.error("0.6.0", wrong);
    assert!(said.contains("for \"flipNormals\", found"), "{said}");
    let skin = r#"<shape type="sphere"><subsurface type="dipole"/></shape>"#;
    files.warned("0.6.0", skin, "does not use this");
    let said = files.scene("0.6.0", skin).unwrap().warnings[0].to_string();
    assert!(said.contains("<subsurface>"), "{said}");
}

#[test]
fn libraries_are_found_by_the_names_that_other_systems_give() {
    let library = b"newmtl a\nKd 0.7 0 0\nmap_d Holes.PNG\n";
    let one = |line: &str| format!("mtllib {line}\n{CUBE}usemtl a\n{BOTTOM}{TOP}").into_bytes();
    let mut png = std::io::Cursor::new(Vec::new());
    let grey = image::GrayImage::from_pixel(1, 1, image::Luma([99]));
    grey.write_to(&mut png, image::ImageFormat::Png)
        .expect("an image");
    let files = Files::new(&[
        ("a b.mtl", library),
        ("c.mtl", library),
        ("holes.png", &png.into_inner()),
        ("plain.obj", &one("c.mtl")),
        ("blank.obj", &one("a b.mtl")),
        ("quoted.obj", &one("\"a b.mtl\"")),
        ("windows.obj", &one("C:\\Users\\me\\c.mtl")),
        ("case.obj", &one("C.MTL")),
        ("none.obj", &one("d.mtl")),
    ]);
    let plain = files.clean("0.6.0", &shape("obj", "plain.obj", ""));
    for file in ["blank.obj", "quoted.obj", "windows.obj", "case.obj"] {
        let found = files.clean("0.6.0", &shape("obj", file, ""));
        assert_eq!(found, plain, "{file}");
    }
    let scene = files.scene("0.6.0", &shape("obj", "none.obj", ""));
    let warnings = scene.expect("a scene").warnings;
    assert!(
        warnings[0]
            .to_string()
            .contains("d.mtl (mtllib) is not there")
    );
}
