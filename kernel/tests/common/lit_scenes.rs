//! Scenes of one light, and what a ray finds in them.

use super::light_scene::Scene;
use glam::{Affine3A, EulerRot, Quat, Vec3};
use halflight_kernel::math::Ray;
use halflight_kernel::scene::emitter::{
    area_radiance, environment_radiance, pdf_direct, pdf_environment,
};
use halflight_kernel::scene::{RgbParameter, filter_mode, surface_at};

/// One in every band.
pub const WHITE: RgbParameter = RgbParameter::constant([1.0; 3]);

/// A map that turns whatever it is given.
pub fn turned(scale: Vec3, translation: Vec3) -> Affine3A {
    let rotation = Quat::from_euler(EulerRot::XYZ, 0.4, -0.9, 2.0);
    Affine3A::from_scale_rotation_translation(scale, rotation, translation)
}

/// What looking along a direction finds: radiance, the density of having sampled it, the distance.
pub fn look(scene: &Scene, origin: Vec3, direction: Vec3) -> (Vec3, f32, f32) {
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

/// One emitting quadric.
pub fn quadric_scene(kind: u32, to_world: Affine3A, flags: u32) -> Scene {
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

/// A tent of two rectangles of different sizes, textured.
pub fn mesh_scene() -> Scene {
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

/// A high-contrast image with black parts.
pub fn sky(i: u32, j: u32) -> [f32; 3] {
    let x = ((7 * i + 5 * j) % 11) as f32;
    if x < 3.0 {
        [0.0; 3]
    } else if x == 4.0 {
        [30.0, 20.0, 10.0]
    } else {
        [x, 1.0, 0.5 * x]
    }
}
