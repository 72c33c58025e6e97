//! Wavefront OBJ.

use crate::{SQUARE, area, message, read_obj};
use halflight::mesh::{Attribute, obj};
use std::path::Path;

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
    let mut mesh = read_obj(text).unwrap();
    assert_eq!(mesh.materials.names, ["", "a  b"]);
    mesh.materials = reference.materials.clone();
    assert_eq!(mesh, reference);
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
        ("v 0 \\\n 0 0\nvn 1 2\n", 3, "three numbers"),
        ("v 0 0 0\nf 1 /1 1\n", 2, "not an index"),
        ("v 0 0 0\nf 1 1/1/1/1 1\n", 2, "too many indices"),
        ("v 0 0 0\nf 1x 1 1\n", 2, "not an index of a corner"),
        ("v 0 0 0\nf 1 1.5 1\n", 2, "not an index"),
    ] {
        let message = message(read_obj(text));
        assert!(
            message.starts_with(&format!("test.obj:{line}: ")),
            "{text:?}: {message}"
        );
        assert!(message.contains(what), "{text:?}: {message}");
    }
    assert!(message(read_obj("")).contains("no vertex and no face"));
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

#[test]
fn one_bad_face_or_vertex_does_not_cost_the_others() {
    let good = read_obj(&format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    for bad in [
        "f 1 2 9",
        "f 1 0 2",
        "f 1 -5 2",
        "f -9223372036854775808 1 2",
        "f 1 2 9 3 4",
    ] {
        let mesh = read_obj(&format!("{SQUARE}{bad}\nf 1 2 3 4\n")).unwrap();
        assert_eq!(
            (&mesh.triangles, &mesh.positions),
            (&good.triangles, &good.positions),
            "{bad}"
        );
        assert_eq!(mesh.warnings.len(), 1, "{bad}: {:?}", mesh.warnings);
        assert!(
            mesh.warnings[0].contains("1 faces name vertices"),
            "{:?}",
            mesh.warnings
        );
    }
    // A vertex that is no point costs the faces that have it.
    for point in ["v 0 0 nan", "v 1e999 0 0", "v 0 1e30 0"] {
        let mesh = read_obj(&format!("{SQUARE}{point}\nf 1 2 3 4\n")).unwrap();
        assert_eq!(mesh.triangles, good.triangles);
        let mesh = read_obj(&format!("{SQUARE}{point}\nf 1 2 3 4\nf 1 2 5\n")).unwrap();
        assert_eq!(mesh.triangles, good.triangles);
        assert_eq!(mesh.warnings.len(), 2, "{:?}", mesh.warnings);
        assert!(mesh.positions.as_flattened().iter().all(|x| x.is_finite()));
    }
    // Indices as other programs write them.
    let odd = read_obj(&format!(
        "{SQUARE}vt 0 0\nvn 0 0 1\nf 1/1/1/ 2.0/1/1 3/1.0/1 4/1/1\n"
    ))
    .unwrap();
    assert_eq!(odd.triangles, good.triangles);
    assert!(odd.warnings.is_empty(), "{:?}", odd.warnings);
}

#[test]
fn colours_stand_behind_a_weight_or_are_bytes() {
    let colors = |text: &str| {
        let mesh = read_obj(&format!("{text}f 1 2 3\n")).unwrap();
        (
            mesh.vertex_attributes[0].values[..3].to_vec(),
            mesh.warnings,
        )
    };
    let vertices = |color: &str| format!("v 0 0 0 {color}\nv 1 0 0 {color}\nv 0 1 0 {color}\n");
    for color in ["0.5 0.25 1", "1.0 0.5 0.25 1", "7 0.5 0.25 1"] {
        assert_eq!(
            colors(&vertices(color)),
            (vec![0.5, 0.25, 1.0], vec![]),
            "{color}"
        );
    }
    let (bytes, said) = colors(&vertices("255 51 0"));
    assert_eq!(bytes, [1.0, 0.2, 0.0]);
    assert!(
        said.len() == 1 && said[0].contains("taken for bytes"),
        "{said:?}"
    );
}
