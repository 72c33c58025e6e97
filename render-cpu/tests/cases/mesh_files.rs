//! Mesh files as programs write them in unusual ways.

use crate::Files;
use crate::meshes::{BOTTOM, CUBE, FLAT, TOP, ply, shape};

#[test]
fn byte_order_marks_are_skipped() {
    let cube = format!("{CUBE}{BOTTOM}{TOP}");
    let marked = format!("\u{feff}{cube}");
    let wide: Vec<u8> = marked.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let wide_big: Vec<u8> = marked.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let plain_ply = ply(
        "element face 1\nproperty list uchar int vertex_indices\n",
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    );
    let marked_ply = [b"\xef\xbb\xbf".as_slice(), &plain_ply].concat();
    let spectrum = "400 1\n700 2\n";
    let marked_spectrum = format!("\u{feff}{spectrum}");
    let files = Files::new(&[
        ("plain.obj", cube.as_bytes()),
        ("marked.obj", marked.as_bytes()),
        ("wide.obj", &wide),
        ("widebig.obj", &wide_big),
        ("plain.ply", &plain_ply),
        ("marked.ply", &marked_ply),
        ("plain.spd", spectrum.as_bytes()),
        ("marked.spd", marked_spectrum.as_bytes()),
    ]);
    for file in ["marked.obj", "wide.obj", "widebig.obj"] {
        assert_eq!(
            files.clean("3.0.0", &shape("obj", file, FLAT)),
            files.clean("3.0.0", &shape("obj", "plain.obj", FLAT)),
            "{file}"
        );
    }
    assert_eq!(
        files.clean("3.0.0", &shape("ply", "marked.ply", "")),
        files.clean("3.0.0", &shape("ply", "plain.ply", ""))
    );
    let lamp = |file: &str| {
        format!(
            r#"<shape type="sphere"><emitter type="area"><spectrum name="radiance" filename="{file}"/></emitter></shape>"#
        )
    };
    assert_eq!(
        files.clean("3.0.0", &lamp("marked.spd")),
        files.clean("3.0.0", &lamp("plain.spd"))
    );
}

#[test]
fn obj_files_as_programs_write_them() {
    let cube = format!("{CUBE}{BOTTOM}{TOP}");
    let faces_first = format!("{BOTTOM}{TOP}{CUBE}");
    let old_keyword = cube.replace("f ", "fo ");
    let spare_slashes = cube.replace("f 4 3 2 1", "f 4// 3/ 2// 1/");
    let weights = CUBE.replace('\n', " 1.0\n") + BOTTOM + TOP;
    let lines = format!("{cube}l 1 2 3\np 1\n");
    let two_corners = format!("{cube}f 1 2\nf 3\n");
    let missing = cube.replace("f 4 3 2 1", "f 4/7/9 3/7/9 2/7/9 1/7/9");
    let not_numbers = format!("{CUBE}vn -1.#IND 0 0\nvn 0 0 1.#QNAN\n{BOTTOM}{TOP}");
    let files = Files::new(&[
        ("plain.obj", cube.as_bytes()),
        ("first.obj", faces_first.as_bytes()),
        ("old.obj", old_keyword.as_bytes()),
        ("slashes.obj", spare_slashes.as_bytes()),
        ("weights.obj", weights.as_bytes()),
        ("lines.obj", lines.as_bytes()),
        ("two.obj", two_corners.as_bytes()),
        ("missing.obj", missing.as_bytes()),
        ("nan.obj", not_numbers.as_bytes()),
    ]);
    let plain = files.clean("3.0.0", &shape("obj", "plain.obj", FLAT));
    for file in [
        "first.obj",
        "old.obj",
        "slashes.obj",
        "weights.obj",
        "nan.obj",
    ] {
        assert_eq!(
            files.clean("3.0.0", &shape("obj", file, FLAT)),
            plain,
            "{file}"
        );
    }
    for (file, words) in [
        ("lines.obj", "2 points, lines"),
        ("two.obj", "2 faces with fewer than three corners"),
    ] {
        assert_eq!(
            files.warned("3.0.0", &shape("obj", file, FLAT), words),
            plain,
            "{file}"
        );
    }
    let scene = files
        .scene("3.0.0", &shape("obj", "missing.obj", FLAT))
        .unwrap();
    assert_eq!(scene.warnings.len(), 2, "{:?}", scene.warnings);
    assert_eq!(scene.tables.fingerprint(), plain);
}

#[test]
fn ply_files_as_programs_write_them() {
    let face = "element face 1\nproperty list uchar int vertex_indices\n";
    let vertices = "0 0 0\n1 0 0\n0 1 0\n";
    let plain = ply(face, &format!("{vertices}3 0 1 2\n"));
    let returns = String::from_utf8(plain.clone())
        .unwrap()
        .replace('\n', "\r");
    let both = String::from_utf8(plain.clone())
        .unwrap()
        .replace('\n', "\r\n");
    let strips = ply(
        "element tristrips 1\nproperty list int int vertex_indices\n",
        &format!("{vertices}8 0 1 2 -1 2 2 1 -1\n"),
    );
    let edges = ply(
        &format!("{face}element edge 1\nproperty int vertex1\nproperty int vertex2\n"),
        &format!("{vertices}3 0 1 2\n0 1\n"),
    );
    let wedges = ply(
        &format!("{face}property list uchar float texcoord\n").replace("face 1", "face 2"),
        &format!("{vertices}3 0 1 2 6 0 0 1 0 0 1\n3 2 1 0 6 0.5 1 1 0 0.5 0.5\n"),
    );
    let files = Files::new(&[
        ("plain.ply", &plain),
        ("returns.ply", returns.as_bytes()),
        ("both.ply", both.as_bytes()),
        ("strips.ply", &strips),
        ("edges.ply", &edges),
        ("wedges.ply", &wedges),
    ]);
    let expected = files.clean("3.0.0", &shape("ply", "plain.ply", ""));
    for file in ["returns.ply", "both.ply", "strips.ply"] {
        assert_eq!(
            files.clean("3.0.0", &shape("ply", file, "")),
            expected,
            "{file}"
        );
    }
    assert_eq!(
        files.warned(
            "3.0.0",
            &shape("ply", "edges.ply", ""),
            "1 lines are left out"
        ),
        expected
    );
    let scene = files
        .scene("3.0.0", &shape("ply", "wedges.ply", FLAT))
        .unwrap();
    // The corner at (1, 0, 0) has the same coordinates in both faces.
    assert_eq!(scene.tables.positions.len(), 5);
    assert_eq!(
        scene.tables.uvs,
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.5, 1.0], [0.5, 0.5]]
    );
}

#[test]
fn what_is_left_of_a_ply_file_is_said() {
    let one = "element face 1\nproperty list uchar int vertex_indices\n";
    let rows = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let binary = |rest: &[u8]| {
        let mut bytes = String::from_utf8(ply(one, ""))
            .expect("text")
            .replace("ascii", "binary_little_endian")
            .into_bytes();
        for x in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
            bytes.extend(x.to_le_bytes());
        }
        bytes.push(3);
        bytes.extend([0_i32, 1, 2].iter().flat_map(|i| i.to_le_bytes()));
        [&bytes, rest].concat()
    };
    let with_material = format!("element material 1\nproperty float shine\n{one}");
    let with_camera = format!("{one}element camera 1\nproperty float view_px\n");
    let material_rows = "0 0 0\n1 0 0\n0 1 0\n0.5\n3 0 1 2\n";
    let files = Files::new(&[
        ("plain.ply", &ply(one, rows)),
        ("more.ply", &ply(one, &format!("{rows}3 0 2 1\n"))),
        ("blank.ply", &ply(one, &format!("{rows}\n \r\n"))),
        ("binary.ply", &binary(b"")),
        ("padded.ply", &binary(b"\n\0\0")),
        ("long.ply", &binary(b"\x03\0\0\0")),
        ("material.ply", &ply(&with_material, material_rows)),
        ("camera.ply", &ply(&with_camera, &format!("{rows}0.5\n"))),
    ]);
    let plain = files.clean("3.0.0", &shape("ply", "plain.ply", ""));
    for file in ["blank.ply", "binary.ply", "padded.ply", "camera.ply"] {
        assert_eq!(
            files.clean("3.0.0", &shape("ply", file, "")),
            plain,
            "{file}"
        );
    }
    for (file, words) in [
        ("more.ply", "7 bytes are left"),
        ("long.ply", "1 bytes are left"),
        ("material.ply", "the element \"material\" is not read"),
    ] {
        assert_eq!(files.warned("3.0.0", &shape("ply", file, ""), words), plain);
    }
}

#[test]
fn indices_beyond_all_numbers_leave_out_their_face() {
    let cube = format!("{CUBE}{BOTTOM}{TOP}");
    let files = Files::new(&[
        ("plain.obj", cube.as_bytes()),
        (
            "far.obj",
            format!("{cube}f 1 2 99999999999999999999\n").as_bytes(),
        ),
        (
            "below.obj",
            format!("{cube}f 1 2 -99999999999999999999\n").as_bytes(),
        ),
    ]);
    let plain = files.clean("3.0.0", &shape("obj", "plain.obj", FLAT));
    for file in ["far.obj", "below.obj"] {
        let found = files.warned("3.0.0", &shape("obj", file, FLAT), "1 faces name vertices");
        assert_eq!(found, plain);
    }
}

#[test]
fn one_shape_of_an_obj_file() {
    // As Mitsuba 0.6 counts: a line of a group or a material begins a shape, once there are faces.
    let many = format!(
        "g first\nusemtl a\n{CUBE}{BOTTOM}o same\nf 1 2 6\ng second\ng third\nusemtl b\n{TOP}usemtl a\nf 1 2 3\n"
    );
    let of = |faces: &str| format!("{CUBE}{faces}");
    let ahead = format!("{BOTTOM}g b\n{TOP}{CUBE}");
    let files = Files::new(&[
        ("many.obj", many.as_bytes()),
        ("0.obj", of(&format!("{BOTTOM}f 1 2 6\n")).as_bytes()),
        ("1.obj", of(TOP).as_bytes()),
        ("2.obj", of("f 1 2 3\n").as_bytes()),
        ("ahead.obj", ahead.as_bytes()),
        ("all.obj", of(&format!("{BOTTOM}{TOP}")).as_bytes()),
    ]);
    let grey = r#"<bsdf type="diffuse"/>"#;
    let chosen =
        |index: i32| format!(r#"{grey}{FLAT}<integer name="shapeIndex" value="{index}"/>"#);
    for index in 0..3 {
        assert_eq!(
            files.clean("0.6.0", &shape("obj", "many.obj", &chosen(index))),
            files.clean(
                "0.6.0",
                &shape("obj", &format!("{index}.obj"), &format!("{grey}{FLAT}"))
            ),
            "{index}"
        );
    }
    let second = shape("obj", "1.obj", &format!("{grey}{FLAT}"));
    assert_eq!(
        files.clean("0.6.0", &shape("obj", "ahead.obj", &chosen(1))),
        files.clean("0.6.0", &second)
    );
    let whole = shape("obj", "all.obj", &format!("{grey}{FLAT}"));
    for properties in [
        chosen(-1),
        format!(r#"{}<boolean name="collapse" value="true"/>"#, chosen(1)),
    ] {
        assert_eq!(
            files.clean("0.6.0", &shape("obj", "ahead.obj", &properties)),
            files.clean("0.6.0", &whole)
        );
    }
    let scene = files
        .scene("0.6.0", &shape("obj", "many.obj", &chosen(3)))
        .expect("a scene");
    let warnings: Vec<String> = scene.warnings.iter().map(ToString::to_string).collect();
    assert!(
        warnings[0].contains("no shape number 3 in it; there are 3, from 0 on")
            && warnings[1].contains("left out"),
        "{warnings:?}"
    );
}

#[test]
fn textures_that_ply_files_name_are_said() {
    let file = |comment: &str| {
        ply(
            "property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\n",
            "0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n",
        )
        .iter()
        .map(|b| *b as char)
        .collect::<String>()
        .replace("format ascii 1.0\n", &format!("format ascii 1.0\n{comment}\n"))
    };
    let (meshlab, other) = (
        file("comment TextureFile old wood.png"),
        file("comment made by texturefile"),
    );
    let files = Files::new(&[
        ("meshlab.ply", meshlab.as_bytes()),
        (
            "lower.ply",
            file("comment texturefile\twood.png").as_bytes(),
        ),
        ("other.ply", other.as_bytes()),
    ]);
    let plain = files.clean("3.0.0", &shape("ply", "other.ply", ""));
    for (name, texture) in [("meshlab.ply", "old wood.png"), ("lower.ply", "wood.png")] {
        assert_eq!(
            files.warned("3.0.0", &shape("ply", name, ""), texture),
            plain
        );
    }
    files.clean(
        "3.0.0",
        &shape("ply", "meshlab.ply", r#"<bsdf type="diffuse"/>"#),
    );
}
