//! Irradiance and power of emitters against closed forms.

mod common;

use common::Random;
use common::light_scene::{Scene, emitter};
use common::lit_scenes::{WHITE, look, quadric_scene, turned};
use glam::{Affine3A, Vec2, Vec3};
use halflight_kernel::scene::emitter::sample_direct;
use halflight_kernel::scene::{RgbParameter, emitter_kind, quadric_kind, shape_flag};
use std::f64::consts::PI;

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
