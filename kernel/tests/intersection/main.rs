//! Intersections against f64, watertight edges, and rays that leave surfaces ([`leaving`]).

mod leaving;
#[path = "../common/primitives.rs"]
mod primitives;

use glam::{DAffine3, DMat3, DVec3, Vec3};
use halflight_kernel::math::Ray;
use halflight_kernel::math::affine::{transform_point, transform_vector};
use halflight_kernel::scene::intersect::*;
use halflight_kernel::scene::*;
use primitives::{Primitives, direction, map, point, runner};
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
