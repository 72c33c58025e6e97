//! What is checked and repaired in every mesh, and vertex normals.

use crate::read_obj;
use halflight::mesh::{Attribute, Mesh, MeshError, obj, ply, serialized};
use std::path::Path;

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
