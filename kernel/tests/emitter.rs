//! Emitters: every sampler against its density and against what a ray finds, analytic irradiances, another renderer.
//!
//! Statistical tests use fixed random numbers and a false-alarm rate below 1e-6 per statistic (5 standard errors).

mod common;

use common::Random;
use common::light_scene::{Scene, affine, emitter, numbers, rows};
use glam::{Affine3A, EulerRot, Quat, Vec2, Vec3};
use halflight_kernel::math::{Ray, luminance};
use halflight_kernel::scene::emitter::{
    area_radiance, environment_radiance, pdf_direct, pdf_environment, sample_direct,
};
use halflight_kernel::scene::{
    RgbParameter, emitter_kind, filter_mode, quadric_kind, shape_flag, surface_at,
};
use proptest::prelude::*;
use std::f64::consts::PI;

const WHITE: RgbParameter = RgbParameter::constant([1.0; 3]);

fn turned(scale: Vec3, translation: Vec3) -> Affine3A {
    let rotation = Quat::from_euler(EulerRot::XYZ, 0.4, -0.9, 2.0);
    Affine3A::from_scale_rotation_translation(scale, rotation, translation)
}

/// What looking along a direction finds: radiance, the density of having sampled it, the distance.
fn look(scene: &Scene, origin: Vec3, direction: Vec3) -> (Vec3, f32, f32) {
    let tables = scene.tables();
    let ray = Ray::new(origin, direction);
    let hit = scene.closest_hit(&ray);
    if !hit.is_hit() {
        return (
            environment_radiance(&tables, direction),
            pdf_environment(&tables, direction),
            f32::MAX,
        );
    }
    let point = surface_at(&tables, &ray, &hit);
    (
        area_radiance(&tables, &point, -direction),
        pdf_direct(&tables, origin, &point),
        hit.t,
    )
}

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

fn quadric_scene(kind: u32, to_world: Affine3A, flags: u32) -> Scene {
    let mut scene = Scene::new();
    scene.add_quadric_light(
        kind,
        to_world,
        flags,
        RgbParameter::constant([1.0, 2.0, 3.0]),
    );
    scene.select();
    scene
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

/// A tent of two rectangles of different sizes, textured.
fn mesh_scene() -> Scene {
    let mut scene = Scene::new();
    let texture = scene.add_bitmap(3, 2, filter_mode::BILINEAR, |i, j| {
        [0.5 + i as f32, 0.3 + j as f32, 1.0]
    });
    let p = [
        Vec3::new(-1.0, 2.0, -1.0),
        Vec3::new(-1.0, 2.0, 1.0),
        Vec3::new(0.5, 2.4, 1.0),
        Vec3::new(0.5, 2.4, -1.0),
        Vec3::new(2.5, 1.6, 1.0),
        Vec3::new(2.5, 1.6, -1.0),
    ];
    let uv = [
        [0.1, 0.2],
        [0.1, 0.8],
        [0.5, 0.8],
        [0.5, 0.2],
        [0.9, 0.8],
        [0.9, 0.2],
    ];
    let triangles = [[0, 2, 1], [0, 3, 2], [3, 4, 2], [3, 5, 4]];
    scene.add_mesh_light(
        &p,
        &uv,
        &triangles,
        0,
        RgbParameter {
            value: [1.0, 0.5, 2.0],
            texture,
        },
    );
    scene.select();
    scene
}

#[test]
fn mesh_lights() {
    let scene = mesh_scene();
    check_light("mesh", &scene, Vec3::new(0.2, -0.1, 0.3));
    check_light("mesh from behind", &scene, Vec3::new(0.3, 5.0, 0.2));
}

/// A high-contrast image with black parts.
fn sky(i: u32, j: u32) -> [f32; 3] {
    let x = ((7 * i + 5 * j) % 11) as f32;
    if x < 3.0 {
        [0.0; 3]
    } else if x == 4.0 {
        [30.0, 20.0, 10.0]
    } else {
        [x, 1.0, 0.5 * x]
    }
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
fn environments_look_up_what_another_renderer_does() {
    for row in numbers(include_str!("oracle/environment.csv")) {
        let mut scene = Scene::new();
        let texel =
            |i: u32, j: u32| [0, 1, 2].map(|c| ((7 * i + 5 * j + 3 * c) % 11) as f32 / 10.0 + 0.05);
        scene.add_environment(
            row[0] as u32,
            row[1] as u32,
            affine(&row[2..14]),
            2.0,
            texel,
        );
        scene.select();
        let radiance = environment_radiance(&scene.tables(), Vec3::from_slice(&row[14..17]));
        let expected = Vec3::from_slice(&row[17..20]);
        assert!((radiance - expected).length() < 1e-4, "{row:?}: {radiance}");
    }
}

#[test]
fn delta_lights_are_those_of_another_renderer() {
    let mut lit = 0;
    for row in numbers(include_str!("oracle/emitters.csv")) {
        let mut scene = Scene::new();
        let texel =
            |i: u32, j: u32| [0, 1, 2].map(|c| ((7 * i + 5 * j + 3 * c) % 11) as f32 / 10.0 + 0.05);
        let kind = row[0] as u32;
        let mut record = emitter(kind, RgbParameter::constant([1.0, 2.0, 3.0]));
        if row[1] == 1.0 {
            let texture = scene.add_bitmap(5, 3, filter_mode::NEAREST, texel);
            record.radiance.texture = texture;
        }
        if kind == emitter_kind::PROJECTOR {
            record.radiance.value = [1.0; 3];
            let t = (0.5 * row[2]).to_radians().tan();
            record.parameters = [t, t * 0.6, 0.0, 0.0];
        } else {
            record.parameters = [row[2].to_radians(), row[3].to_radians(), 0.0, 0.0];
        }
        let to_world = affine(&row[4..16]);
        record.to_world = rows(to_world);
        record.to_local = rows(to_world.inverse());
        scene.emitters.push(record);
        let reference = Vec3::from_slice(&row[16..19]);
        let sample = sample_direct(&scene.tables(), reference, 0.5, Vec2::splat(0.5));
        let expected = Vec3::from_slice(&row[23..26]);
        if expected == Vec3::ZERO {
            assert!(
                sample.pdf == 0.0 || sample.radiance == Vec3::ZERO,
                "{row:?}"
            );
            continue;
        }
        lit += 1;
        assert!(sample.pdf == 1.0 && sample.is_delta, "{row:?}");
        let direction = Vec3::from_slice(&row[19..22]);
        assert!((sample.direction - direction).length() < 1e-5, "{row:?}");
        let error = (sample.radiance - expected).length() / expected.length();
        assert!(error < 1e-4, "{row:?}: {:?}", sample.radiance);
        if kind == emitter_kind::DIRECTIONAL {
            assert_eq!(sample.distance, f32::MAX);
        } else {
            assert!((sample.distance - row[22]).abs() < 1e-5 * row[22]);
            assert!((sample.target - to_world.transform_point3(Vec3::ZERO)).length() < 1e-5);
        }
    }
    assert!(lit > 25);
}

/// Irradiance at the origin on a surface facing +z, from stratified samples.
fn irradiance(scene: &Scene, reference: Vec3) -> f64 {
    const N: u32 = 512;
    let mut random = Random(9);
    let mut sum = 0.0;
    for i in 0..N * N {
        let u = (Vec2::new((i % N) as f32, (i / N) as f32) + random.next_2d()) / N as f32;
        let s = sample_direct(
            &scene.tables(),
            reference,
            random.next_1d(),
            u.min(Vec2::splat(0.999_999_9)),
        );
        if s.pdf > 0.0 {
            sum += f64::from(s.radiance.x * s.direction.z.max(0.0) / s.pdf);
        }
    }
    sum / f64::from(N * N)
}

#[track_caller]
fn assert_close(value: f64, expected: f64, relative: f64) {
    assert!(
        (value / expected - 1.0).abs() < relative,
        "{value} instead of {expected}"
    );
}

#[test]
fn irradiances_have_their_closed_forms() {
    // A disk of radius R at height h over the receiver, facing it: pi L R^2 / (R^2 + h^2).
    let facing = Affine3A::from_translation(Vec3::new(0.0, 0.0, 2.0))
        * Affine3A::from_scale(Vec3::new(1.5, 1.5, 1.0));
    let disk = quadric_scene(quadric_kind::DISK, facing, shape_flag::FLIP_NORMALS);
    assert_close(irradiance(&disk, Vec3::ZERO), PI * 2.25 / 6.25, 1e-3);
    // Its back does not shine.
    let back = quadric_scene(quadric_kind::DISK, facing, 0);
    assert_eq!(irradiance(&back, Vec3::ZERO), 0.0);
    // A sphere of radius R at distance d overhead: pi L (R / d)^2, however far or near.
    for (r, d) in [(1.0, 3.0), (1.0, 1.001), (1e-3, 500.0), (0.5, 4e4)] {
        let m = Affine3A::from_translation(Vec3::new(0.0, 0.0, d))
            * Affine3A::from_scale(Vec3::splat(r));
        let sphere = quadric_scene(quadric_kind::SPHERE, m, 0);
        assert_close(
            irradiance(&sphere, Vec3::ZERO),
            PI * f64::from(r / d).powi(2),
            2e-3,
        );
    }
    // Inside a glowing sphere: pi L.
    let inside = quadric_scene(
        quadric_kind::SPHERE,
        Affine3A::from_scale(Vec3::splat(3.0)),
        shape_flag::FLIP_NORMALS,
    );
    assert_close(irradiance(&inside, Vec3::new(0.5, 1.0, -1.0)), PI, 2e-3);
    // An unoccluded constant environment: pi L.
    let mut sky = Scene::new();
    sky.emitters.push(emitter(emitter_kind::CONSTANT, WHITE));
    sky.info.environment = 0;
    assert_close(irradiance(&sky, Vec3::ZERO), PI, 2e-3);
    let mut sky = Scene::new();
    sky.add_environment(12, 7, turned(Vec3::ONE, Vec3::ZERO), 1.0, |_, _| [1.0; 3]);
    assert_close(irradiance(&sky, Vec3::ZERO), PI, 2e-3);
    // A parallel a x b rectangle at distance h with a corner overhead (form factor of a differential element).
    let (a, b, h) = (1.5_f64, 0.8_f64, 1.2_f64);
    let mut rectangle = Scene::new();
    let p = [(0.0, 0.0), (a, 0.0), (a, b), (0.0, b)]
        .map(|(x, y)| Vec3::new(x as f32, y as f32, h as f32));
    rectangle.add_mesh_light(&p, &[], &[[0, 2, 1], [0, 3, 2]], 0, WHITE);
    let (x, y) = (a / h, b / h);
    let (sx, sy) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let form_factor = (x / sx * (y / sx).atan() + y / sy * (x / sy).atan()) / (2.0 * PI);
    assert_close(irradiance(&rectangle, Vec3::ZERO), PI * form_factor, 1e-3);
    // Point and directional lights.
    let mut point = Scene::new();
    let mut record = emitter(emitter_kind::POINT, RgbParameter::constant([8.0; 3]));
    record.to_world[11] = 4.0;
    point.emitters.push(record);
    assert_close(irradiance(&point, Vec3::ZERO), 0.5, 1e-5);
    let mut sun = Scene::new();
    let mut record = emitter(emitter_kind::DIRECTIONAL, RgbParameter::constant([3.0; 3]));
    // Travelling down: local z to world -z.
    record.to_world = [3.0, 0.0, 0.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, -3.0, 0.0];
    sun.emitters.push(record);
    assert_close(irradiance(&sun, Vec3::ZERO), 3.0, 1e-5);
}

#[test]
fn several_lights_add_up_whatever_their_probabilities() {
    let disk = |z: f32| Affine3A::from_translation(Vec3::new(0.0, 0.0, z));
    let one = RgbParameter::constant([1.0; 3]);
    let mut scene = Scene::new();
    scene.add_quadric_light(quadric_kind::DISK, disk(1.0), shape_flag::FLIP_NORMALS, one);
    scene.add_quadric_light(
        quadric_kind::DISK,
        disk(3.0),
        shape_flag::FLIP_NORMALS,
        RgbParameter::constant([20.0; 3]),
    );
    scene.add_quadric_light(
        quadric_kind::DISK,
        disk(2.0),
        shape_flag::FLIP_NORMALS,
        RgbParameter::constant([0.0; 3]),
    );
    scene.emitters.push(emitter(emitter_kind::CONSTANT, one));
    scene.info.environment = 3;
    scene.select();
    let sum: f32 = scene.emitters.iter().map(|e| e.selection_pdf).sum();
    assert!((sum - 1.0).abs() < 1e-6);
    assert_eq!(scene.emitters[2].selection_pdf, 0.0);
    assert!(scene.emitters[0].selection_pdf > 0.1);
    // Unoccluded: every light counts in full.
    assert_close(
        irradiance(&scene, Vec3::ZERO),
        PI * (0.5 + 20.0 / 10.0 + 1.0),
        1e-2,
    );
    // The probability of the choice is part of the stated densities.
    let s = sample_direct(&scene.tables(), Vec3::ZERO, 0.0, Vec2::splat(0.3));
    let (_, pdf, _) = look(&scene, Vec3::ZERO, s.direction);
    assert!((pdf / s.pdf - 1.0).abs() < 1e-4);
}

#[test]
fn powers_have_their_closed_forms() {
    let mut scene = Scene::new();
    let m = turned(Vec3::splat(2.0), Vec3::ONE);
    scene.add_quadric_light(quadric_kind::SPHERE, m, 0, WHITE);
    scene.add_quadric_light(
        quadric_kind::DISK,
        turned(Vec3::new(2.0, 3.0, 1.0), Vec3::ONE),
        0,
        WHITE,
    );
    scene.add_quadric_light(
        quadric_kind::CYLINDER,
        turned(Vec3::new(2.0, 2.0, 5.0), Vec3::ONE),
        0,
        WHITE,
    );
    scene.emitters.push(emitter(emitter_kind::POINT, WHITE));
    scene
        .emitters
        .push(emitter(emitter_kind::DIRECTIONAL, WHITE));
    scene.emitters.push(emitter(emitter_kind::CONSTANT, WHITE));
    scene.add_environment(6, 5, Affine3A::IDENTITY, 1.0, |_, _| [1.0; 3]);
    let power = |i: u32| f64::from(halflight_kernel::scene::emitter::power(&scene.tables(), i));
    assert_close(power(0), PI * 16.0 * PI, 1e-4);
    assert_close(power(1), PI * 6.0 * PI, 1e-4);
    assert_close(power(2), PI * 20.0 * PI, 1e-4);
    assert_close(power(3), 4.0 * PI, 1e-4);
    assert_close(power(4), 100.0 * PI, 1e-4);
    assert_close(power(5), 400.0 * PI * PI, 1e-4);
    assert_close(power(6), 400.0 * PI * PI, 1e-4);
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
