//! Environments and delta lights against another renderer.

mod common;

use common::light_scene::{Scene, affine, emitter, numbers, rows};
use glam::{Vec2, Vec3};
use halflight_kernel::scene::emitter::{environment_radiance, sample_direct};
use halflight_kernel::scene::{RgbParameter, emitter_kind, filter_mode};

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
        assert!(sample.pdf == 1.0 && sample.is_delta == 1, "{row:?}");
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
