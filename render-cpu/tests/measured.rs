//! The reader of MERL files on small synthetic files, and the plugin that names one.

use halflight::measured::merl::{MAX_CELLS_PER_AXIS, Merl, MerlError};
use halflight::measured::synthetic::nickel;
use halflight::scene::build::{BuildOptions, build_scene};
use halflight::scene::xml::parse_scene_from_str;
use halflight_kernel::bsdf::local_roughness::lobe_falloff;
use halflight_kernel::bsdf::merl::lookup;
use halflight_kernel::bsdf::{Lobe, lobe};
use halflight_kernel::scene::lobe_kind;
use std::f32::consts::{FRAC_PI_2, PI};
use std::path::Path;

const CELLS: [i32; 3] = [4, 3, 6];
const COUNT: usize = 72;

/// A file whose value in channel `c` of cell `i` is `value(c, i)`.
fn file(cells: [i32; 3], count: usize, value: impl Fn(usize, usize) -> f64) -> Vec<u8> {
    let mut bytes: Vec<u8> = cells.iter().flat_map(|n| n.to_le_bytes()).collect();
    for c in 0..3 {
        for i in 0..count {
            bytes.extend(value(c, i).to_le_bytes());
        }
    }
    bytes
}

#[test]
fn planes_are_scaled_and_put_in_order() {
    let bytes = file(CELLS, COUNT, |c, i| (1 + c * 1000 + i) as f64);
    let measured = Merl::read(&bytes).unwrap();
    assert_eq!((measured.cells, measured.invalid), ([4, 3, 6], 0));
    // The format's index: phi_d + n_p (theta_d + n_d theta_h).
    let (h, d, p) = (2, 1, 5);
    let i = p + 6 * (d + 3 * h);
    let expected = [
        (1 + i) as f32 / 1500.0,
        (1001 + i) as f32 * 1.15 / 1500.0,
        (2001 + i) as f32 * 1.66 / 1500.0,
    ];
    // theta_h = (x / n)^2 pi / 2, the others uniform.
    let angles = glam::Vec3::new(
        (2.5_f32 / 4.0).powi(2) * FRAC_PI_2,
        1.5 / 3.0 * FRAC_PI_2,
        5.5 / 6.0 * PI,
    );
    let found = lookup(&measured.table(), 0, angles);
    for c in 0..3 {
        assert!((measured.values[i][c] - expected[c]).abs() < 1e-6);
        assert!((found[c] - expected[c]).abs() < 1e-5, "{found}");
    }
}

#[test]
fn negative_values_are_unmeasured() {
    let bytes = file(
        CELLS,
        COUNT,
        |c, i| if i == 7 && c == 1 { -1.0 } else { 3.0 },
    );
    let measured = Merl::read(&bytes).unwrap();
    assert_eq!(measured.invalid, 1);
    assert_eq!(measured.values[7][1], 0.0);
    assert!(measured.values[7][0] > 0.0);
}

#[test]
fn wrong_files_are_refused() {
    let good = file(CELLS, COUNT, |_, _| 1.0);
    assert_eq!(Merl::read(&good[..11]), Err(MerlError::NoHeader(11)));
    for wrong in [&good[..good.len() - 1], &[&good[..], &[0]].concat()] {
        let expected = MerlError::Length {
            found: wrong.len(),
            expected: 12 + 24 * COUNT,
        };
        assert_eq!(Merl::read(wrong), Err(expected));
    }
    let too_long = MAX_CELLS_PER_AXIS as i32 + 1;
    for cells in [
        [0, 3, 6],
        [-4, 3, -6],
        [too_long, 1, 1],
        [300, 300, 300],
        [i32::MAX; 3],
    ] {
        let bytes = file(cells, COUNT, |_, _| 1.0);
        let error = Merl::read(&bytes);
        assert_eq!(
            error,
            Err(MerlError::Dimensions(cells[0], cells[1], cells[2]))
        );
    }
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let bytes = file(
            CELLS,
            COUNT,
            |c, i| if c == 2 && i == 5 { bad } else { 1.0 },
        );
        let place = 12 + 8 * (2 * COUNT + 5);
        assert_eq!(Merl::read(&bytes), Err(MerlError::Value(place)));
    }
}

#[test]
fn synthetic_nickel_reflects_like_a_metal() {
    let bytes = nickel();
    assert_eq!(bytes.len(), 34_992_012);
    let measured = Merl::read(&bytes).unwrap();
    // Cells of the format that no pair of directions above the surface has.
    assert!(measured.invalid > measured.values.len() / 10);
    let table = measured.table();
    let mut lobe = Lobe::NONE;
    (lobe.kind, lobe.table) = (lobe_kind::MERL, 0);
    let albedo = lobe::albedo(&lobe, &table, glam::Vec3::Z);
    // Nickel reflects 0.68, 0.58 and 0.49 at normal incidence; masking takes a little.
    assert!(albedo.x > albedo.y && albedo.y > albedo.z, "{albedo}");
    assert!(albedo.x < 0.75 && albedo.z > 0.4, "{albedo}");
    // The local roughness grows from the narrow lobe's to the wide one's and beyond.
    let roughness = |degrees: f32| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let out = glam::Vec3::new(sin, 0.0, cos);
        1.0 / lobe_falloff(&lobe, &table, glam::Vec3::Z, out).sqrt()
    };
    let found = [4.0, 20.0, 60.0, 85.0].map(roughness);
    assert!(found.windows(2).all(|w| w[0] < w[1]), "{found:?}");
    assert!(found[0] < 0.12 && found[2] > 0.3, "{found:?}");
}

#[test]
fn plugin_reads_the_file() {
    let directory = tempfile::tempdir().unwrap();
    let scene = directory.path().join("scene.xml");
    let text = "<scene version=\"3.0.0\"><sensor type=\"perspective\"/><shape type=\"sphere\">
        <bsdf type=\"merl\"><string name=\"filename\" value=\"a.binary\"/></bsdf></shape></scene>";
    let build = |strict: bool| {
        let parsed = parse_scene_from_str(text, &scene, &[], strict)?;
        build_scene(&parsed, &BuildOptions::default())
    };
    assert!(build(false).unwrap_err().to_string().contains("a.binary"));
    let path = directory.path().join("a.binary");
    std::fs::write(&path, file(CELLS, COUNT, |_, _| 150.0)).unwrap();
    let built = build(false).unwrap();
    let lobe = built.tables.lobes[0];
    assert_eq!(lobe.kind, lobe_kind::MERL);
    let value = lookup(&built.tables.data, lobe.table, glam::Vec3::splat(0.3));
    assert!((value.x - 0.1).abs() < 1e-6);
    // Not the numbers of cells of the database.
    assert!(built.warnings.iter().any(|w| w.to_string().contains("90")));
    assert!(build(true).is_err());
    std::fs::write(&path, b"short").unwrap();
    let message = build(false).unwrap_err().to_string();
    assert!(message.contains("too short"), "{message}");
    assert!(Path::new(&path).exists());
}
