//! Positions on emitters follow their density, and the density integrates to one.

use crate::common::Random;
use crate::common::light_scene::Scene;
use crate::common::lit_scenes::{WHITE, mesh_scene, turned};
use crate::surfaces::{QUADRICS, over_triangles, probes, sheared, surface_integrals};
use crate::{Mean, SAMPLES};
use glam::Vec3;
use halflight_kernel::scene::emitter::position;
use halflight_kernel::scene::shape_flag;

#[test]
fn positions_follow_their_density_on_quadrics() {
    let maps = [
        ("round", turned(Vec3::splat(0.7), Vec3::new(1.0, 2.0, 0.5))),
        ("squeezed", turned(Vec3::new(0.4, 1.2, 0.7), Vec3::ONE)),
        ("mirrored", turned(Vec3::new(-0.5, 1.0, 0.8), Vec3::ONE)),
        ("sheared", sheared()),
    ];
    for (shape, kind, at) in QUADRICS {
        for (map_name, map) in maps {
            for flags in [0, shape_flag::FLIP_NORMALS] {
                let mut scene = Scene::new();
                scene.add_quadric_light(kind, map, flags, WHITE);
                scene.select();
                let expected = surface_integrals(map, at);
                check_positions(&format!("{map_name} {shape}"), &scene, expected);
            }
        }
    }
}

fn check_positions(name: &str, scene: &Scene, expected: [f64; 6]) {
    let tables = scene.tables();
    let mut random = Random(0x1e7);
    let mut means: [Mean; 6] = std::array::from_fn(|_| Mean::default());
    for _ in 0..SAMPLES {
        let (point, pdf) = position::sample_position(&tables, 0, random.next_2d());
        assert!(pdf > 0.0 && pdf.is_finite(), "{name}: density {pdf}");
        let again = position::pdf_position(&tables, &point);
        assert!((again / pdf - 1.0).abs() < 1e-5, "{name}: {again}, {pdf}");
        for (mean, probe) in means.iter_mut().zip(probes(point.position.as_dvec3())) {
            mean.add(probe / f64::from(pdf));
        }
    }
    for (i, (mean, expected)) in means.iter().zip(expected).enumerate() {
        mean.assert_is(&format!("{name}, probe {i}"), expected);
    }
}

#[test]
fn positions_follow_their_density_on_meshes() {
    let scene = mesh_scene();
    let mut expected = [0.0; 6];
    over_triangles(&scene, |point, area| {
        for (sum, probe) in expected.iter_mut().zip(probes(point.position.as_dvec3())) {
            *sum += probe * area;
        }
    });
    check_positions("mesh", &scene, expected);
}
