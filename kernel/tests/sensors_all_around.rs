//! Sensors that see all sides: panoramas and irradiance meters, and their importance against its definition.

mod common;

use common::Random;
use common::light_scene::{CAMERA, Scene, place};
use glam::{Affine3A, Quat, Vec2, Vec3};
use halflight_kernel::scene::camera::{film_position, ray_through, sample_ray};
use halflight_kernel::scene::{Camera, RgbParameter, camera_kind, irradiance_meter, quadric_kind};
use std::f64::consts::PI;

/// A sphere around the origin that is sampled evenly: the integral of the importance over it.
fn importance_over_a_sphere(scene: &Scene, radius: f32) -> f64 {
    let mut random = Random(5);
    const N: u32 = 1 << 20;
    let mut sum = 0.0;
    for _ in 0..N {
        let out = random.direction();
        let seen = film_position(&scene.tables(), out * radius, random.next_2d());
        sum += f64::from(seen.importance * out.dot(seen.direction).abs());
    }
    sum * 4.0 * PI * f64::from(radius * radius) / f64::from(N)
}

#[test]
fn importance_of_sensors_that_see_all_sides_integrates_to_one_over_a_surface_around_them() {
    let mut panorama = Scene::new();
    panorama.camera.kind = camera_kind::SPHERICAL;
    place(
        &mut panorama.camera,
        Affine3A::from_rotation_translation(
            Quat::from_axis_angle(Vec3::new(1.0, 2.0, -1.0).normalize(), 0.7),
            Vec3::new(0.4, -0.2, 0.3),
        ),
    );
    let integral = importance_over_a_sphere(&panorama, 2.0);
    assert!((integral - 1.0).abs() < 0.02, "panorama: {integral}");
    for (name, scene) in meters() {
        let integral = importance_over_a_sphere(&scene, 3.0);
        assert!((integral - 1.0).abs() < 0.02, "{name}: {integral}");
    }
}

/// Irradiance meters of several shapes.
fn meters() -> Vec<(&'static str, Scene)> {
    let white = RgbParameter::constant([1.0; 3]);
    let to_world = Affine3A::from_scale_rotation_translation(
        Vec3::new(0.5, 0.8, 1.0),
        Quat::from_axis_angle(Vec3::new(1.0, 2.0, -1.0).normalize(), 0.7),
        Vec3::new(0.4, -0.2, 0.3),
    );
    let mut meters = Vec::new();
    for (name, kind) in [
        ("disk", quadric_kind::DISK),
        ("cylinder", quadric_kind::CYLINDER),
    ] {
        let mut scene = Scene::new();
        scene.add_quadric_light(kind, to_world, 0, white);
        meters.push((name, scene));
    }
    let mut ball = Scene::new();
    let round = Affine3A::from_scale_rotation_translation(
        Vec3::splat(0.6),
        Quat::IDENTITY,
        Vec3::new(0.1, 0.2, 0.3),
    );
    ball.add_quadric_light(quadric_kind::SPHERE, round, 0, white);
    meters.push(("sphere", ball));
    let mut mesh = Scene::new();
    let corners = [
        Vec3::ZERO,
        Vec3::new(1.0, 0.0, 0.2),
        Vec3::new(0.2, 0.9, 0.0),
        Vec3::new(-0.5, 0.3, 0.6),
    ];
    mesh.add_mesh_light(&corners, &[], &[[0, 1, 2], [0, 2, 3]], 0, white);
    meters.push(("mesh", mesh));
    for (_, scene) in &mut meters {
        scene.camera.kind = camera_kind::IRRADIANCE_METER;
        scene.camera.shape = 0;
        scene.camera.shape_areas = scene.emitters[0].distribution;
    }
    meters
}

#[test]
fn rays_of_a_meter_leave_its_front_by_the_cosine_and_reach_points_with_their_density() {
    for (name, scene) in meters() {
        let tables = scene.tables();
        let mut random = Random(9);
        let mut cosines = 0.0;
        const N: u32 = 40_000;
        for _ in 0..N {
            let sample = sample_ray(&tables, [1, 2], random.next_2d(), random.next_2d());
            assert_eq!(sample.weight, std::f32::consts::PI);
            assert!((sample.ray.direction.length() - 1.0).abs() < 1e-5);
            assert!(sample.film.x >= 1.0 && sample.film.x <= 2.0 && sample.film.y >= 2.0);
            cosines += f64::from(sample.cosine);
            // The ray passes a point with the density that its importance says.
            let u = sample.film / 4.0;
            let far = sample.ray.at(1.5);
            let seen = film_position(&tables, far, u);
            let distance = (far - sample.ray.origin).length();
            let pdf = irradiance_meter::pdf_perpendicular_area(sample.cosine, distance);
            if sample.cosine > 0.05 {
                assert!(
                    seen.is_valid && seen.film == sample.film,
                    "{name}: {seen:?}"
                );
                let error = (seen.importance / pdf - 1.0).abs();
                assert!(error < 1e-2, "{name}: {} and {pdf}", seen.importance);
                assert!((seen.direction + sample.ray.direction).length() < 1e-3);
            }
            // Light from behind is not measured.
            let behind = film_position(&tables, sample.ray.origin - sample.ray.direction, u);
            assert!(sample.cosine < 1e-3 || !behind.is_valid, "{name}");
        }
        let mean = cosines / f64::from(N);
        assert!((mean - 2.0 / 3.0).abs() < 0.005, "{name}: {mean}");
    }
}

#[test]
fn pixels_of_a_meter_divide_a_rectangle_evenly() {
    let (_, mut scene) = meters().remove(3);
    scene.positions = vec![
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.5, 1.0, 0.5],
        [0.5, 1.0, 0.5],
    ];
    for (film, expected) in [
        ((1.0, 1.0), Vec3::new(0.625, 0.25, 0.125)),
        ((3.0, 1.0), Vec3::new(1.625, 0.25, 0.125)),
        ((1.0, 3.0), Vec3::new(0.875, 0.75, 0.375)),
    ] {
        let (ray, cosine) =
            irradiance_meter::ray(&scene.tables(), Vec2::new(film.0, film.1), Vec2::splat(0.5));
        assert!((ray.origin - expected).length() < 1e-5, "{film:?}: {ray:?}");
        assert!((cosine - 1.0).abs() < 1e-6);
    }
}

#[test]
fn panoramas_have_the_film_of_mitsuba() {
    let mut camera = Camera {
        kind: camera_kind::SPHERICAL,
        film_size: [64, 48],
        crop_size: [64, 48],
        clip: [0.0, f32::MAX],
        ..CAMERA
    };
    place(&mut camera, Affine3A::IDENTITY);
    // Longitude runs from behind the camera over its left, +x, to its front; latitude from above.
    for ((x, y), direction) in [
        ((32.0, 24.0), Vec3::Z),
        ((0.0, 24.0), Vec3::NEG_Z),
        ((16.0, 24.0), Vec3::X),
        ((48.0, 24.0), Vec3::NEG_X),
        ((7.0, 0.0), Vec3::Y),
        ((50.0, 48.0), Vec3::NEG_Y),
        ((32.0, 12.0), Vec3::new(0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt())),
    ] {
        let ray = ray_through(&camera, Vec2::new(x, y), Vec2::ZERO);
        assert!(
            (ray.direction - direction).length() < 1e-6,
            "{x} {y}: {ray:?}"
        );
        assert_eq!(ray.origin, Vec3::ZERO);
    }
}
