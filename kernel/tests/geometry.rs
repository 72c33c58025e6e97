//! Surface points: every derivative against central differences in f64, orientation against Mitsuba 3, degenerate input.

#[path = "common/primitives.rs"]
mod primitives;

use glam::{DAffine3, DVec2, DVec3, Vec2, Vec3};
use halflight_kernel::math::Ray;
use halflight_kernel::scene::*;
use primitives::{Primitives, canonical, direction, map, map_of, placed, point, runner};
use proptest::prelude::*;

/// Central differences of a position and a unit normal in u and v: dp/du, dp/dv, dn/du, dn/dv.
fn differences(f: impl Fn(DVec2) -> (DVec3, DVec3), uv: DVec2) -> [DVec3; 4] {
    let h = 1e-5;
    let along = |d: DVec2| {
        let ((p1, n1), (p0, n0)) = (f(uv + d * h), f(uv - d * h));
        ((p1 - p0) / (2.0 * h), (n1 - n0) / (2.0 * h))
    };
    let ((pu, nu), (pv, nv)) = (along(DVec2::X), along(DVec2::Y));
    [pu, pv, nu, nv]
}

fn assert_close(what: &str, found: Vec3, expected: DVec3, scale: f64, tolerance: f64) {
    let error = (found.as_dvec3() - expected).length();
    assert!(
        error <= tolerance * scale,
        "{what}: {found} instead of {expected}, off by {error:e} at scale {scale:e}"
    );
}

/// The record of a point against a position and normal as functions of uv.
fn check(s: &SurfacePoint, f: impl Fn(DVec2) -> (DVec3, DVec3), tolerance: f64) {
    let uv = s.uv.as_dvec2();
    let (p, n) = f(uv);
    let d = differences(&f, uv);
    // The rounding of uv moves the reference by the tangents' length.
    let tangents = d[0].length() + d[1].length();
    assert_close("position", s.position, p, 1.0 + p.length() + tangents, 3e-6);
    assert_close("normal", s.frame.n, n, 1.0, tolerance);
    assert_close("dp/du", s.dp_du, d[0], tangents, tolerance);
    assert_close("dp/dv", s.dp_dv, d[1], tangents, tolerance);
    // Where the normal does not vary, the rounding of the tangents' scale is what remains.
    let normals = d[2].length() + d[3].length() + 0.1;
    assert_close("dn/du", s.dn_du, d[2], normals, tolerance);
    assert_close("dn/dv", s.dn_dv, d[3], normals, tolerance);
    check_frame(s);
}

/// Orthonormal and right-handed, s along dp/du.
fn check_frame(s: &SurfacePoint) {
    let f = &s.frame;
    for (a, b, expected) in [
        (f.s, f.s, 1.0),
        (f.t, f.t, 1.0),
        (f.n, f.n, 1.0),
        (f.s, f.t, 0.0),
        (f.s, f.n, 0.0),
        (f.t, f.n, 0.0),
    ] {
        assert!((a.dot(b) - expected).abs() < 2e-5, "{f:?}");
    }
    assert!(f.s.cross(f.t).dot(f.n) > 0.999, "{f:?}");
    let tangent = s.dp_du - f.n * f.n.dot(s.dp_du);
    if tangent.length() > 1e-2 * s.dp_du.length() && s.dp_du.length() > 1e-2 {
        assert!(f.s.dot(tangent) > 0.999 * tangent.length(), "{s:?}");
    }
    assert!((s.geometric_normal.length() - 1.0).abs() < 1e-5);
    assert!(s.position_error > 0.0 && s.position_error < 1e-3 * (1.0 + s.position.length()));
}

fn hit(t: f32, b: Vec2, primitive: u32, instance: u32) -> Hit {
    Hit {
        t,
        b1: b.x,
        b2: b.y,
        primitive,
        instance,
    }
}

/// Triangles that are not slivers, in position and in uv, with normals that do not cancel.
#[test]
fn triangle_derivatives() {
    let uvs = prop::array::uniform3(prop::array::uniform2(-2.0f32..2.0));
    let input = (
        prop::array::uniform3(point(2.0)),
        prop::option::of(prop::array::uniform3(direction())),
        prop::option::of(uvs),
        (0.05f32..0.6, 0.05f32..0.35),
        any::<bool>(),
        prop::option::of(map()),
    );
    runner(3000)
        .run(&input, |(p, normals, uvs, b, flip, map)| {
            let (e1, e2) = (p[1] - p[0], p[2] - p[0]);
            let shape = e1.cross(e2).length() / (e1.length() * e2.length());
            prop_assume!(shape > 0.1 && e1.length().min(e2.length()) > 0.1);
            let uv = uvs.unwrap_or([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
            let uv = uv.map(|uv| DVec2::new(uv[0].into(), uv[1].into()));
            let (d1, d2) = (uv[1] - uv[0], uv[2] - uv[0]);
            let determinant = d1.perp_dot(d2);
            prop_assume!(determinant.abs() > 0.1 * d1.length() * d2.length());
            prop_assume!(d1.length().min(d2.length()) > 0.1);
            let weights = [1.0 - b.0 - b.1, b.0, b.1];
            if let Some(n) = normals {
                let sum = n[0] * weights[0] + n[1] * weights[1] + n[2] * weights[2];
                prop_assume!(sum.length() > 0.3);
            }
            let flags = if flip { shape_flag::FLIP_NORMALS } else { 0 };
            let scene = Primitives::triangle(p, normals, uvs, flags, map.unwrap_or_default());
            let tables = scene.tables();
            let ray = Ray::new(Vec3::ZERO, Vec3::Z);
            let instance = map.is_some() as u32;
            let s = surface_at(&tables, &ray, &hit(1.0, Vec2::new(b.0, b.1), 0, instance));
            let to_world = map_of(&scene.instances[instance as usize].to_world);
            let (q, sign) = (p.map(|p| p.as_dvec3()), if flip { -1.0 } else { 1.0 });
            let normals = normals.map_or([(q[1] - q[0]).cross(q[2] - q[0]); 3], |n| {
                n.map(|n| n.as_dvec3())
            });
            let surface = |at: DVec2| {
                let d = at - uv[0];
                let (b1, b2) = (d.perp_dot(d2) / determinant, d1.perp_dot(d) / determinant);
                let mix = |v: [DVec3; 3]| v[0] * (1.0 - b1 - b2) + v[1] * b1 + v[2] * b2;
                placed(to_world, (mix(q), mix(normals) * sign))
            };
            check(&s, surface, 1e-4);
            Ok(())
        })
        .unwrap();
}

/// Any affine map inside any instance, away from the poles and the centre, where uv is singular.
#[test]
fn quadric_derivatives() {
    let input = (
        0u32..3,
        map(),
        prop::option::of(map()),
        0.02f64..0.98,
        0.02f64..0.98,
        any::<bool>(),
    );
    runner(3000)
        .run(&input, |(kind, inner, outer, u, v, flip)| {
            let flags = if flip { shape_flag::FLIP_NORMALS } else { 0 };
            let scene = Primitives::quadric(kind, flags, inner, outer.unwrap_or_default());
            let tables = scene.tables();
            let instance = outer.is_some() as u32;
            let inner = map_of(&scene.quadrics[0].to_world);
            let outer = map_of(&scene.instances[instance as usize].to_world);
            let sign = if flip { -1.0 } else { 1.0 };
            let surface = |uv: DVec2| {
                let (p, n) = canonical(kind, uv);
                placed(outer, placed(inner, (p, n * sign)))
            };
            // A ray that meets the point from somewhere: what it cannot know exactly it must find again.
            let uv = DVec2::new(u, v);
            let target = surface(uv).0.as_vec3();
            let direction = Vec3::new(0.3, 0.5, -0.8).normalize();
            let ray = Ray::new(target - direction * 2.0, direction);
            let s = surface_at(&tables, &ray, &hit(2.0, Vec2::ZERO, 0, instance));
            assert!((s.uv.as_dvec2() - uv).length() < 1e-4, "{} {uv}", s.uv);
            check(&s, surface, 2e-4);
            if instance == 0 {
                let s = surface_at_primitive(&tables, 0, u as f32, v as f32);
                assert_eq!(s.uv, uv.as_vec2());
                check(&s, surface, 2e-4);
            }
            Ok(())
        })
        .unwrap();
}

/// The convention of Mitsuba 3.9 on a triangle in z = 0 seen from +z (values read off `mi.SurfaceInteraction3f`).
#[test]
fn orientation_of_triangles() {
    let p = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0];
    let up = [Vec3::Z, Vec3::new(0.3, 0.0, 0.9), Vec3::new(0.0, 0.4, 0.8)];
    let down = up.map(|n| Vec3::new(n.x, n.y, -n.z));
    let at = |normals, flags, map: DVec3, instance| {
        let scene = Primitives::triangle(p, normals, None, flags, DAffine3::from_scale(map));
        let h = hit(1.0, Vec2::new(0.25, 0.2), 0, instance);
        surface_at(&scene.tables(), &Ray::new(Vec3::ZERO, Vec3::Z), &h)
    };
    let one = DVec3::ONE;
    let close = |a: Vec3, b: [f32; 3]| assert!((a - Vec3::from_array(b)).length() < 1e-5, "{a}");
    let s = at(Some(up), 0, one, 0);
    close(s.geometric_normal, [0.0, 0.0, 1.0]);
    close(s.frame.n, [0.079_667_9, 0.084_979_1, 0.993_193]);
    close(s.frame.s, [0.996_821, -0.006_791_69, -0.079_377_8]);
    close(s.frame.t, [0.0, 0.996_36, -0.085_25]);
    close(s.dn_du, [0.325_054, 0.006_807_92, -0.026_656_6]);
    assert_eq!(s.uv, Vec2::new(0.25, 0.2));
    assert_eq!(s.position, Vec3::new(0.5, 0.6, 0.0));
    // Normals that oppose the winding are not turned.
    let s = at(Some(down), 0, one, 0);
    close(s.geometric_normal, [0.0, 0.0, 1.0]);
    close(s.frame.n, [0.079_667_9, 0.084_979_1, -0.993_193]);
    close(s.frame.t, [0.0, -0.996_36, -0.085_25]);
    // FLIP_NORMALS turns both.
    let s = at(Some(up), shape_flag::FLIP_NORMALS, one, 0);
    close(s.geometric_normal, [0.0, 0.0, -1.0]);
    close(s.frame.n, [-0.079_667_9, -0.084_979_1, -0.993_193]);
    // A mirrored instance keeps its outside, unlike a mesh whose vertices are mirrored.
    let s = at(None, 0, DVec3::new(-1.0, 1.0, 1.0), 1);
    close(s.geometric_normal, [0.0, 0.0, 1.0]);
    close(s.frame.s, [-1.0, 0.0, 0.0]);
    close(s.frame.t, [0.0, -1.0, 0.0]);
    let s = at(Some(up), 0, DVec3::new(1.0, 1.0, -1.0), 1);
    close(s.geometric_normal, [0.0, 0.0, -1.0]);
    close(s.frame.n, [0.079_667_9, 0.084_979_1, -0.993_193]);
    // FACE_NORMALS ignores the vertex normals.
    let s = at(Some(down), shape_flag::FACE_NORMALS, one, 0);
    close(s.frame.n, [0.0, 0.0, 1.0]);
    assert_eq!(s.dn_du, Vec3::ZERO);
}

/// uv, tangents and normals of Mitsuba 3.9's sphere, disk and cylinder where the same ray meets them.
#[test]
fn parametrisation_of_quadrics() {
    let identity = DAffine3::IDENTITY;
    let direction = Vec3::new(0.02, -1.0, -0.6).normalize();
    let ray = Ray::new(Vec3::new(0.3, 4.0, 2.5), direction);
    let at = |kind, t| {
        let scene = Primitives::quadric(kind, 0, identity, identity);
        surface_at(&scene.tables(), &ray, &hit(t, Vec2::ZERO, 0, 0))
    };
    let close = |a: Vec3, b: [f32; 3]| assert!((a - Vec3::from_array(b)).length() < 2e-5, "{a}");
    let s = at(quadric_kind::SPHERE, 3.789_711_7);
    assert!((s.uv - Vec2::new(0.177_987, 0.314_439)).length() < 1e-5);
    close(s.geometric_normal, [0.364_983, 0.750_827, 0.550_496]);
    close(s.dp_du, [-4.717_58, 2.293_26, 0.0]);
    close(s.dp_dv, [0.756_093, 1.555_4, -2.622_72]);
    close(s.frame.t, [-0.240_672, -0.495_099, 0.834_838]);
    let s = at(quadric_kind::DISK, 4.859_841_3);
    assert!((s.uv - Vec2::new(0.417_998, 0.934_726)).length() < 1e-5);
    close(s.dp_du, [0.917_07, -0.398_727, 0.0]);
    close(s.dp_dv, [1.047_21, 2.408_55, 0.0]);
    let s = at(quadric_kind::CYLINDER, 3.577_896_8);
    assert!((s.uv - Vec2::new(0.191_158, 0.659_458)).length() < 1e-5);
    close(s.geometric_normal, [0.361_351, 0.932_43, 0.0]);
    close(s.dp_du, [-5.858_63, 2.270_44, 0.0]);
    close(s.dn_du, [-5.858_63, 2.270_44, 0.0]);
    close(s.dp_dv, [0.0, 0.0, 1.0]);
}

/// Without an inverse of the uv map: orthonormal tangents, and normals' derivatives along them.
#[test]
fn degenerate_uv() {
    let p = [Vec3::ZERO, Vec3::X * 2.0, Vec3::Y * 3.0];
    let n = [Vec3::Z, Vec3::new(0.3, 0.0, 0.9), Vec3::new(0.0, 0.4, 0.8)];
    let scene = Primitives::triangle(p, Some(n), Some([[0.5; 2]; 3]), 0, DAffine3::IDENTITY);
    let s = surface_at_primitive(&scene.tables(), 0, 0.25, 0.2);
    assert_eq!(s.uv, Vec2::splat(0.5));
    assert!((s.dp_du - Vec3::X).length() < 1e-6 && (s.dp_dv - Vec3::Y).length() < 1e-6);
    // Along x, b1 grows by 1/2 per unit length.
    let scene = Primitives::triangle(p, Some(n), None, 0, DAffine3::IDENTITY);
    let by_weights = surface_at_primitive(&scene.tables(), 0, 0.25, 0.2);
    assert!((s.dn_du - by_weights.dn_du / 2.0).length() < 1e-6);
    assert!((s.dn_dv - by_weights.dn_dv / 3.0).length() < 1e-6);
}

/// Whatever the vertices and normals: unit normals, a frame, finite derivatives.
#[test]
fn degenerate_input_stays_finite() {
    let value = prop_oneof![
        4 => -2.0f32..2.0,
        2 => Just(0.0f32),
        1 => Just(1e-30f32),
        1 => Just(1e15f32),
    ];
    let wild = prop_oneof![4 => value.clone(), 1 => Just(f32::NAN), 1 => Just(f32::INFINITY)];
    let input = (
        prop::array::uniform9(value.clone()),
        prop::array::uniform9(wild),
        prop::array::uniform6(value),
        prop::option::of(map()),
    );
    runner(5000)
        .run(&input, |(p, n, uv, map)| {
            let of = |v: &[f32; 9]| [0, 3, 6].map(|i| Vec3::new(v[i], v[i + 1], v[i + 2]));
            let uvs = [0, 2, 4].map(|i| [uv[i], uv[i + 1]]);
            let scene =
                Primitives::triangle(of(&p), Some(of(&n)), Some(uvs), 0, map.unwrap_or_default());
            let h = hit(1.0, Vec2::new(0.3, 0.3), 0, map.is_some() as u32);
            let s = surface_at(&scene.tables(), &Ray::new(Vec3::ZERO, Vec3::Z), &h);
            for v in [
                s.position,
                s.geometric_normal,
                s.frame.s,
                s.frame.t,
                s.frame.n,
                s.dp_du,
                s.dp_dv,
                s.dn_du,
                s.dn_dv,
            ] {
                assert!(v.is_finite(), "{s:?}");
            }
            assert!((s.geometric_normal.length() - 1.0).abs() < 1e-5);
            assert!((s.frame.n.length() - 1.0).abs() < 1e-5);
            assert!(s.position_error.is_finite());
            Ok(())
        })
        .unwrap();
}
