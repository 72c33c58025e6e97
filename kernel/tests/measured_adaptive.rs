//! Adaptively measured reflectance: a table made of formulas against Mitsuba 3 on the same numbers, its sampler, its albedo.

mod common;

use common::chi_square::ChiSquare;
use common::lobes::white;
use common::{Random, direction_at, furnace};
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::measured_table::{Measurement, Plane, fill_table, table_words};
use halflight_kernel::bsdf::{Lobe, event, lobe};
use halflight_kernel::scene::lobe_kind;
use std::f32::consts::{PI, TAU};

/// A lobe with the table that it reads.
struct Material {
    name: &'static str,
    lobe: Lobe,
    data: Vec<f32>,
}

const ELEVATIONS: [f32; 4] = [0.0, 0.4, 0.9, 1.4];

/// The numbers of oracle/measured.py.
fn material(name: &'static str, azimuths: &[f32], symmetry: u32, is_relative: bool) -> Material {
    let nodes = |width: usize, height: usize| {
        (0..width * height).map(move |i| {
            let (x, y) = (i % width, i / width);
            (
                x as f32 / (width - 1) as f32,
                y as f32 / (height - 1) as f32,
            )
        })
    };
    let normals: Vec<f32> = nodes(7, 5)
        .map(|(x, y)| (-6.0 * x * x).exp() * (1.0 + 0.3 * (TAU * y).cos()) + 0.1)
        .collect();
    let areas: Vec<f32> = nodes(6, 4)
        .map(|(x, y)| 0.3 + 0.4 * (1.0 - x * x) + 0.05 * (TAU * y).cos())
        .collect();
    let (mut visible, mut luminance, mut colors) = (vec![], vec![], vec![]);
    for &phi in azimuths {
        for theta in ELEVATIONS {
            let sin = theta.sin();
            visible.extend(nodes(9, 8).map(|(x, y)| {
                let d = x - 0.3 * sin;
                x * (0.2 + (-8.0 * d * d).exp() * (1.0 + 0.5 * (TAU * y - phi).cos()))
            }));
            let value = |x: f32, y: f32| 0.3 + 0.5 * x * (1.0 - y) + 0.2 * sin + 0.05 * phi.cos();
            luminance.extend(nodes(6, 6).map(|(x, y)| value(x, y)));
            for (scale, slope) in [(0.3, 0.02), (0.2, 0.0), (0.1, 0.05)] {
                colors.extend(nodes(6, 6).map(|(x, y)| scale * value(x, y) + slope * y));
            }
        }
    }
    let plane = |values, width, height| Plane {
        values,
        width,
        height,
    };
    let measurement = Measurement {
        azimuths,
        elevations: &ELEVATIONS,
        is_isotropic: azimuths.len() <= 2,
        symmetry,
        is_relative,
        normals: plane(&normals, 7, 5),
        areas: plane(&areas, 6, 4),
        visible: plane(&visible, 9, 8),
        luminance: plane(&luminance, 6, 6),
        colors: &colors,
    };
    let mut data = vec![0.0; table_words(&measurement)];
    fill_table(&measurement, &mut data);
    let mut lobe = white(lobe_kind::MEASURED);
    lobe.table = 0;
    Material { name, lobe, data }
}

fn materials() -> Vec<Material> {
    vec![
        material("isotropic", &[0.0], 1, true),
        material("half", &[-PI, -2.0, -1.0, 0.0], 2, true),
        material("quarter", &[-PI, -2.4, -PI / 2.0], 4, false),
        material("whole", &[-PI, -1.0, 1.0, PI], 1, true),
    ]
}

#[test]
fn values_and_densities_are_those_of_mitsuba() {
    let oracle = include_str!("oracle/mitsuba/measured.csv");
    let materials = materials();
    let mut compared = 0;
    for line in oracle.lines().skip(2) {
        let v: Vec<f32> = line.split(',').map(|x| x.parse().expect(x)).collect();
        let Material { name, lobe, data } = &materials[v[0] as usize];
        let (wi, wo) = (Vec3::from_slice(&v[1..4]), Vec3::from_slice(&v[4..7]));
        let f = lobe::eval_cosine(lobe, data, wi, wo);
        let p = lobe::pdf(lobe, data, wi, wo);
        for (value, expected) in [(f.x, v[7]), (f.y, v[8]), (f.z, v[9]), (p, v[10])] {
            let error = (value - expected).abs() / expected.max(1e-3);
            assert!(error < 2e-3, "{name} {wi} {wo}: {f} {p}, not {:?}", &v[7..]);
        }
        compared += 1;
    }
    assert!(compared >= 200, "{compared}");
}

#[test]
fn samples_follow_their_density() {
    let materials = materials();
    let incidences = [
        direction_at(0.5, 0.0),
        direction_at(50.0, 25.0),
        direction_at(80.0, 110.0),
        direction_at(30.0, 250.0),
    ];
    let mut failures = Vec::new();
    for material in &materials {
        for wi in incidences {
            let (lobe, data) = (&material.lobe, &material.data);
            let test = ChiSquare {
                samples: 200_000,
                pole: Vec3::new(-wi.x, -wi.y, wi.z),
                family: (materials.len() * incidences.len()) as u32,
                seed: 5,
            };
            let result = test.run(
                |random| {
                    let u1 = random.next_1d();
                    let s = lobe::sample(lobe, data, wi, u1, random.next_2d());
                    (s.pdf > 0.0).then_some(s.wo)
                },
                |wo| lobe::pdf(lobe, data, wi, wo),
            );
            if let Err(reason) = result {
                failures.push(format!("{}, wi {wi}: {reason}", material.name));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn weights_are_values_over_densities_and_the_stated_albedo_their_mean() {
    for Material { name, lobe, data } in &materials() {
        let mut random = Random(3);
        for wi in [direction_at(20.0, 10.0), direction_at(70.0, 200.0)] {
            for _ in 0..2_000 {
                let u1 = random.next_1d();
                let s = lobe::sample(lobe, data, wi, u1, random.next_2d());
                assert!(s.weight.is_finite() && s.pdf.is_finite() && s.pdf >= 0.0);
                if s.pdf > 0.0 {
                    let (f, p) = lobe::eval_cosine_pdf(lobe, data, wi, s.wo);
                    assert!((p / s.pdf - 1.0).abs() < 1e-4, "{name}: {p} {}", s.pdf);
                    let error = (f / s.pdf - s.weight).abs().max_element();
                    assert!(error <= 1e-4 * s.weight.max_element(), "{name}: {f}");
                    assert_eq!(s.event, event::REFLECTION | event::GLOSSY);
                }
            }
        }
        // An isotropic one looks alike from all azimuths.
        if *name == "isotropic" {
            let wi = direction_at(42.0, 10.0);
            let (albedo, error) = furnace::albedo(lobe, data, wi, 40_000, 7);
            let stated = lobe::albedo(lobe, data, wi);
            let limit = 0.03 * albedo + 5.0 * error;
            assert!(
                (stated - albedo).abs().cmplt(limit).all(),
                "{stated}, not {albedo}"
            );
        }
        // Nothing is reflected from below, and nothing is infinite.
        for _ in 0..2_000 {
            let (wi, wo) = (random.direction(), random.direction());
            let (f, p) = lobe::eval_cosine_pdf(lobe, data, wi, wo);
            assert!(f.is_finite() && p.is_finite() && f.min_element() >= 0.0 && p >= 0.0);
            assert!(wi.z > 0.0 && wo.z > 0.0 || p == 0.0);
            let s = lobe::sample(
                lobe,
                data,
                wi,
                0.5,
                Vec2::new(random.next_1d(), 1.0 - f32::EPSILON),
            );
            assert!(s.pdf.is_finite() && s.weight.is_finite());
        }
        for wi in [Vec3::Z, Vec3::X, Vec3::new(1.0, 0.0, 1e-7)] {
            let s = lobe::sample(lobe, data, wi.normalize(), 0.5, Vec2::ZERO);
            assert!(
                s.pdf.is_finite() && s.weight.is_finite(),
                "{name} {wi}: {s:?}"
            );
        }
    }
}
