//! Mitsuba's `.serialized`.

use crate::{message, read_serialized};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use std::io::Write;

#[derive(Clone, Copy)]
pub(crate) struct Variant {
    pub(crate) version: u16,
    pub(crate) double: bool,
    pub(crate) flags: u32,
}

pub(crate) fn variants() -> Vec<Variant> {
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
pub(crate) fn serialized_stream(variant: Variant, scale: f64) -> Vec<u8> {
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

pub(crate) fn serialized_file(version: u16, streams: &[Vec<u8>]) -> Vec<u8> {
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
