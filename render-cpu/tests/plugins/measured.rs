//! `measured`: files of the RGL database, on small ones that are made here.

use crate::{bsdf, try_build_in};
use glam::Vec3;
use halflight::measured::rgl::Rgl;
use halflight::measured::synthetic::{brushed, brushed_metal};
use halflight::measured::tensor_file::{Field, file_of, read};
use halflight_kernel::bsdf::{Lobe, lobe};
use halflight_kernel::scene::{lobe_flag, lobe_kind};

fn direction(theta: f32, phi: f32) -> Vec3 {
    let (s, c) = theta.to_radians().sin_cos();
    let (sin, cos) = phi.to_radians().sin_cos();
    Vec3::new(s * cos, s * sin, c)
}

#[test]
fn a_file_of_brushed_metal_scatters_as_it() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(
        folder.path().join("brushed.bsdf"),
        brushed().expect("a file"),
    )
    .expect("written");
    let scene = try_build_in(
        folder.path(),
        "3.0.0",
        r#"<sensor type="perspective"/><emitter type="constant"/><shape type="sphere"><bsdf type="measured">
        <string name="filename" value="brushed.bsdf"/></bsdf></shape>"#,
    )
    .unwrap_or_else(|e| panic!("{e}"));
    let tables = scene.tables.view();
    let metal = Lobe {
        flags: lobe_flag::FRONT,
        ..brushed_metal()
    };
    let mut compared = 0;
    for (theta, phi) in [(5.0, 10.0), (30.0, 100.0), (50.0, 200.0), (60.0, 300.0)] {
        let wi = direction(theta, phi);
        let measured = bsdf(&tables, wi);
        for tilt in [0.0, 5.0, 10.0, 20.0] {
            for turn in [0.0, 70.0, 190.0, 260.0] {
                let m = direction(tilt, turn);
                let wo = m * (2.0 * wi.dot(m)) - wi;
                if wo.z < 0.2 {
                    continue;
                }
                let f = measured.eval_cosine(tables.data, wi, wo);
                let expected = lobe::eval_cosine(&metal, &[], wi, wo);
                // Bilinear interpolation on 48 values across the peak.
                let error = (f - expected).abs() / expected.max_element().max(0.05);
                assert!(error.max_element() < 0.08, "{wi} {wo}: {f}, not {expected}");
                compared += 1;
            }
        }
    }
    assert!(compared > 40, "{compared}");
}

/// A file of one elevation more than it needs, of the smallest grids, with the fields of `change`.
fn small(change: impl FnOnce(&mut Vec<(&'static str, Vec<usize>, Vec<f32>)>)) -> Vec<u8> {
    let mut fields = vec![
        ("phi_i", vec![1], vec![0.0]),
        ("theta_i", vec![2], vec![0.0, 1.2]),
        ("ndf", vec![2, 2], vec![1.0; 4]),
        ("sigma", vec![2, 2], vec![0.5; 4]),
        (
            "vndf",
            vec![1, 2, 2, 2],
            vec![0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0],
        ),
        ("luminance", vec![1, 2, 2, 2], vec![1.0; 8]),
        ("rgb", vec![1, 2, 3, 2, 2], vec![0.25; 24]),
    ];
    change(&mut fields);
    let floats: Vec<(&str, &[usize], &[f32])> = fields
        .iter()
        .map(|(name, shape, values)| (*name, &shape[..], &values[..]))
        .collect();
    file_of(&floats, &[("jacobian", &[0]), ("description", b"small")])
}

#[test]
fn spectra_become_the_colours_that_they_are() {
    // White, and a band of red, over four wavelengths.
    let value = |l: f32| if l > 600.0 { 0.25 } else { 0.05 };
    let lengths = [360.0, 500.0, 620.0, 830.0];
    let of = |spectrum: &dyn Fn(f32) -> f32| {
        small(|fields| {
            fields.pop();
            let values = (0..2).flat_map(|_| lengths.iter().flat_map(|l| [spectrum(*l); 4]));
            fields.push(("spectra", vec![1, 2, 4, 2, 2], values.collect()));
            fields.push(("wavelengths", vec![4], lengths.to_vec()));
        })
    };
    let lobe = Lobe {
        kind: lobe_kind::MEASURED,
        table: 0,
        ..Lobe::NONE
    };
    let (wi, wo) = (direction(20.0, 0.0), direction(30.0, 140.0));
    let f = |bytes: &[u8]| {
        let table = Rgl::read(bytes).unwrap_or_else(|e| panic!("{e}")).table();
        lobe::eval_cosine(&lobe, &table, wi, wo)
    };
    let plain = f(&small(|_| ()));
    assert!((plain - 0.25).abs().max_element() < 1e-5, "{plain}");
    let white = f(&of(&|_| 0.25));
    assert!((white - 0.25).abs().max_element() < 1e-3, "{white}");
    let red = f(&of(&value));
    assert!(red.x > 2.0 * red.y && red.y > 2.0 * red.z, "{red}");
}

#[test]
fn damaged_files_are_refused_with_what_is_wrong() {
    let whole = small(|_| ());
    assert!(Rgl::read(&whole).is_ok());
    for length in 0..whole.len() {
        assert!(Rgl::read(&whole[..length]).is_err(), "{length} bytes");
    }
    // Every byte of the head changed: an error or a measurement, never a panic.
    let head = whole.len() - 500;
    for at in 0..head {
        for flip in [1, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            if let Ok(read) = Rgl::read(&bytes) {
                assert!(read.table().iter().all(|v| v.is_finite()));
            }
        }
    }
    let message = |bytes: &[u8]| match Rgl::read(bytes) {
        Ok(_) => panic!("it is read"),
        Err(error) => error.to_string(),
    };
    let without = |name: &'static str| small(|f| f.retain(|field| field.0 != name));
    assert_eq!(message(&without("ndf")), "there is no field \"ndf\"");
    assert!(message(&without("rgb")).contains("spectra"));
    let wrong = small(|f| f[6].1 = vec![1, 2, 2, 2, 3]);
    assert!(message(&wrong).contains("1 x 2 x 2 x 2 x 3 values, not 1 x 2 x 3 x 2 x 2"));
    let falling = small(|f| f[1].2 = vec![1.0, 0.5]);
    assert!(message(&falling).contains("ascending"));
    let endless = small(|f| f[2].2[1] = f32::INFINITY);
    assert!(message(&endless).contains("not finite"));
    assert!(message(b"tensor_file").contains("no tensor file"));
    let names: Vec<String> = read(&whole)
        .expect("fields")
        .into_iter()
        .map(|Field { name, .. }| name)
        .collect();
    assert_eq!(names.len(), 9);
    assert_eq!((&names[0][..], &names[8][..]), ("phi_i", "description"));
}
