//! Readers of mesh files: every variant reads back what was written, errors name the line or byte, and no bytes make
//! them panic or reserve memory that the file cannot fill.

use flate2::Compression;
use flate2::write::ZlibEncoder;
use halflight::mesh::{Attribute, Mesh, MeshError, obj, ply, serialized};
use proptest::prelude::*;
use std::io::Write;
use std::path::Path;

fn read_obj(text: &str) -> Result<Mesh, MeshError> {
    obj::read(text.as_bytes(), false, Path::new("test.obj"))
}

fn read_ply(bytes: &[u8]) -> Result<Mesh, MeshError> {
    ply::read(bytes, false, Path::new("test.ply"))
}

fn read_serialized(bytes: &[u8], index: u32) -> Result<Mesh, MeshError> {
    serialized::read(bytes, index, Path::new("test.serialized"))
}

fn message(result: Result<Mesh, MeshError>) -> String {
    result.expect_err("this file is wrong").to_string()
}

fn area(mesh: &Mesh) -> f64 {
    let corner = |i: u32| mesh.positions[i as usize].map(f64::from);
    let triangle_area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(corner);
        let e = |p: [f64; 3], k: usize| p[k] - a[k];
        let n = [
            e(b, 1) * e(c, 2) - e(b, 2) * e(c, 1),
            e(b, 2) * e(c, 0) - e(b, 0) * e(c, 2),
            e(b, 0) * e(c, 1) - e(b, 1) * e(c, 0),
        ];
        0.5 * (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt()
    };
    mesh.triangles.iter().map(triangle_area).sum()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

// Wavefront OBJ ---------------------------------------------------------------------------------------------------

#[test]
fn obj_reads_every_form_of_corner() {
    let tables = format!("{SQUARE}vt 0.1 0.2\nvt 0.3 0.4\nvt 0.5 0.6\nvn 0 0 2\n");
    for (face, has_uvs, has_normals) in [
        ("1 2 3", false, false),
        ("1/1 2/2 3/3", true, false),
        ("1//1 2//1 3//1", false, true),
        ("1/1/1 2/2/1 3/3/1", true, true),
        ("-4/-3/-1 -3/-2/-1 -2/-1/-1", true, true),
    ] {
        let mesh = read_obj(&format!("{tables}f {face}\n")).unwrap();
        assert_eq!(mesh.triangles, [[0, 1, 2]], "{face}");
        assert_eq!(
            mesh.positions,
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]
        );
        let uvs: &[[f32; 2]] = &[[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]];
        assert_eq!(mesh.uvs, if has_uvs { uvs } else { &[] }, "{face}");
        let normals: &[[f32; 3]] = &[[0.0, 0.0, 1.0]; 3];
        assert_eq!(mesh.normals, if has_normals { normals } else { &[] });
    }
}

#[test]
fn obj_negative_indices_count_back_from_the_latest() {
    let mesh =
        read_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 5 0 0\nv 6 0 0\nv 5 1 0\nf -3 -2 -1\n")
            .unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.positions[3], [5.0, 0.0, 0.0]);
}

#[test]
fn obj_merges_equal_triples_in_order_of_use() {
    // Mitsuba 3.9 gives the same counts and order for these three files.
    let shared = read_obj(&format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    assert_eq!(shared.positions.len(), 4);
    assert_eq!(shared.triangles, [[0, 1, 2], [0, 2, 3]]);
    let coincident =
        read_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 0 0\nv 1 1 0\nv 0 1 1\nf 1 2 3\nf 4 5 6\n");
    assert_eq!(coincident.unwrap().positions.len(), 6);
    let unused = read_obj("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 2 3 4\n").unwrap();
    assert_eq!(unused.positions.len(), 3);
    // A seam in the texture coordinates splits vertices.
    let seam = format!("{SQUARE}vt 0 0\nvt 1 1\nf 1/1 2/1 3/1\nf 1/2 3/1 4/1\n");
    let seam = read_obj(&seam).unwrap();
    assert_eq!(seam.triangles, [[0, 1, 2], [3, 2, 4]]);
}

#[test]
fn obj_tolerates_line_ends_comments_and_continuations() {
    let reference = read_obj(&format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    let text = "# a path\\\r\nv 0 0 0 # origin\r\nv 1 \\\r\n 0 0\rv 1 1 0\r\n\r\n\tv 0 1 0\r\ng group\nusemtl a\\\n b\ns 1\nf 1 2 \\\n3 \\\n 4";
    assert_eq!(read_obj(text).unwrap(), reference);
    let latin1 = b"# caf\xe9\no \xff\xfe\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3";
    obj::read(latin1, true, Path::new("test.obj")).unwrap();
}

#[test]
fn obj_flips_texture_coordinates_as_asked() {
    let text = format!("{SQUARE}vt 0.25 0.125\nf 1/1 2/1 3/1\n");
    let flipped = obj::read(text.as_bytes(), true, Path::new("")).unwrap();
    assert_eq!(flipped.uvs[0], [0.25, 0.875]);
    assert_eq!(read_obj(&text).unwrap().uvs[0], [0.25, 0.125]);
}

#[test]
fn obj_reads_vertex_colors() {
    let mesh = read_obj("v 0 0 0\nv 1 0 0 0.5 0.25 0\nv 0 1 0 0 1 0\nf 1 2 3\n").unwrap();
    let expected = Attribute {
        name: "vertex_color".into(),
        channels: 3,
        values: vec![1.0, 1.0, 1.0, 0.5, 0.25, 0.0, 0.0, 1.0, 0.0],
    };
    assert_eq!(mesh.vertex_attributes, [expected]);
}

#[test]
fn obj_errors_name_file_and_line() {
    for (text, line, what) in [
        ("v 0 0\n", 1, "three coordinates"),
        ("\n\nv 0 zero 0\n", 3, "\"zero\" is not a number"),
        ("v 0 0 0\r\nv 0 0 nan\r\n", 2, "not a usable point"),
        ("v 0 0 0\rv 0 0 1e999\r", 2, "not a usable point"),
        ("v 0 \\\n 0 0\nvn 1 2\n", 3, "three numbers"),
        ("v 0 0 0\nf 1 2 3\n", 2, "vertex 2 does not exist; 1"),
        ("v 0 0 0\nf 1 0 1\n", 2, "vertex 0 does not exist"),
        ("v 0 0 0\nf 1 -2 1\n", 2, "vertex -2 does not exist"),
        ("v 0 0 0\nf 1/1 1 1\n", 2, "texture coordinate 1 does not"),
        ("v 0 0 0\nf 1//4 1 1\n", 2, "normal 4 does not exist"),
        ("v 0 0 0\n\nf 1 1\n", 3, "three corners"),
        ("v 0 0 0\nf 1 /1 1\n", 2, "not an index"),
        ("v 0 0 0\nf 1 1/1/1/1 1\n", 2, "does not exist"),
        (
            "v 0 0 0\nf 99999999999999999999 1 1\n",
            2,
            "not an index of a corner",
        ),
        ("v 0 0 0\nf -9223372036854775808 1 1\n", 2, "does not exist"),
    ] {
        let message = message(read_obj(text));
        assert!(
            message.starts_with(&format!("test.obj:{line}: ")),
            "{text:?}: {message}"
        );
        assert!(message.contains(what), "{text:?}: {message}");
    }
    assert!(message(read_obj("")).contains("no triangle"));
}

/// A quad with a reflex corner, started at each corner in turn: a fan from the wrong one would have too much area.
#[test]
fn concave_quads_are_triangulated_inside() {
    let corners = [[0, 0], [4, 0], [1, 1], [0, 4]];
    for first in 0..4 {
        for reverse in [false, true] {
            let mut order: Vec<usize> = (0..4).map(|k| (k + first) % 4).collect();
            if reverse {
                order.reverse();
            }
            for axis in 0..3 {
                let mut text = String::new();
                for [x, y] in corners {
                    let p = match axis {
                        0 => [7, x, y],
                        1 => [x, 7, y],
                        _ => [x, y, 7],
                    };
                    text += &format!("v {} {} {}\n", p[0], p[1], p[2]);
                }
                let face: Vec<String> = order.iter().map(|i| (i + 1).to_string()).collect();
                let mesh = read_obj(&format!("{text}f {}\n", face.join(" "))).unwrap();
                assert_eq!(mesh.triangles.len(), 2);
                assert_eq!(area(&mesh), 4.0, "from corner {first}, axis {axis}");
            }
        }
    }
}

/// A comb: many reflex corners, of which no fan is right.
#[test]
fn concave_polygons_are_triangulated_inside() {
    let mut corners = vec![[0.0, -1.0], [20.0, -1.0]];
    for tooth in (0..20).rev() {
        corners.push([f64::from(tooth) + 1.0, 5.0]);
        corners.push([f64::from(tooth) + 0.5, 0.0]);
    }
    corners.push([0.0, 5.0]);
    let n = corners.len();
    let mut expected = 0.0;
    let mut text = String::new();
    let mut face = String::from("f");
    for k in 0..n {
        let ([x0, y0], [x1, y1]) = (corners[k], corners[(k + 1) % n]);
        expected += 0.5 * (x0 * y1 - x1 * y0);
        text += &format!("v {x0} 0 {y0}\n");
        face += &format!(" {}", k + 1);
    }
    let mesh = read_obj(&(text + &face)).unwrap();
    assert_eq!(mesh.triangles.len(), n - 2);
    assert!((area(&mesh) - expected).abs() < 1e-9 * expected);
}

#[test]
fn a_huge_self_intersecting_polygon_ends_in_time() {
    // 4000 corners in a scrambled order have few ears; the work budget turns the rest into a fan.
    let n = 4000_u64;
    let mut text = String::new();
    let mut face = String::from("f");
    for k in 0..n {
        let angle = ((k * 1237) % n) as f64;
        text += &format!("v {} {} 0\n", angle.sin(), (angle * 1.3).cos());
        face += &format!(" {}", k + 1);
    }
    read_obj(&(text + &face)).unwrap();
}

// PLY -------------------------------------------------------------------------------------------------------------

#[derive(Clone, Copy, PartialEq, Debug)]
enum Encoding {
    Ascii,
    Little,
    Big,
}

const ENCODINGS: [Encoding; 3] = [Encoding::Ascii, Encoding::Little, Encoding::Big];

struct PlyWriter {
    bytes: Vec<u8>,
    encoding: Encoding,
}

impl PlyWriter {
    fn new(encoding: Encoding, header: &str) -> PlyWriter {
        let format = match encoding {
            Encoding::Ascii => "ascii",
            Encoding::Little => "binary_little_endian",
            Encoding::Big => "binary_big_endian",
        };
        let text = format!("ply\nformat {format} 1.0\ncomment by hand\n{header}end_header\n");
        PlyWriter {
            bytes: text.into_bytes(),
            encoding,
        }
    }

    fn put(&mut self, scalar: &str, value: f64) {
        if self.encoding == Encoding::Ascii {
            self.bytes.extend(format!("{value} ").bytes());
            return;
        }
        let mut word = match scalar {
            "char" | "int8" => (value as i8).to_le_bytes().to_vec(),
            "uchar" | "uint8" => (value as u8).to_le_bytes().to_vec(),
            "short" | "int16" => (value as i16).to_le_bytes().to_vec(),
            "ushort" | "uint16" => (value as u16).to_le_bytes().to_vec(),
            "int" | "int32" => (value as i32).to_le_bytes().to_vec(),
            "uint" | "uint32" => (value as u32).to_le_bytes().to_vec(),
            "float" | "float32" => (value as f32).to_le_bytes().to_vec(),
            _ => value.to_le_bytes().to_vec(),
        };
        if self.encoding == Encoding::Big {
            word.reverse();
        }
        self.bytes.extend(word);
    }

    fn end_row(&mut self) {
        if self.encoding == Encoding::Ascii {
            self.bytes.push(b'\n');
        }
    }
}

/// A file from scalar columns and faces, each followed by face columns.
fn ply_file(
    encoding: Encoding,
    vertex: &[(&str, &str)],
    rows: &[Vec<f64>],
    list: (&str, &str),
    face: &[(&str, &str)],
    faces: &[(&[u32], Vec<f64>)],
) -> Vec<u8> {
    let mut header = format!("element vertex {}\n", rows.len());
    for (scalar, name) in vertex {
        header += &format!("property {scalar} {name}\n");
    }
    header += &format!("element face {}\n", faces.len());
    header += &format!("property list {} {} vertex_indices\n", list.0, list.1);
    for (scalar, name) in face {
        header += &format!("property {scalar} {name}\n");
    }
    let mut file = PlyWriter::new(encoding, &header);
    for row in rows {
        for ((scalar, _), value) in vertex.iter().zip(row) {
            file.put(scalar, *value);
        }
        file.end_row();
    }
    for (corners, values) in faces {
        file.put(list.0, corners.len() as f64);
        for corner in *corners {
            file.put(list.1, f64::from(*corner));
        }
        for ((scalar, _), value) in face.iter().zip(values) {
            file.put(scalar, *value);
        }
        file.end_row();
    }
    file.bytes
}

const XYZ: [(&str, &str); 3] = [("float", "x"), ("float", "y"), ("float", "z")];

fn square_rows(extra: &[f64]) -> Vec<Vec<f64>> {
    [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
        .iter()
        .map(|[x, y]| [&[*x, *y, 0.0], extra].concat())
        .collect()
}

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
            ascii(&format!("{square}3 0 1 3\n")),
            ":13: a face refers to vertex 3, but there are 3",
        ),
        (
            ascii(&format!("{square}3 0 1 -1\n")),
            ":13: a face refers to vertex -1",
        ),
        (
            ascii(&format!("{square}3 0 1 1.5\n")),
            ":13: a face refers to vertex 1.5",
        ),
        (
            ascii(&format!("{square}3 0 1 nan\n")),
            "a face refers to vertex NaN",
        ),
        (
            ascii(&format!("{square}-3 0 1 2\n")),
            ":13: -3 is no length",
        ),
        (
            ascii("0 0 0\n1 0 0\nnan 1 0\n3 0 1 2\n"),
            "vertex 2 (counted from zero) is not",
        ),
        (
            ascii(&format!("{square}3 0 1 1\n")),
            "no triangle with an area",
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

// serialized ------------------------------------------------------------------------------------------------------

#[derive(Clone, Copy)]
struct Variant {
    version: u16,
    double: bool,
    flags: u32,
}

fn variants() -> Vec<Variant> {
    let mut variants = Vec::new();
    for version in [3, 4] {
        for double in [false, true] {
            for flags in [0, 1, 2, 8, 0x10, 0x1b] {
                variants.push(Variant {
                    version,
                    double,
                    flags,
                });
            }
        }
    }
    variants
}

/// What a mesh's stream decompresses to: a square of size `scale`.
fn serialized_stream(variant: Variant, scale: f64) -> Vec<u8> {
    let mut out = Vec::new();
    let precision = if variant.double { 0x2000 } else { 0x1000 };
    out.extend((variant.flags | precision).to_le_bytes());
    if variant.version == 4 {
        out.extend(b"square\xc3\xa9\0");
    }
    out.extend(4_u64.to_le_bytes());
    out.extend(2_u64.to_le_bytes());
    let mut put = |value: f64| {
        if variant.double {
            out.extend(value.to_le_bytes());
        } else {
            out.extend((value as f32).to_le_bytes());
        }
    };
    let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    for [x, y] in square {
        [x * scale, y * scale, 0.25].into_iter().for_each(&mut put);
    }
    if variant.flags & 1 != 0 {
        [0.0, 0.0, 1.0].repeat(4).into_iter().for_each(&mut put);
    }
    if variant.flags & 2 != 0 {
        square.concat().into_iter().for_each(&mut put);
    }
    if variant.flags & 8 != 0 {
        [0.5, 0.25, 0.125].repeat(4).into_iter().for_each(&mut put);
    }
    for index in [0_u32, 1, 2, 0, 2, 3] {
        out.extend(index.to_le_bytes());
    }
    out
}

fn serialized_file(version: u16, streams: &[Vec<u8>]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut offsets = Vec::new();
    for stream in streams {
        offsets.push(file.len() as u64);
        file.extend(0x041c_u16.to_le_bytes());
        file.extend(version.to_le_bytes());
        let mut encoder = ZlibEncoder::new(&mut file, Compression::default());
        encoder.write_all(stream).unwrap();
        encoder.finish().unwrap();
    }
    for offset in offsets {
        match version {
            4 => file.extend(offset.to_le_bytes()),
            _ => file.extend((offset as u32).to_le_bytes()),
        }
    }
    file.extend((streams.len() as u32).to_le_bytes());
    file
}

#[test]
fn serialized_reads_every_variant_and_index() {
    for variant in variants() {
        let streams: Vec<Vec<u8>> = (1..=3)
            .map(|scale| serialized_stream(variant, f64::from(scale)))
            .collect();
        let file = serialized_file(variant.version, &streams);
        for index in 0..3 {
            let mesh = read_serialized(&file, index).unwrap();
            let scale = (index + 1) as f32;
            assert_eq!(mesh.positions[2], [scale, scale, 0.25]);
            assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
            let has = |bit| variant.flags & bit != 0;
            assert_eq!(mesh.normals.len(), if has(1) { 4 } else { 0 });
            assert_eq!(mesh.uvs.get(2), has(2).then_some(&[1.0, 1.0]));
            assert_eq!(mesh.face_normals, has(0x10));
            let color = mesh.vertex_attributes.first().map(|a| &a.values[9..]);
            assert_eq!(color, has(8).then_some(&[0.5, 0.25, 0.125][..]));
        }
        assert!(message(read_serialized(&file, 3)).contains("the file holds 3"));
    }
}

#[test]
fn serialized_bombs_and_giant_counts_are_refused() {
    let variant = variants()[0];
    let honest = serialized_stream(variant, 1.0);
    for count in [1 << 20, u64::from(u32::MAX), u64::MAX] {
        for (position, name) in [(4, "vertices"), (12, "triangles")] {
            let mut stream = honest.clone();
            stream[position..position + 8].copy_from_slice(&count.to_le_bytes());
            let message = message(read_serialized(&serialized_file(3, &[stream]), 0));
            assert!(
                message.contains(&format!("{count} {name}"))
                    && message.contains("more than the file can hold"),
                "{message}"
            );
        }
    }
    // A name that decompresses to megabytes.
    let mut endless = honest[..4].to_vec();
    endless.resize(8 << 20, b'a');
    let message = message(read_serialized(&serialized_file(4, &[endless]), 0));
    assert!(message.contains("name does not end"), "{message}");
}

// Anything --------------------------------------------------------------------------------------------------------

/// A small valid file of each kind, and the reader for it.
type Reader = fn(&[u8]) -> Result<Mesh, MeshError>;
fn samples() -> Vec<(Vec<u8>, Reader)> {
    let mut samples: Vec<(Vec<u8>, Reader)> = Vec::new();
    let text = format!("{SQUARE}vt 0 1\nvn 0 0 1\nf 1/1/1 2//1 \\\n-2/1 4\n");
    let obj: Reader = |bytes| obj::read(bytes, true, Path::new("test.obj"));
    samples.push((text.into_bytes(), obj));
    let columns = [
        &XYZ[..],
        &[("float", "nx"), ("float", "ny"), ("float", "nz")],
        &[("uchar", "r"), ("uchar", "g"), ("uchar", "b")],
    ]
    .concat();
    let faces: [(&[u32], Vec<f64>); 2] = [(&[0, 1, 2, 3], vec![1.0]), (&[0, 1, 2], vec![2.0])];
    for encoding in ENCODINGS {
        let file = ply_file(
            encoding,
            &columns,
            &square_rows(&[0.0, 0.0, 1.0, 4.0, 5.0, 6.0]),
            ("uchar", "int"),
            &[("float", "q_0")],
            &faces,
        );
        samples.push((file, read_ply));
    }
    for version in [3, 4] {
        let variant = Variant {
            version,
            double: false,
            flags: 0x0b,
        };
        let stream = serialized_stream(variant, 1.0);
        let file = serialized_file(version, &[stream.clone(), stream]);
        samples.push((file, |bytes| read_serialized(bytes, 0)));
    }
    samples
}

#[test]
fn truncated_files_are_errors_or_smaller_meshes() {
    for (file, read) in samples() {
        read(&file).unwrap();
        for length in 0..file.len() {
            // Text may end early without a trace; what is returned must still be consistent.
            if let Ok(mesh) = read(&file[..length]) {
                assert_consistent(&mesh);
            }
        }
    }
}

fn assert_consistent(mesh: &Mesh) {
    let count = mesh.positions.len();
    assert!(!mesh.triangles.is_empty());
    assert!(mesh.positions.as_flattened().iter().all(|x| x.is_finite()));
    assert!(
        mesh.triangles
            .as_flattened()
            .iter()
            .all(|&i| (i as usize) < count)
    );
    assert!(mesh.normals.is_empty() || mesh.normals.len() == count);
    for n in &mesh.normals {
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        assert!((length - 1.0).abs() < 1e-5, "{n:?}");
    }
    assert!(mesh.uvs.is_empty() || mesh.uvs.len() == count);
    for (attributes, rows) in [
        (&mesh.vertex_attributes, count),
        (&mesh.face_attributes, mesh.triangles.len()),
    ] {
        for attribute in attributes {
            assert_eq!(attribute.values.len(), rows * attribute.channels as usize);
            assert!(attribute.values.iter().all(|v| v.is_finite()));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn damaged_files_are_errors_or_consistent_meshes(
        which in 0_usize..6,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of((any::<prop::sample::Index>(), 0_usize..20)),
    ) {
        let (mut file, read) = samples().swap_remove(which);
        for (at, byte) in flips {
            let at = at.index(file.len());
            file[at] = byte;
        }
        if let Some((at, length)) = cut {
            let at = at.index(file.len());
            file.drain(at..(at + length).min(file.len()));
        }
        if let Ok(mesh) = read(&file) {
            assert_consistent(&mesh);
        }
    }

    /// The zlib checksum stops most damage; this damages what is inside.
    #[test]
    fn damaged_serialized_streams_are_errors_or_consistent_meshes(
        which in 0_usize..24,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        length in any::<prop::sample::Index>(),
    ) {
        let variant = variants()[which];
        let mut stream = serialized_stream(variant, 1.0);
        for (at, byte) in flips {
            let at = at.index(stream.len());
            stream[at] = byte;
        }
        let length = length.index(2 * stream.len());
        stream.truncate(length);
        if let Ok(mesh) = read_serialized(&serialized_file(variant.version, &[stream]), 0) {
            assert_consistent(&mesh);
        }
    }
}

// Meshes ----------------------------------------------------------------------------------------------------------

#[test]
fn degenerate_triangles_go_with_their_attributes() {
    let mut mesh = Mesh {
        positions: vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
        ],
        triangles: vec![[0, 1, 2], [0, 1, 3], [1, 1, 3], [1, 2, 3]],
        face_attributes: vec![Attribute {
            name: "face_id".into(),
            channels: 1,
            values: vec![0.0, 1.0, 2.0, 3.0],
        }],
        ..Mesh::default()
    };
    mesh.validate(Path::new("test")).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 3], [1, 2, 3]]);
    assert_eq!(mesh.face_attributes[0].values, [1.0, 3.0]);
}

#[test]
fn unusable_normals_are_replaced_by_those_of_the_faces() {
    let text =
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 1 1\nvn 0 0 0\nvn nan 0 1\nf 1//1 2//2 3//3 4\n";
    let mesh = read_obj(text).unwrap();
    let h = 0.5_f32.sqrt();
    assert_eq!(mesh.normals[0], [0.0, h, h]);
    assert_eq!(mesh.normals[1..], [[0.0, 0.0, 1.0]; 3]);
}

/// Against Mitsuba 3.9 (`scalar_rgb`) on the same file.
#[test]
fn vertex_normals_are_weighted_by_angle() {
    let mut mesh = read_obj("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.3\nf 1 2 3 4\n").unwrap();
    assert!(mesh.normals.is_empty());
    mesh.compute_vertex_normals();
    let expected = [
        [
            0.14452329277992249,
            -0.14452329277992249,
            0.9788902401924133,
        ],
        [0.0, 0.0, 0.9999999403953552],
        [
            0.14452329277992249,
            -0.14452329277992249,
            0.9788902401924133,
        ],
        [0.276172399520874, -0.276172399520874, 0.9205746650695801],
    ];
    for (ours, theirs) in mesh.normals.iter().zip(expected) {
        for k in 0..3 {
            assert!((ours[k] - theirs[k]).abs() < 3e-7, "{ours:?} {theirs:?}");
        }
    }
}

#[test]
fn missing_files_and_directories_are_errors() {
    let directory = tempfile::tempdir().unwrap();
    let missing = directory.path().join("missing.obj");
    for path in [missing.as_path(), directory.path()] {
        for error in [
            obj::load(path, true).unwrap_err(),
            ply::load(path, true).unwrap_err(),
            serialized::load(path, 0).unwrap_err(),
        ] {
            assert!(matches!(error, MeshError::Io { .. }));
            assert!(error.to_string().contains(&path.display().to_string()));
        }
    }
}
