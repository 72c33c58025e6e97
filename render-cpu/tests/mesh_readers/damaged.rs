//! Truncated and damaged files of every format.

use crate::ply_writer::{ENCODINGS, XYZ, ply_file, square_rows};
use crate::serialized_files::{Variant, serialized_file, serialized_stream, variants};
use crate::{SQUARE, read_ply, read_serialized};
use halflight::mesh::{Mesh, MeshError, obj};
use proptest::prelude::*;
use std::path::Path;

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
