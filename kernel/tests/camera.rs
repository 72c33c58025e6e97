//! Cameras against another renderer's rays, against their own inverse, and their importance against its definition.

mod common;

use common::Random;
use common::light_scene::{CAMERA, Scene, affine, numbers, place};
use glam::{Affine3A, Quat, Vec2, Vec3};
use halflight_kernel::math::{Ray, filter};
use halflight_kernel::scene::camera::{
    film_position, film_position_through, fov_axis, half_extents, intersect_lens, optical_axis,
    pdf_lens_area, pdf_perpendicular_area, pixels_per_window_pixel, ray_through, sample_ray,
};
use halflight_kernel::scene::{Camera, camera_kind, filter_kind};
use proptest::prelude::*;

#[test]
fn rays_are_those_of_another_renderer() {
    for row in numbers(include_str!("oracle/cameras.csv")) {
        let kind = row[0] as u32;
        let size = [row[3] as u32, row[4] as u32];
        let (width, height) = if kind == camera_kind::ORTHOGRAPHIC {
            (1.0, size[1] as f32 / size[0] as f32)
        } else {
            half_extents(row[1], row[2] as u32, size[0], size[1])
        };
        let mut camera = Camera {
            kind,
            film_size: size,
            crop_offset: [row[5] as u32, row[6] as u32],
            crop_size: [row[7] as u32, row[8] as u32],
            principal_point_offset: [row[9], row[10]],
            tan_half_width: width,
            tan_half_height: height,
            aperture_radius: row[11],
            focus_distance: row[12],
            clip: [row[13], row[14]],
            ..CAMERA
        };
        place(&mut camera, affine(&row[15..27]));
        // Its positions are fractions of the crop window.
        let film = Vec2::new(row[5] + row[27] * row[7], row[6] + row[28] * row[8]);
        let ray = ray_through(&camera, film, Vec2::new(row[29], row[30]));
        // Its rays start on the near plane.
        let start = ray.at(ray.t_min);
        let origin = Vec3::from_slice(&row[31..34]);
        let direction = Vec3::from_slice(&row[34..37]);
        assert!((start - origin).length() < 2e-5, "{row:?}: {start}");
        assert!(
            (ray.direction - direction).length() < 1e-5,
            "{row:?}: {ray:?}"
        );
        let length = ray.t_max - ray.t_min;
        assert!((length / row[37] - 1.0).abs() < 1e-5, "{row:?}: {length}");
    }
}

#[test]
fn half_extents_follow_the_axis() {
    let t = 22.5_f32.to_radians().tan();
    for (axis, w, h, expected) in [
        (fov_axis::X, 4, 3, (t, t * 0.75)),
        (fov_axis::Y, 4, 3, (t / 0.75, t)),
        (fov_axis::SMALLER, 4, 3, (t / 0.75, t)),
        (fov_axis::LARGER, 4, 3, (t, t * 0.75)),
        (fov_axis::SMALLER, 3, 4, (t, t / 0.75)),
        (fov_axis::LARGER, 3, 4, (t * 0.75, t)),
        (fov_axis::DIAGONAL, 4, 3, (t * 0.8, t * 0.6)),
    ] {
        let (x, y) = half_extents(45.0, axis, w, h);
        assert!((x - expected.0).abs() < 1e-6 && (y - expected.1).abs() < 1e-6);
    }
    let (x, y) = half_extents(f32::MAX, fov_axis::X, 0, 0);
    assert!(x.is_finite() && y.is_finite());
}

/// A camera of any kind, anywhere, with a crop window.
fn any_camera() -> impl Strategy<Value = Camera> {
    (
        0..=camera_kind::SPHERICAL,
        prop::array::uniform3(-5.0_f32..5.0),
        prop::array::uniform4(-1.0_f32..1.0),
        0.2_f32..2.0,
        0.2_f32..2.0,
        (-0.3_f32..0.3, -0.3_f32..0.3),
        0.01_f32..0.5,
        0.5_f32..8.0,
        0.3_f32..3.0,
    )
        .prop_map(|(kind, origin, q, w, h, pp, aperture, focus, scale)| {
            let rotation = Quat::from_array(q);
            let rotation = if rotation.length() > 0.1 {
                rotation.normalize()
            } else {
                Quat::IDENTITY
            };
            // Only orthographic cameras may be scaled.
            let scale = if kind == camera_kind::ORTHOGRAPHIC {
                Vec3::new(scale, 1.5, 2.0)
            } else {
                Vec3::ONE
            };
            let mut camera = Camera {
                kind,
                film_size: [64, 48],
                crop_offset: [10, 7],
                crop_size: [40, 30],
                tan_half_width: w,
                tan_half_height: h,
                principal_point_offset: [pp.0, pp.1],
                aperture_radius: aperture,
                focus_distance: focus,
                clip: [0.1, 50.0],
                ..CAMERA
            };
            place(
                &mut camera,
                Affine3A::from_scale_rotation_translation(scale, rotation, Vec3::from(origin)),
            );
            camera
        })
}

fn unit_pair() -> impl Strategy<Value = Vec2> {
    (0.0_f32..1.0, 0.0_f32..1.0).prop_map(|(x, y)| Vec2::new(x, y))
}

proptest! {
    #[test]
    fn film_positions_invert_rays(
        camera in any_camera(), u in unit_pair(), lens in unit_pair(), t in 0.02_f32..0.9,
        px in 10_u32..50, py in 7_u32..37,
    ) {
        let mut scene = Scene::new();
        scene.camera = camera;
        let tables = scene.tables();
        let sample = sample_ray(&tables, [px, py], u, lens);
        prop_assert!((sample.ray.direction.length() - 1.0).abs() < 1e-5);
        prop_assert_eq!(sample.weight, 1.0);
        prop_assert!((sample.film - Vec2::new(px as f32, py as f32) - 0.5).abs().max_element() <= 0.5);
        let point = sample.ray.at(sample.ray.t_min + t * (sample.ray.t_max - sample.ray.t_min));
        let seen = film_position(&tables, point, lens);
        // Rounding of points up to 50 units from the camera, in pixels of 1/64 of the film.
        let error = (seen.film - sample.film).length();
        prop_assert!(error < 5e-3, "{} pixels off", error);
        prop_assert!((seen.direction + sample.ray.direction).length() < 1e-3);
        let inside = sample.film.x > 10.01 && sample.film.x < 49.99 && sample.film.y > 7.01 && sample.film.y < 36.99;
        prop_assert!(seen.is_valid || !inside);
        prop_assert!(!inside || seen.importance > 0.0);
        let distance = (point - sample.ray.origin).length();
        prop_assert!((seen.distance - distance).abs() < 1e-3 * distance);
    }

    #[test]
    fn rays_of_the_window_arrive_with_their_density(
        camera in any_camera(), u in unit_pair(), lens in unit_pair(), t in 0.02_f32..0.5, turn in 0.0_f32..6.0,
    ) {
        let mut scene = Scene::new();
        scene.camera = camera;
        let tables = scene.tables();
        let sample = sample_ray(&tables, [30, 20], u, lens);
        let point = sample.ray.at(sample.ray.t_min + t * (sample.ray.t_max - sample.ray.t_min));
        let seen = film_position(&tables, point, lens);
        prop_assume!(seen.is_valid);
        // Central differences of the film position along two directions across the ray; 40 by 30 pixels in the window.
        let a = sample.ray.direction.any_orthonormal_vector();
        let b = sample.ray.direction.cross(a);
        let (s, c) = turn.sin_cos();
        let (a, b) = (a * c + b * s, b * c - a * s);
        let step = 0.02 * seen.distance;
        let film = |d: Vec3| film_position(&tables, point + d, lens).film;
        let da = (film(a * step) - film(a * -step)) / (2.0 * step);
        let db = (film(b * step) - film(b * -step)) / (2.0 * step);
        let expected = da.perp_dot(db).abs() / (40.0 * 30.0);
        let distance = (point - sample.ray.origin).length();
        let found = pdf_perpendicular_area(&tables, point, distance);
        prop_assert!((found / expected - 1.0).abs() < 2e-2, "{} instead of {}", found, expected);
        let by_importance = seen.importance * pixels_per_window_pixel(&camera);
        prop_assert!((found / by_importance - 1.0).abs() < 1e-3, "{} and {}", found, by_importance);
    }

    #[test]
    fn light_against_a_ray_meets_the_lens_where_the_ray_left_it(
        camera in any_camera(), u in unit_pair(), lens in unit_pair(), t in 0.02_f32..0.5,
    ) {
        let mut scene = Scene::new();
        scene.camera = camera;
        let tables = scene.tables();
        let sample = sample_ray(&tables, [30, 20], u, lens);
        let distance = sample.ray.t_min + t * (sample.ray.t_max - sample.ray.t_min);
        let point = sample.ray.at(distance);
        let back = Ray::new(point, -sample.ray.direction);
        let met = intersect_lens(&camera, &back);
        if camera.kind != camera_kind::THIN_LENS {
            prop_assert!(!met.is_hit && pdf_lens_area(&camera) == 0.0);
            return Ok(());
        }
        let r = camera.aperture_radius;
        prop_assert!((pdf_lens_area(&camera) * std::f32::consts::PI * r * r - 1.0).abs() < 1e-5);
        prop_assert!((optical_axis(&camera).length() - 1.0).abs() < 1e-5);
        // At the rim rounding decides.
        let inside = (lens - 0.5).length() < 0.49;
        prop_assert!(met.is_hit || !inside);
        if met.is_hit {
            prop_assert!((met.t - distance).abs() < 1e-3 * distance.max(1.0));
            let seen = film_position_through(&tables, point, met.lens);
            prop_assert!((seen.film - sample.film).length() < 0.05, "{} and {}", seen.film, sample.film);
            let short = Ray { t_max: 0.9 * distance, ..back };
            prop_assert!(!intersect_lens(&camera, &short).is_hit);
            let away = Ray::new(point, sample.ray.direction);
            prop_assert!(!intersect_lens(&camera, &away).is_hit);
            // Beside the lens.
            let side = (point - sample.ray.origin).any_orthonormal_vector() * (2.1 * r);
            let beside = Ray::new(point + side, -sample.ray.direction);
            let axis = optical_axis(&camera);
            let shift = side - sample.ray.direction * (side.dot(axis) / sample.ray.direction.dot(axis));
            if shift.length() > 2.01 * r {
                prop_assert!(!intersect_lens(&camera, &beside).is_hit);
            }
        }
    }

    #[test]
    fn importance_is_the_films_share_per_perpendicular_area(
        camera in any_camera(), u in unit_pair(), lens in unit_pair(), t in 0.02_f32..0.5, turn in 0.0_f32..6.0,
    ) {
        let mut scene = Scene::new();
        scene.camera = camera;
        scene.camera.crop_offset = [0, 0];
        scene.camera.crop_size = scene.camera.film_size;
        let tables = scene.tables();
        let sample = sample_ray(&tables, [30, 20], u, lens);
        let point = sample.ray.at(sample.ray.t_min + t * (sample.ray.t_max - sample.ray.t_min));
        let seen = film_position(&tables, point, lens);
        prop_assume!(seen.is_valid);
        // Central differences of the film position along two directions across the ray.
        let a = sample.ray.direction.any_orthonormal_vector();
        let b = sample.ray.direction.cross(a);
        let (s, c) = turn.sin_cos();
        let (a, b) = (a * c + b * s, b * c - a * s);
        let step = 0.02 * seen.distance;
        let film = |d: Vec3| film_position(&tables, point + d, lens).film;
        let da = (film(a * step) - film(a * -step)) / (2.0 * step);
        let db = (film(b * step) - film(b * -step)) / (2.0 * step);
        let share = da.perp_dot(db).abs() / (64.0 * 48.0);
        // Third-order error of the differences: step^2 / distance^2 times the tangents of a wide film.
        prop_assert!((share / seen.importance - 1.0).abs() < 2e-2, "{} against {}", share, seen.importance);
    }
}

#[test]
fn importance_integrates_to_one_over_a_surface_that_fills_the_view() {
    // A tilted plane, random points; the standard error is below 0.3 %.
    for kind in [
        camera_kind::PERSPECTIVE,
        camera_kind::THIN_LENS,
        camera_kind::ORTHOGRAPHIC,
    ] {
        let mut scene = Scene::new();
        scene.camera = Camera {
            kind,
            film_size: [40, 30],
            crop_size: [40, 30],
            tan_half_width: 0.8,
            tan_half_height: 0.6,
            aperture_radius: 0.3,
            focus_distance: 2.0,
            clip: [0.1, 100.0],
            ..CAMERA
        };
        let look = Affine3A::from_rotation_translation(
            Quat::from_axis_angle(Vec3::new(1.0, 2.0, -1.0).normalize(), 0.7),
            Vec3::new(3.0, -1.0, 2.0),
        );
        place(&mut scene.camera, look);
        let normal = look.transform_vector3(Vec3::new(0.3, 0.2, -1.0).normalize());
        let center = look.transform_point3(Vec3::new(0.0, 0.0, 4.0));
        let x = normal.any_orthonormal_vector();
        let y = normal.cross(x);
        let half = 8.0;
        let mut random = Random(5);
        const N: u32 = 1 << 20;
        let mut sum = 0.0;
        for _ in 0..N {
            let u = (random.next_2d() * 2.0 - 1.0) * half;
            let seen = film_position(
                &scene.tables(),
                center + x * u.x + y * u.y,
                random.next_2d(),
            );
            sum += f64::from(seen.importance * normal.dot(seen.direction).abs());
        }
        let integral = sum * f64::from(4.0 * half * half) / f64::from(N);
        assert!((integral - 1.0).abs() < 0.015, "kind {kind}: {integral}");
    }
}

#[test]
fn samples_stay_in_the_crop_window_and_pixels_outside_weigh_nothing() {
    let mut scene = Scene::new();
    let size = filter::TABLE_SIZE;
    scene.data = vec![0.0; filter::table_words(size) as usize];
    scene.camera = Camera {
        film_size: [20, 20],
        crop_offset: [3, 4],
        crop_size: [5, 1],
        filter: filter_kind::LANCZOS,
        filter_parameters: [3.0, 0.0, 0.0],
        filter_table_size: size,
        ..CAMERA
    };
    filter::fill_table(
        scene.camera.filter,
        scene.camera.filter_parameters,
        &mut scene.data,
    );
    let mut random = Random(1);
    let mut negative = 0;
    for _ in 0..2000 {
        for x in 3..8 {
            let s = sample_ray(&scene.tables(), [x, 4], random.next_2d(), random.next_2d());
            assert!(s.film.x >= 3.0 && s.film.x <= 8.0 && s.film.y >= 4.0 && s.film.y <= 5.0);
            negative += u32::from(s.weight < 0.0);
        }
    }
    assert!(
        negative > 0,
        "a filter with negative lobes has negative weights"
    );
    let outside = sample_ray(&scene.tables(), [15, 4], random.next_2d(), random.next_2d());
    assert_eq!(outside.weight, 0.0);
}

#[test]
fn points_behind_the_camera_or_beyond_the_clipping_planes_are_not_seen() {
    let mut scene = Scene::new();
    scene.camera.clip = [1.0, 10.0];
    for z in [-2.0, 0.0, 0.5, 11.0, f32::NAN, f32::MAX] {
        let seen = film_position(&scene.tables(), Vec3::new(0.0, 0.0, z), Vec2::ZERO);
        assert!(!seen.is_valid && seen.importance == 0.0, "{z}");
    }
    assert!(film_position(&scene.tables(), Vec3::new(0.0, 0.0, 2.0), Vec2::ZERO).is_valid);
}
