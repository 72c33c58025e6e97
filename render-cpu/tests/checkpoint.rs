//! Checkpoints continue bit for bit, and nothing but a whole checkpoint of the same run is taken.

use glam::Vec3;
use halflight::film::Film;
use halflight::film::aov::{Aov, AovSample, AovSet};
use halflight::film::checkpoint::{
    CheckpointError, Progress, Settings, load_checkpoint, read_checkpoint, save_checkpoint,
    write_checkpoint,
};
use proptest::prelude::*;
use std::path::Path;

fn settings() -> Settings {
    [("scene", "room.xml"), ("seed", "1"), ("size", "6x5")]
        .map(|(k, v)| (k.to_owned(), v.to_owned()))
        .into()
}

fn progress() -> Progress {
    Progress {
        settings: settings(),
        passes: 3,
        next_sample: 12,
        render_seconds: 1.25,
    }
}

fn sample(film: &mut Film, samples: std::ops::Range<u32>) {
    for y in 0..film.height() {
        for x in 0..film.width() {
            for i in samples.clone() {
                let v = (x * 31 + y * 17 + i * 7) as f32 / 13.0;
                let mut pixel = film.pixel_mut(x, y);
                pixel.add_sample(Vec3::new(
                    v.sin(),
                    v,
                    if i == 1 { f32::NAN } else { 1.0 / (v + 1.0) },
                ));
                pixel.add_aovs(&AovSample {
                    albedo: [v, 0.1, 0.7],
                    depth: v.sqrt(),
                    ..AovSample::default()
                });
            }
        }
    }
}

fn film() -> Film {
    let aovs: AovSet = [Aov::Albedo, Aov::Depth, Aov::Variance]
        .into_iter()
        .collect();
    Film::new(6, 5, [3, 4], aovs).unwrap()
}

fn bytes(film: &Film) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_checkpoint(&mut bytes, &progress(), film).unwrap();
    bytes
}

fn read(bytes: &[u8]) -> Result<(Progress, Film), CheckpointError> {
    read_checkpoint(
        &mut &bytes[..],
        bytes.len() as u64,
        Path::new("test.checkpoint"),
    )
}

/// Every bit of a film.
fn bits(film: &Film) -> Vec<u64> {
    let pixels = film.statistics().iter().flat_map(|p| {
        let numbers = p
            .mean
            .into_iter()
            .chain(p.m2)
            .chain([p.luminance_m2])
            .map(f64::to_bits);
        [u64::from(p.count), u64::from(p.rejected)]
            .into_iter()
            .chain(numbers)
    });
    pixels
        .chain(film.aov_sums().iter().map(|v| v.to_bits()))
        .collect()
}

#[test]
fn a_resumed_run_is_bit_identical() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.checkpoint");
    let mut whole = film();
    sample(&mut whole, 0..20);

    let mut first = film();
    sample(&mut first, 0..12);
    save_checkpoint(&path, &progress(), &first).unwrap();
    drop(first);
    let (loaded, mut resumed) = load_checkpoint(&path, &settings()).unwrap();
    assert_eq!(loaded, progress());
    sample(&mut resumed, loaded.next_sample..20);
    assert_eq!(bits(&resumed), bits(&whole));
    assert_eq!(
        (resumed.crop_offset(), resumed.aovs()),
        (whole.crop_offset(), whole.aovs())
    );
}

#[test]
fn a_checkpoint_that_ends_early_is_an_error_at_every_byte() {
    let mut film = film();
    sample(&mut film, 0..3);
    let bytes = bytes(&film);
    assert!(read(&bytes).is_ok());
    for end in 0..bytes.len() {
        let error = read(&bytes[..end]).unwrap_err().to_string();
        assert!(error.contains("test.checkpoint"), "{error}");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(read(&longer).is_err());
}

#[test]
fn a_changed_byte_is_an_error_wherever_it_is() {
    let mut film = film();
    sample(&mut film, 0..3);
    let mut bytes = bytes(&film);
    for i in 0..bytes.len() {
        bytes[i] ^= 0x10;
        assert!(read(&bytes).is_err(), "byte {i}");
        bytes[i] ^= 0x10;
    }
}

#[test]
fn other_settings_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.checkpoint");
    save_checkpoint(&path, &progress(), &film()).unwrap();
    let mut other = settings();
    other.insert("seed".into(), "2".into());
    other.insert("sampler".into(), "sobol".into());
    other.remove("size");
    let error = load_checkpoint(&path, &other).unwrap_err().to_string();
    assert!(error.contains("seed is 1 there and 2 here"), "{error}");
    assert!(
        error.contains("sampler is not set there and sobol here"),
        "{error}"
    );
    assert!(
        error.contains("size is 6x5 there and not set here"),
        "{error}"
    );
    assert!(!error.contains("scene"), "{error}");
}

/// A checkpoint with a header of one's own choice and a valid checksum.
fn forged(header: &str, body: &[u8]) -> Vec<u8> {
    let mut bytes = b"HLFILM\r\n".to_vec();
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend((header.len() as u32).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(body);
    let mut checksum = flate2::Crc::new();
    checksum.update(&bytes);
    bytes.extend(checksum.sum().to_le_bytes());
    bytes
}

fn header(width: u32, height: u32) -> String {
    let progress = r#"{"settings":{},"passes":0,"next_sample":0,"render_seconds":0}"#;
    format!(
        r#"{{"progress":{progress},"width":{width},"height":{height},"crop_offset":[0,0],"aovs":[]}}"#
    )
}

#[test]
fn hostile_headers_are_errors_and_allocate_nothing() {
    assert!(
        read(&forged(&header(1, 1), &[0; 64])).is_ok(),
        "the forgery is a checkpoint"
    );
    // 2^64 bytes and what overflows to a small number of them.
    for (width, height) in [
        (u32::MAX, u32::MAX),
        (1 << 29, 1 << 29),
        (1 << 31, 1 << 27),
        (0, 7),
        (0, 0),
        (2, 1),
    ] {
        let error = read(&forged(&header(width, height), &[0; 64])).unwrap_err();
        assert!(!matches!(error, CheckpointError::Io { .. }), "{error}");
    }
    // No pixels at all, and a length that agrees.
    assert!(matches!(
        read(&forged(&header(0, 0), &[])),
        Err(CheckpointError::Film { .. })
    ));
    let mut not_a_number = [0; 64];
    not_a_number[8..16].copy_from_slice(&f64::NAN.to_le_bytes());
    assert!(
        read(&forged(&header(1, 1), &not_a_number))
            .unwrap_err()
            .to_string()
            .contains("no samples have")
    );
    for text in [
        "",
        "{}",
        "[1",
        "\u{0}",
        &header(1, 1).replace("\"aovs\":[]", "\"aovs\":[\"x\"]"),
    ] {
        assert!(read(&forged(text, &[0; 64])).is_err());
    }
    let mut future = bytes(&film());
    future[8] = 9;
    assert!(read(&future).unwrap_err().to_string().contains("layout 9"));
    assert!(
        read(b"#?RADIANCE\nnot ours")
            .unwrap_err()
            .to_string()
            .contains("no checkpoint")
    );
    assert!(matches!(
        load_checkpoint(Path::new("does/not/exist"), &settings()),
        Err(CheckpointError::Io { .. })
    ));
}

proptest! {
    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), valid_start in any::<bool>()) {
        let bytes = if valid_start { forged(&header(1, 2), &bytes) } else { bytes };
        let _ = read(&bytes);
    }
}
