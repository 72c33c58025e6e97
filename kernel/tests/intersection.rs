//! Intersections against f64, watertight edges, and rays that leave surfaces without meeting them again.

#[path = "common/primitives.rs"]
mod primitives;

use glam::{DAffine3, DMat3, DVec3, Vec2, Vec3};
use halflight_kernel::math::affine::{transform_point, transform_vector};
use halflight_kernel::math::{Ray, vec3};
use halflight_kernel::scene::intersect::*;
use halflight_kernel::scene::*;
use primitives::{Primitives, canonical, direction, map, map_of, point, runner};
use proptest::prelude::*;

/// t and barycentric weights where the ray's line meets the triangle's plane, in f64.
fn exact_triangle(ray: &Ray, p: [Vec3; 3]) -> [f64; 3] {
    let p = p.map(|p| p.as_dvec3());
    let (o, d) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
    let x = DMat3::from_cols(p[1] - p[0], p[2] - p[0], -d).inverse() * (o - p[0]);
    [x.z, x.x, x.y]
}

fn intersect(ray: &Ray, p: [Vec3; 3]) -> TriangleHit {
    let sheared = ShearedRay::new(ray.origin, ray.direction);
    intersect_triangle(&sheared, p[0], p[1], p[2], ray.t_min, ray.t_max)
}

/// Hits and misses agree away from the edges, t to 2e-5 of the scene's size over the cosine.
#[test]
fn triangles_agree_with_double_precision() {
    let input = (prop::array::uniform3(point(2.0)), point(4.0), direction());
    runner(20_000)
        .run(&input, |(p, origin, direction)| {
            let ray = Ray::new(origin, direction);
            let cross = (p[1] - p[0]).cross(p[2] - p[0]);
            let cosine = cross.dot(direction).abs() / cross.length();
            prop_assume!(cross.length() > 0.05 && cosine > 0.02);
            let [t, b1, b2] = exact_triangle(&ray, p);
            let inside = b1.min(b2).min(1.0 - b1 - b2);
            let hit = intersect(&ray, p);
            if hit.t < f32::MAX {
                assert!(inside > -1e-3 && t > -1e-3);
                assert!((f64::from(hit.t) - t).abs() < 2e-5 / f64::from(cosine));
                let b = (f64::from(hit.b1) - b1).abs() + (f64::from(hit.b2) - b2).abs();
                assert!(b < 2e-5 / f64::from(cosine * cross.length()), "{b}");
                assert!(hit.b1 >= 0.0 && hit.b2 >= 0.0 && hit.b1 + hit.b2 <= 1.0 + 1e-6);
                let ends = Ray {
                    t_max: hit.t,
                    ..ray
                };
                assert_eq!(intersect(&ends, p).t, f32::MAX, "the interval is open");
                let starts = Ray {
                    t_min: hit.t,
                    ..ray
                };
                assert_eq!(intersect(&starts, p).t, f32::MAX, "the interval is open");
            } else {
                assert!(inside < 1e-3 || t < 1e-3, "missed at {t} {b1} {b2}");
            }
            Ok(())
        })
        .unwrap();
}

/// Roots on the canonical surface in f64, in order, that satisfy its bounds by `margin`.
fn exact_quadric(kind: u32, o: DVec3, d: DVec3, margin: f64) -> Vec<f64> {
    let flat = |v: DVec3| DVec3::new(v.x, v.y, 0.0);
    let (a, b, c) = match kind {
        quadric_kind::SPHERE => (d.dot(d), o.dot(d), o.dot(o) - 1.0),
        quadric_kind::DISK => {
            let t = -o.z / d.z;
            let inside = flat(o + d * t).length() < 1.0 + margin;
            return if inside { vec![t] } else { vec![] };
        }
        _ => (
            flat(d).dot(flat(d)),
            flat(o).dot(flat(d)),
            flat(o).dot(flat(o)) - 1.0,
        ),
    };
    // A line is closer than the radius plus the margin where the discriminant over a exceeds -2 margin.
    let discriminant = b * b - a * c;
    if discriminant / a < -2.0 * margin {
        return vec![];
    }
    let root = discriminant.max(0.0).sqrt();
    let mut roots = vec![(-b - root) / a, (-b + root) / a];
    if kind == quadric_kind::CYLINDER {
        roots.retain(|t| (-margin..=1.0 + margin).contains(&(o.z + t * d.z)));
    }
    roots
}

/// Near, far and inside, under affine maps: any hit is a root, and a root well inside the bounds is hit.
#[test]
fn quadrics_agree_with_double_precision() {
    let distance = prop_oneof![Just(1.0f32), Just(30.0), Just(1000.0)];
    let input = (
        0u32..3,
        map(),
        point(1.0),
        direction(),
        distance,
        0.1f32..10.0,
    );
    runner(20_000)
        .run(&input, |(kind, map, target, direction, distance, scale)| {
            let scene = Primitives::quadric(kind, 0, map, DAffine3::IDENTITY);
            let to_object = &scene.quadrics[0].to_object;
            let origin =
                transform_point(&scene.quadrics[0].to_world, target) - direction * distance;
            let (o, d) = (
                transform_point(to_object, origin),
                transform_vector(to_object, direction * scale),
            );
            let t = intersect_quadric(kind, o, d, 0.0, f32::MAX);
            let (od, dd) = (o.as_dvec3(), d.as_dvec3());
            // Rounding of o + t d in object space is what decides at the silhouette.
            let margin = 1e-5 * (1.0 + od.length());
            let roots = exact_quadric(kind, od, dd, margin);
            if t < f32::MAX {
                let p = od + dd * f64::from(t);
                let off = match kind {
                    quadric_kind::SPHERE => p.length() - 1.0,
                    quadric_kind::DISK => p.z,
                    _ => p.truncate().length() - 1.0,
                };
                assert!(
                    off.abs() < margin,
                    "off the surface by {off:e} at distance {distance}"
                );
                assert!(!roots.is_empty());
            }
            let sure = exact_quadric(kind, od, dd, -margin);
            let step = margin / dd.length();
            if let Some(first) = sure.iter().find(|t| **t > 10.0 * step) {
                assert!(t < f32::MAX, "missed {first}");
                assert!(
                    f64::from(t) <= first + 1e-3 * (1.0 + first.abs()),
                    "{t} instead of {first}"
                );
            }
            Ok(())
        })
        .unwrap();
}

/// A closed surface of 1280 triangles with rough radii, its vertices shared by index.
fn closed_mesh(seed: u32, center: Vec3) -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let mut points: Vec<Vec3> = vec![
        Vec3::X,
        Vec3::Y,
        Vec3::Z,
        Vec3::NEG_X,
        Vec3::NEG_Y,
        Vec3::NEG_Z,
    ];
    let mut faces = vec![];
    for (x, y, z) in [(0, 1, 2), (1, 3, 2), (3, 4, 2), (4, 0, 2)] {
        faces.push([x, y, z]);
        faces.push([y, x, 5]);
    }
    for _ in 0..3 {
        let mut middle = std::collections::HashMap::new();
        let mut split = vec![];
        for [a, b, c] in faces {
            let mut half = |i: usize, j: usize| {
                *middle.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    points.push((points[i] + points[j]).normalize());
                    points.len() - 1
                })
            };
            let (ab, bc, ca) = (half(a, b), half(b, c), half(c, a));
            split.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        faces = split;
    }
    for (i, p) in points.iter_mut().enumerate() {
        let hash = (i as u32 ^ seed).wrapping_mul(0x9e37_79b9) >> 16;
        *p = *p * (1.0 + hash as f32 / 65536.0) + center;
    }
    (points, faces)
}

/// From inside a closed mesh, rays at vertices and along edges always hit something.
#[test]
fn edges_and_vertices_are_watertight() {
    let mut rays = 0;
    for seed in 0..4 {
        let center = Vec3::new(0.3, -7.0, 2.0) * seed as f32 * 10.0;
        let (points, faces) = closed_mesh(seed, center);
        let origin = center + Vec3::new(0.1, 0.2, -0.15) * seed as f32;
        for (i, face) in faces.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (points[face[k]], points[face[(k + 1) % 3]]);
                let w = (i % 7) as f32 / 6.0;
                let direction = a + (b - a) * w - origin;
                let direction = match i % 3 {
                    0 => direction,
                    1 => direction.normalize(),
                    _ => direction * 1e-3,
                };
                let ray = Ray::new(origin, direction);
                let is_hit = faces
                    .iter()
                    .any(|f| intersect(&ray, f.map(|i| points[i])).t < f32::MAX);
                assert!(is_hit, "leak along {direction} at {a} {b} weight {w}");
                rays += 1;
            }
        }
    }
    assert!(rays > 6000);
}

/// Triangles so small that their vertices' products with the distance to the ray round to the same number.
#[test]
fn small_triangles_are_not_hit_from_afar() {
    let input = (prop::array::uniform3(point(1e-7)), point(1.0), direction());
    runner(20_000)
        .run(&input, |(p, origin, direction)| {
            prop_assume!(origin.cross(direction).length() > 1e-3);
            assert_eq!(intersect(&Ray::new(origin, direction), p).t, f32::MAX);
            Ok(())
        })
        .unwrap();
}

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
