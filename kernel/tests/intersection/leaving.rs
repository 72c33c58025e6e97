//! Rays that leave surfaces do not hit them again, and shadow rays end before their targets.

use crate::intersect;
use crate::primitives::{Primitives, canonical, direction, map, map_of, point, runner};
use glam::{DAffine3, DVec3, Vec2, Vec3};
use halflight_kernel::math::affine::{transform_point, transform_vector};
use halflight_kernel::math::{Ray, vec3};
use halflight_kernel::scene::intersect::*;
use halflight_kernel::scene::*;
use proptest::prelude::*;

/// Where a ray from this point meets the one primitive of the scene again.
fn again(scene: &Primitives, ray: &Ray, instance: usize) -> f32 {
    let map = &scene.instances[instance].to_object;
    let (o, d) = (
        transform_point(map, ray.origin),
        transform_vector(map, ray.direction),
    );
    if let Some(q) = scene.quadrics.first() {
        let (o, d) = (
            transform_point(&q.to_object, o),
            transform_vector(&q.to_object, d),
        );
        intersect_quadric(q.kind, o, d, ray.t_min, ray.t_max)
    } else {
        let p = scene.triangles[0]
            .vertices
            .map(|v| vec3(scene.positions[v as usize]));
        intersect(
            &Ray {
                origin: o,
                direction: d,
                ..*ray
            },
            p,
        )
        .t
    }
}

/// Sizes and places of primitives: small far away, large near the origin, and usual.
fn size_and_place() -> impl Strategy<Value = (f32, Vec3)> + Clone {
    (
        prop_oneof![Just(1e-3f32), Just(1.0), Just(1e3), Just(1e5)],
        prop_oneof![Just(0.0f32), Just(1.0), Just(1e3)],
        point(1.0),
    )
        // Smaller things are not resolved by coordinates of 24 bits.
        .prop_filter("resolved", |(size, distance, _)| *size >= distance * 1e-3)
        .prop_map(|(size, distance, p)| (size, p * distance))
}

/// No direction and no triangle, slivers included, and the offset stays small: 1e-5 of the triangle's size and distance.
#[test]
fn rays_that_leave_triangles_do_not_return() {
    let input = (
        prop::array::uniform3(prop_oneof![4 => point(1.0), 1 => direction()]),
        size_and_place(),
        (0.0f32..1.0, 0.0f32..1.0),
        direction(),
        prop_oneof![Just(1.0f32), Just(1e-2), Just(1e-5)],
        prop::option::of(map()),
    );
    runner(30_000)
        .run(&input, |(p, (size, place), b, direction, grazing, map)| {
            let p = p.map(|p| p * size + place);
            prop_assume!((p[1] - p[0]).cross(p[2] - p[0]).length() > 0.0);
            let b = Vec2::new(1.0 - b.0.sqrt(), b.1 * b.0.sqrt());
            let scene = Primitives::triangle(p, None, None, 0, map.unwrap_or_default());
            let instance = map.is_some() as u32;
            let hit = Hit {
                t: 1.0,
                b1: b.x,
                b2: b.y,
                primitive: 0,
                instance,
            };
            let s = surface_at(&scene.tables(), &Ray::new(Vec3::ZERO, Vec3::Z), &hit);
            let n = s.geometric_normal;
            let along = direction - n * n.dot(direction) * (1.0 - grazing);
            let ray = s.spawn(along.try_normalize().unwrap_or(n));
            let t = again(&scene, &ray, instance as usize);
            assert_eq!(t, f32::MAX, "returns after {t:e}: {s:?} along {along}");
            let reach = p.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
            assert!(
                s.position_error < 1e-3 * (reach + s.position.length()),
                "{s:?}"
            );
            Ok(())
        })
        .unwrap();
}

/// From convex sides never, from concave sides only across the inside.
#[test]
fn rays_that_leave_quadrics_do_not_return() {
    let input = (
        0u32..3,
        map(),
        size_and_place(),
        (0.01f32..0.99, 0.01f32..0.99),
        direction(),
        prop_oneof![Just(1.0f32), Just(1e-2), Just(1e-5)],
        prop::option::of(map()),
    );
    runner(30_000)
        .run(
            &input,
            |(kind, inner, (size, place), uv, direction, grazing, outer)| {
                let inner = DAffine3::from_scale_rotation_translation(
                    DVec3::splat(size.into()),
                    glam::DQuat::IDENTITY,
                    place.as_dvec3(),
                ) * DAffine3 {
                    translation: DVec3::ZERO,
                    ..inner
                };
                let scene = Primitives::quadric(kind, 0, inner, outer.unwrap_or_default());
                let instance = outer.is_some() as u32;
                let to_world = map_of(&scene.instances[instance as usize].to_world)
                    * map_of(&scene.quadrics[0].to_world);
                let target = to_world
                    .transform_point3(canonical(kind, Vec2::new(uv.0, uv.1).as_dvec2()).0)
                    .as_vec3();
                let reach = (size + place.length()) * 10.0;
                let ray = Ray::new(target - direction * reach, direction);
                let hit = Hit {
                    t: reach,
                    b1: 0.0,
                    b2: 0.0,
                    primitive: 0,
                    instance,
                };
                let s = surface_at(&scene.tables(), &ray, &hit);
                let n = s.geometric_normal;
                let along = (direction - n * n.dot(direction) * (1.0 - grazing)).normalize();
                let is_outward = n.dot(along) > 0.0;
                let t = again(&scene, &s.spawn(along), instance as usize);
                if is_outward || kind == quadric_kind::DISK {
                    assert_eq!(t, f32::MAX, "returns after {t:e}: {s:?} along {along}");
                } else if t < f32::MAX {
                    // In object space the chord from p along d is -2 p.d / d.d long (azimuthal parts for the cylinder).
                    let object = to_world.inverse();
                    let mut p = object.transform_point3(s.position.as_dvec3());
                    let mut d = object.transform_vector3(along.as_dvec3());
                    if kind == quadric_kind::CYLINDER {
                        (p.z, d.z) = (0.0, 0.0);
                    }
                    let chord = -2.0 * p.dot(d) / d.dot(d);
                    // The offset is a first-order step: small against the least radius of curvature's scale.
                    let m = object.matrix3;
                    let inverse = m.x_axis.length() + m.y_axis.length() + m.z_axis.length();
                    prop_assume!(f64::from(s.position_error) * inverse < 0.1);
                    assert!(
                        f64::from(t) > 0.5 * chord,
                        "returns after {t:e} of {chord:e}: {s:?}"
                    );
                }
                let size = s.position.length() + reach;
                assert!(s.position_error < 1e-4 * size, "{s:?}");
                Ok(())
            },
        )
        .unwrap();
}

/// The simple offset serves unit-sized geometry anywhere, and moves by at most its documented distance.
#[test]
fn simple_offset() {
    let input = (
        prop::array::uniform3(point(1.0)),
        prop_oneof![Just(0.0f32), Just(1.0), Just(1e3)],
        point(1.0),
        direction(),
    );
    runner(10_000)
        .run(&input, |(p, distance, place, direction)| {
            let p = p.map(|p| p + place * distance);
            let cross = (p[1] - p[0]).cross(p[2] - p[0]);
            prop_assume!(cross.length() > 0.05);
            let n = cross.normalize();
            let position = (p[0] + p[1] + p[2]) / 3.0;
            let origin = offset_origin(position, n, direction);
            assert_eq!(intersect(&Ray::new(origin, direction), p).t, f32::MAX);
            let bound = (position.abs().max_element() + 1.0 / 32.0) * ORIGIN_OFFSET;
            assert!((origin - position).length() < 1.2 * bound);
            Ok(())
        })
        .unwrap();
}

#[test]
fn segments_end_before_their_targets() {
    let r = segment(Vec3::ZERO, Vec3::new(0.0, 3.0, 4.0));
    assert!((r.direction - Vec3::new(0.0, 0.6, 0.8)).length() < 1e-6);
    assert!(r.t_max < 5.0 && r.t_max > 4.999);
    assert!(!is_traceable(&segment(Vec3::ONE, Vec3::ONE)));
    let bad = [f32::NAN, f32::INFINITY];
    for x in bad {
        assert!(!is_traceable(&Ray::new(Vec3::splat(x), Vec3::X)));
        assert!(!is_traceable(&Ray::new(Vec3::ZERO, Vec3::new(x, 0.0, 0.0))));
    }
    assert!(!is_traceable(&Ray::new(Vec3::ZERO, Vec3::ZERO)));
}
