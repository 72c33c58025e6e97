//! Sampling of emitters against their densities and against what a ray finds.
//!
//! Statistical tests use fixed random numbers and a false-alarm rate below 1e-6 per statistic (5 standard errors).

mod common;

use common::Random;
use common::light_scene::{Scene, emitter, rows};
use common::lit_scenes::{WHITE, look, mesh_scene, quadric_scene, sky, turned};
use glam::{Affine3A, Vec2, Vec3};
use halflight_kernel::math::luminance;
use halflight_kernel::scene::emitter::{environment_radiance, pdf_environment, sample_direct};
use halflight_kernel::scene::{emitter_kind, quadric_kind, shape_flag};
use proptest::prelude::*;
use std::f64::consts::PI;

/// Test functions of a direction that a wrong density does not leave all alone.
fn probes(d: Vec3) -> [f64; 5] {
    let [x, y, z] = d.to_array().map(f64::from);
    [1.0, x, y, z, (3.0 * x + 2.0 * y).sin() * (4.0 * z).cos()]
}

/// Checks a scene of one non-delta light (or one environment) at a reference point: each sample's density, radiance and
/// distance are what a ray finds, `E[probe / pdf]` is the integral of the probe over the directions with a density, and
/// the density integrates to one (where nothing that it can choose is hidden).
fn check_light(name: &str, scene: &Scene, reference: Vec3) {
    let mut random = Random(0x51ab);
    const N: usize = 1 << 17;
    let mut mismatches = 0;
    let mut sampled = [[0.0_f64; 2]; 5];
    for _ in 0..N {
        let u_select = random.next_1d();
        let s = sample_direct(&scene.tables(), reference, u_select, random.next_2d());
        if s.pdf == 0.0 {
            continue;
        }
        assert!((s.direction.length() - 1.0).abs() < 1e-5);
        let (radiance, pdf, distance) = look(scene, reference, s.direction);
        // At silhouettes, cell borders and edges rounding may find the neighbour; elsewhere densities agree closely.
        let agrees = (pdf / s.pdf - 1.0).abs() < 5e-3
            && (radiance - s.radiance).length() <= 2e-2 * s.radiance.length().max(1e-3)
            && (distance / s.distance - 1.0).abs() < 1e-3;
        mismatches += usize::from(!agrees);
        for (sum, probe) in sampled.iter_mut().zip(probes(s.direction)) {
            let x = probe / f64::from(s.pdf);
            sum[0] += x;
            sum[1] += x * x;
        }
    }
    assert!(
        mismatches < N / 500,
        "{name}: {mismatches} of {N} samples differ from what a ray finds"
    );
    // The same integrals from uniform directions.
    let mut traced = [[0.0_f64; 2]; 5];
    let mut total = [0.0_f64; 2];
    const M: usize = 1 << 18;
    for _ in 0..M {
        let d = random.direction();
        let (_, pdf, _) = look(scene, reference, d);
        if pdf > 0.0 {
            for (sum, probe) in traced.iter_mut().zip(probes(d)) {
                let x = probe * 4.0 * PI;
                sum[0] += x;
                sum[1] += x * x;
            }
            let x = f64::from(pdf) * 4.0 * PI;
            total[0] += x;
            total[1] += x * x;
        }
    }
    let estimate = |sums: [f64; 2], n: usize| {
        let n = n as f64;
        let mean = sums[0] / n;
        (mean, (sums[1] / n - mean * mean).max(0.0) / n)
    };
    for (a, b) in sampled.iter().zip(&traced) {
        let (mean_a, variance_a) = estimate(*a, N);
        let (mean_b, variance_b) = estimate(*b, M);
        let z = (mean_a - mean_b) / (variance_a + variance_b + 1e-12).sqrt();
        assert!(
            z.abs() < 5.0,
            "{name}: {mean_a} sampled, {mean_b} traced, z = {z}"
        );
    }
    let (mean, variance) = estimate(total, M);
    let z = (mean - 1.0) / (variance + 1e-8).sqrt();
    assert!(
        z.abs() < 5.0,
        "{name}: the density integrates to {mean}, z = {z}"
    );
}

#[test]
fn sphere_lights() {
    let round = turned(Vec3::splat(0.7), Vec3::new(1.0, 2.0, 0.5));
    let scene = quadric_scene(quadric_kind::SPHERE, round, 0);
    check_light("sphere", &scene, Vec3::new(0.2, -0.1, 0.3));
    check_light("sphere nearby", &scene, Vec3::new(1.0, 2.0, 1.25));
    let scene = quadric_scene(quadric_kind::SPHERE, round, shape_flag::FLIP_NORMALS);
    check_light("sphere from inside", &scene, Vec3::new(1.2, 2.3, 0.4));
    let squeezed = turned(Vec3::new(0.4, 1.2, 0.7), Vec3::new(1.0, 2.0, 0.5));
    let scene = quadric_scene(quadric_kind::SPHERE, squeezed, 0);
    check_light("ellipsoid", &scene, Vec3::new(0.2, -0.1, 0.3));
    let scene = quadric_scene(quadric_kind::SPHERE, squeezed, shape_flag::FLIP_NORMALS);
    check_light("ellipsoid from inside", &scene, Vec3::new(1.1, 2.1, 0.5));
}

#[test]
fn disk_lights() {
    let squeezed = turned(Vec3::new(0.5, 1.3, 1.0), Vec3::new(1.0, 2.0, 0.5));
    for flags in [0, shape_flag::FLIP_NORMALS] {
        let scene = quadric_scene(quadric_kind::DISK, squeezed, flags);
        check_light("disk", &scene, Vec3::new(0.2, -0.1, 0.3));
        check_light("disk from behind", &scene, Vec3::new(2.0, 4.0, 0.0));
    }
}

#[test]
fn cylinder_lights() {
    // From outside the far wall is hidden, so look from inside, where every point is seen, at the flipped one too.
    for scale in [Vec3::new(0.8, 0.8, 2.0), Vec3::new(0.6, 1.1, 1.5)] {
        for flags in [0, shape_flag::FLIP_NORMALS] {
            let m = turned(scale, Vec3::new(1.0, 2.0, 0.5));
            let scene = quadric_scene(quadric_kind::CYLINDER, m, flags);
            check_light(
                "cylinder",
                &scene,
                m.transform_point3(Vec3::new(0.2, -0.1, 0.6)),
            );
        }
    }
}

#[test]
fn mesh_lights() {
    let scene = mesh_scene();
    check_light("mesh", &scene, Vec3::new(0.2, -0.1, 0.3));
    check_light("mesh from behind", &scene, Vec3::new(0.3, 5.0, 0.2));
}

#[test]
fn environment_lights() {
    let rotation = turned(Vec3::ONE, Vec3::ZERO);
    let mirror = Affine3A::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    for (w, h, to_world) in [
        (8, 5, rotation),
        (16, 9, mirror),
        (1, 2, rotation),
        (5, 1, rotation),
    ] {
        let mut scene = Scene::new();
        scene.add_environment(w, h, to_world, 1.5, |i, j| {
            if w == 1 { [1.0; 3] } else { sky(i, j + 1) }
        });
        scene.select();
        check_light("environment", &scene, Vec3::new(1.0, 2.0, 3.0));
    }
    let mut scene = Scene::new();
    scene.emitters.push(emitter(emitter_kind::CONSTANT, WHITE));
    scene.info.environment = 0;
    scene.select();
    check_light("constant", &scene, Vec3::ZERO);
}

#[test]
fn an_environment_is_never_bright_where_its_density_is_zero() {
    let mut scene = Scene::new();
    // One bright texel in the dark, beside a texel too dim for the table's precision.
    scene.add_environment(16, 8, Affine3A::IDENTITY, 1.0, |i, j| match (i, j) {
        (15, 3) => [1e6; 3],
        (4, 6) => [1e-3; 3],
        _ => [0.0; 3],
    });
    scene.select();
    let mut random = Random(3);
    let mut lit = 0;
    for _ in 0..100_000 {
        let d = random.direction();
        let radiance = environment_radiance(&scene.tables(), d);
        if luminance(radiance) > 0.0 {
            lit += 1;
            assert!(pdf_environment(&scene.tables(), d) > 0.0, "{d}: {radiance}");
        }
    }
    assert!(lit > 1000);
}

#[test]
fn a_scene_without_light_has_no_samples() {
    let scene = Scene::new();
    let s = sample_direct(&scene.tables(), Vec3::ZERO, 0.5, Vec2::splat(0.5));
    assert_eq!(s.pdf, 0.0);
    assert_eq!(environment_radiance(&scene.tables(), Vec3::Z), Vec3::ZERO);
    assert_eq!(pdf_environment(&scene.tables(), Vec3::Z), 0.0);
}

/// A scene with every kind of light.
fn every_light(scale: Vec3, translation: Vec3) -> Scene {
    let mut scene = mesh_scene();
    let m = turned(scale, translation);
    for kind in [
        quadric_kind::SPHERE,
        quadric_kind::DISK,
        quadric_kind::CYLINDER,
    ] {
        scene.add_quadric_light(kind, m, 0, WHITE);
    }
    for kind in [
        emitter_kind::POINT,
        emitter_kind::SPOT,
        emitter_kind::PROJECTOR,
        emitter_kind::DIRECTIONAL,
    ] {
        let mut record = emitter(kind, WHITE);
        record.to_world = rows(m);
        record.to_local = rows(m.inverse());
        record.parameters = [0.3, 0.3, 0.0, 0.0];
        scene.emitters.push(record);
    }
    // A triangle without area.
    scene.add_mesh_light(&[Vec3::ONE; 3], &[], &[[0, 1, 2]], 0, WHITE);
    scene.add_environment(5, 4, m, 1.0, sky);
    scene
}

proptest! {
    #[test]
    fn sampling_is_total(
        scale in prop::array::uniform3(prop_oneof![Just(1.0_f32), Just(1e-6), Just(1e5), -2.0_f32..2.0]),
        translation in prop::array::uniform3(prop_oneof![Just(0.0_f32), Just(1e6), -2.0_f32..2.0]),
        reference in prop::array::uniform3(
            prop_oneof![Just(0.0_f32), Just(1.0), Just(-1e-20), Just(1e6), -1e18_f32..1e18, -2.0_f32..2.0]
        ),
        on_light in any::<bool>(),
        ux in prop_oneof![Just(0.0_f32), Just(0.5), Just(0.999_999_94), 0.0_f32..1.0],
        uy in prop_oneof![Just(0.0_f32), Just(0.5), Just(0.999_999_94), 0.0_f32..1.0],
    ) {
        let scene = every_light(Vec3::from(scale), Vec3::from(translation));
        let tables = scene.tables();
        let reference = if on_light { Vec3::from(translation) } else { Vec3::from(reference) };
        for index in 0..scene.emitters.len() as u32 {
            let s = halflight_kernel::scene::emitter::sample_emitter(&tables, index, reference, Vec2::new(ux, uy));
            prop_assert!(s.pdf.is_finite() && s.pdf >= 0.0, "{}: pdf {}", index, s.pdf);
            if s.pdf > 0.0 {
                prop_assert!(s.direction.is_finite() && (s.direction.length() - 1.0).abs() < 1e-3, "{}: {:?}", index, s);
                prop_assert!(s.radiance.is_finite() && s.radiance.min_element() >= 0.0);
                prop_assert!(s.distance > 0.0 && s.target.is_finite());
            }
        }
    }
}
