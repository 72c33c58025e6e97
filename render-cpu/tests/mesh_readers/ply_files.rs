//! PLY.

use crate::ply_writer::{ENCODINGS, Encoding, PlyWriter, XYZ, ply_file, square_rows};
use crate::{message, read_ply};
use halflight::mesh::{Attribute, Mesh, ply};
use std::path::Path;

fn square_with(extra: &[(&str, &str)], values: &[f64]) -> Mesh {
    let columns = [&XYZ[..], extra].concat();
    let rows = square_rows(values);
    let face: (&[u32], Vec<f64>) = (&[0, 1, 2, 3], Vec::new());
    let file = ply_file(
        Encoding::Ascii,
        &columns,
        &rows,
        ("uchar", "int"),
        &[],
        &[face],
    );
    read_ply(&file).unwrap()
}

#[test]
fn ply_reads_every_encoding_and_type() {
    let types = [
        "char", "int8", "uchar", "uint8", "short", "int16", "ushort", "uint16", "int", "int32",
        "uint", "uint32", "float", "float32", "double", "float64",
    ];
    let counts = ["uchar", "char", "ushort", "int", "uint"];
    for encoding in ENCODINGS {
        for scalar in types {
            for count in counts {
                let columns = [
                    ("double", "x"),
                    (scalar, "y"),
                    ("float", "z"),
                    (scalar, "nx"),
                    ("float", "ny"),
                    ("float", "nz"),
                ];
                let rows: Vec<Vec<f64>> = [[0.5, 3.0], [2.25, 100.0], [0.5, 7.0]]
                    .iter()
                    .map(|[x, y]| vec![*x, *y, -2.0, 0.0, 0.0, 4.0])
                    .collect();
                let face: (&[u32], Vec<f64>) = (&[0, 1, 2], Vec::new());
                let list = (
                    count,
                    if scalar.contains("char") {
                        "uchar"
                    } else {
                        "int"
                    },
                );
                let file = ply_file(encoding, &columns, &rows, list, &[], &[face]);
                let mesh = read_ply(&file).unwrap();
                assert_eq!(
                    mesh.positions,
                    [[0.5, 3.0, -2.0], [2.25, 100.0, -2.0], [0.5, 7.0, -2.0]],
                    "{encoding:?} {scalar}"
                );
                assert_eq!(mesh.triangles, [[0, 1, 2]]);
                assert_eq!(mesh.normals, [[0.0, 0.0, 1.0]; 3]);
            }
        }
    }
}

#[test]
fn ply_big_endian_bytes_by_hand() {
    // Not through the writer above, which might share a mistake with the reader.
    let mut file = b"ply\nformat binary_big_endian 1.0\nelement vertex 3\nproperty float x\nproperty short y\nproperty float z\nelement face 1\nproperty list ushort uint vertex_index\nend_header\n".to_vec();
    for (x, y) in [
        ([0x00, 0x00, 0x00, 0x00], [0x01, 0x00]),
        ([0x3f, 0x80, 0x00, 0x00], [0xff, 0xfe]),
        ([0xc0, 0x20, 0x00, 0x00], [0x00, 0x07]),
    ] {
        file.extend(x);
        file.extend(y);
        file.extend([0x40, 0x00, 0x00, 0x00]);
    }
    file.extend([0, 3, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 1]);
    let mesh = read_ply(&file).unwrap();
    assert_eq!(
        mesh.positions,
        [[0.0, 256.0, 2.0], [1.0, -2.0, 2.0], [-2.5, 7.0, 2.0]]
    );
    assert_eq!(mesh.triangles, [[2, 0, 1]]);
}

#[test]
fn ply_reads_texture_coordinates_by_all_names() {
    for [u, v] in [["u", "v"], ["s", "t"], ["texture_u", "texture_v"]] {
        let mesh = square_with(&[("float", u), ("float", v)], &[0.25, 0.125]);
        assert_eq!(mesh.uvs, [[0.25, 0.125]; 4], "{u} {v}");
        assert!(mesh.vertex_attributes.is_empty());
    }
    let columns = [&XYZ[..], &[("float", "u"), ("float", "v")]].concat();
    let face: (&[u32], Vec<f64>) = (&[0, 1, 2], Vec::new());
    let rows = square_rows(&[0.25, 0.125]);
    let file = ply_file(
        Encoding::Ascii,
        &columns,
        &rows,
        ("uchar", "int"),
        &[],
        &[face],
    );
    let flipped = ply::read(&file, true, Path::new("")).unwrap();
    assert_eq!(flipped.uvs, [[0.25, 0.875]; 4]);
}

/// Names as Mitsuba 3.9 reports them for the same files.
#[test]
fn ply_groups_properties_into_attributes() {
    let cases: [(&str, &[&str], Option<&str>); 12] = [
        ("float", &["r", "g", "b"], Some("vertex_color")),
        ("float", &["red", "green", "blue"], Some("vertex_color")),
        (
            "float",
            &["foo_r", "foo_g", "foo_b"],
            Some("vertex_foo_color"),
        ),
        ("float", &["foo_0", "foo_1", "foo_2"], Some("vertex_foo")),
        ("float", &["foo_1", "foo_2", "foo_3"], Some("vertex_foo")),
        ("float", &["foo_x", "foo_y", "foo_z"], Some("vertex_foo")),
        ("float", &["a_b_0", "a_b_1", "a_b_2"], Some("vertex_a_b")),
        ("float", &["temp_0"], Some("vertex_temp")),
        (
            "float",
            &["color_0", "color_1", "color_2"],
            Some("vertex_color"),
        ),
        ("float", &["temp"], None),
        ("float", &["a_x", "a_y"], None),
        ("float", &["foo_q", "foo_w", "foo_e"], None),
    ];
    for (scalar, names, expected) in cases {
        let columns: Vec<(&str, &str)> = names.iter().map(|n| (scalar, *n)).collect();
        let values = &[0.25, 0.5, 0.75][..names.len()];
        let mesh = square_with(&columns, values);
        let Some(expected) = expected else {
            assert!(mesh.vertex_attributes.is_empty(), "{names:?}");
            continue;
        };
        assert_eq!(mesh.vertex_attributes.len(), 1, "{names:?}");
        let attribute = &mesh.vertex_attributes[0];
        assert_eq!(attribute.name, expected);
        assert_eq!(attribute.channels as usize, names.len());
        let expected: Vec<f32> = [values; 4].concat().iter().map(|v| *v as f32).collect();
        assert_eq!(attribute.values, expected);
    }
}

#[test]
fn ply_scales_integer_colors_and_ignores_alpha() {
    let columns = ["red", "green", "blue", "alpha"].map(|name| ("uchar", name));
    let mesh = square_with(&columns, &[255.0, 51.0, 0.0, 9.0]);
    assert_eq!(mesh.vertex_attributes[0].name, "vertex_color");
    assert_eq!(mesh.vertex_attributes[0].channels, 3);
    assert_eq!(mesh.vertex_attributes[0].values[..3], [1.0, 0.2, 0.0]);
}

#[test]
fn ply_repeats_face_attributes_for_the_triangles_of_a_polygon() {
    for encoding in ENCODINGS {
        let columns = [("float", "r"), ("float", "g"), ("float", "b")];
        let faces: [(&[u32], Vec<f64>); 3] = [
            (&[0, 1, 2, 3], vec![0.5, 0.25, 0.125]),
            (&[0, 1], vec![9.0, 9.0, 9.0]),
            (&[2, 1, 0], vec![1.0, 2.0, 3.0]),
        ];
        let file = ply_file(
            encoding,
            &XYZ,
            &square_rows(&[]),
            ("uchar", "int"),
            &columns,
            &faces,
        );
        let mesh = read_ply(&file).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [2, 1, 0]]);
        let expected = Attribute {
            name: "face_color".into(),
            channels: 3,
            values: vec![0.5, 0.25, 0.125, 0.5, 0.25, 0.125, 1.0, 2.0, 3.0],
        };
        assert_eq!(mesh.face_attributes, [expected]);
    }
}

#[test]
fn ply_skips_what_it_does_not_know() {
    for encoding in ENCODINGS {
        let mut file = PlyWriter::new(
            encoding,
            "obj_info  x y\nelement camera 2\nproperty float view\nproperty list int short ids\n\
             element vertex 3\nproperty float x\nproperty float y\nproperty list uchar float w\nproperty float z\n\
             element face 1\nproperty list uchar float texcoord\nproperty list uchar uchar vertex_index\n\
             element edge 1\nproperty int a\n",
        );
        for length in [0, 2] {
            file.put("float", 0.5);
            file.put("int", f64::from(length));
            for _ in 0..length {
                file.put("short", 7.0);
            }
        }
        for [x, y] in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] {
            file.put("float", x);
            file.put("float", y);
            file.put("uchar", 1.0);
            file.put("float", 99.0);
            file.put("float", 3.0);
        }
        file.put("uchar", 2.0);
        file.put("float", 0.1);
        file.put("float", 0.2);
        for value in [3.0, 0.0, 1.0, 2.0] {
            file.put("uchar", value);
        }
        file.put("int", 4.0);
        let mesh = read_ply(&file.bytes).unwrap();
        assert_eq!(mesh.positions[2], [0.0, 1.0, 3.0]);
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
    }
}

#[test]
fn ply_errors_name_line_or_byte() {
    let ascii = |body: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n{body}"
        )
    };
    let square = "0 0 0\n1 0 0\n1 1 0\n";
    let cases = [
        ("plyx\n".to_owned(), ":1: not a PLY file"),
        (String::new(), ":1: not a PLY file"),
        ("ply\nformat ascii 2.0\n".into(), ":2: the version"),
        ("ply\nformat text 1.0\n".into(), ":2: unknown format"),
        ("ply\nend_header\n".into(), ":2: the header names no format"),
        (
            "ply\nformat ascii 1.0\n".into(),
            ":3: the header does not end",
        ),
        ("ply\nproperty float x\n".into(), ":2: a property before"),
        ("ply\nelement vertex -1\n".into(), ":2: the element's count"),
        (
            "ply\nelement v 1\nproperty half x\n".into(),
            ":3: unknown type",
        ),
        ("ply\nhello\n".into(), ":2: this line of the header"),
        (ascii("0 0 0\n1 zero 0\n"), ":11: \"zero\" is not a number"),
        (ascii("0 0 0\n1 1"), "too early"),
        (
            ascii(&format!("{square}-3 0 1 2\n")),
            ":13: -3 is no length",
        ),
    ];
    for (text, expected) in cases {
        let message = message(read_ply(text.as_bytes()));
        assert!(message.starts_with("test.ply"), "{message}");
        assert!(message.contains(expected), "{text:?}: {message}");
    }
    let face: (&[u32], Vec<f64>) = (&[0, 1, 2], Vec::new());
    let mut file = ply_file(
        Encoding::Little,
        &XYZ,
        &square_rows(&[]),
        ("uchar", "int"),
        &[],
        &[face],
    );
    file.truncate(file.len() - 1);
    let message = message(read_ply(&file));
    let expected = format!("test.ply: at byte {}: the file ends", file.len() - 3);
    assert!(message.starts_with(&expected), "{message}");
}

#[test]
fn ply_giant_counts_are_refused_at_once() {
    let body = "property float x\nproperty float y\nproperty float z\n";
    for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
        for count in ["1000", "4294967295", "18446744073709551615"] {
            let vertices = format!(
                "ply\nformat {format} 1.0\nelement vertex {count}\n{body}end_header\n0 0 0 0 0 0 0 0 0 "
            );
            assert!(message(read_ply(vertices.as_bytes())).contains("more than the file holds"));
            let empty = format!("ply\nformat {format} 1.0\nelement a {count}\nend_header\n");
            assert!(message(read_ply(empty.as_bytes())).contains("has no properties"));
        }
    }
    // A list that is longer than the file.
    let mut list = b"ply\nformat binary_little_endian 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uint int vertex_indices\nend_header\n".to_vec();
    list.extend([0; 12]);
    list.extend([0xff; 4]);
    assert!(message(read_ply(&list)).contains("no length of a list"));
}
