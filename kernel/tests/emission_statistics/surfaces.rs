//! Integrals over surfaces by quadrature, independent of the kernel's area elements.

use crate::common::light_scene::Scene;
use crate::common::lit_scenes::turned;
use glam::{Affine3A, DVec3, Mat3A, Vec3};
use halflight_kernel::math::vec3;
use halflight_kernel::scene::surface::detail;
use halflight_kernel::scene::surface::triangle::triangle_point_with;
use halflight_kernel::scene::{SurfacePoint, quadric_kind};
use std::f64::consts::{PI, TAU};

/// A map that shears and squeezes.
pub fn sheared() -> Affine3A {
    let shear = Affine3A::from_mat3(
        Mat3A::from_cols(
            Vec3::new(0.6, 0.2, 0.1).into(),
            Vec3::new(-0.3, 1.1, 0.4).into(),
            Vec3::new(0.2, -0.1, 0.8).into(),
        )
        .into(),
    );
    turned(Vec3::ONE, Vec3::new(1.0, 2.0, 0.5)) * shear
}

/// A canonical point of a quadric by two parameters in [0, 1].
pub type Parametrisation = fn(f64, f64) -> DVec3;

/// The kinds of quadrics.
pub const QUADRICS: [(&str, u32, Parametrisation); 3] = [
    ("sphere", quadric_kind::SPHERE, |a, b| {
        let (theta, phi) = (PI * a, TAU * b);
        DVec3::new(
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
            theta.cos(),
        )
    }),
    ("disk", quadric_kind::DISK, |a, b| {
        DVec3::new(a * (TAU * b).cos(), a * (TAU * b).sin(), 0.0)
    }),
    ("cylinder", quadric_kind::CYLINDER, |a, b| {
        DVec3::new((TAU * b).cos(), (TAU * b).sin(), a)
    }),
];

/// Functions of a position that a wrong density does not leave all alone.
pub fn probes(p: DVec3) -> [f64; 6] {
    [
        1.0,
        p.x,
        p.y,
        p.z,
        (3.0 * p.x + 2.0 * p.y).sin() * (4.0 * p.z).cos(),
        (p.x * p.y * p.z).abs(),
    ]
}

/// Integrals of the probes over the image of a parametrised surface.
pub fn surface_integrals(to_world: Affine3A, at: Parametrisation) -> [f64; 6] {
    let m = to_world.matrix3.to_cols_array_2d();
    let column = |i: usize| DVec3::from_array(m[i].map(f64::from));
    let origin = Vec3::from(to_world.translation).as_dvec3();
    let world = |a: f64, b: f64| {
        let p = at(a, b);
        column(0) * p.x + column(1) * p.y + column(2) * p.z + origin
    };
    const N: usize = 400;
    let h = 1e-5;
    let mut sums = [0.0; 6];
    for i in 0..N {
        for j in 0..N {
            let a = (i as f64 + 0.5) / N as f64;
            let b = (j as f64 + 0.5) / N as f64;
            let along_a = (world(a + h, b) - world(a - h, b)) / (2.0 * h);
            let along_b = (world(a, b + h) - world(a, b - h)) / (2.0 * h);
            let area = along_a.cross(along_b).length() / (N * N) as f64;
            for (sum, probe) in sums.iter_mut().zip(probes(world(a, b))) {
                *sum += probe * area;
            }
        }
    }
    sums
}

/// Sums of a function over the points of the triangles of [`mesh_scene`], times their area.
pub fn over_triangles(scene: &Scene, mut f: impl FnMut(&SurfacePoint, f64)) {
    let tables = scene.tables();
    const N: u32 = 60;
    for primitive in 0..tables.triangles.len() as u32 {
        let [a, b, c] = tables.triangles[primitive as usize]
            .vertices
            .map(|i| vec3(tables.positions[i as usize]).as_dvec3());
        let area = 0.5 * (b - a).cross(c - a).length();
        for i in 0..N {
            for j in 0..2 * (N - i) - 1 {
                // Centroids of the small triangles, upright and upside down.
                let (x, y) = (j / 2, f64::from(i));
                let shift = if j % 2 == 0 { 1.0 / 3.0 } else { 2.0 / 3.0 };
                let b1 = (f64::from(x) + shift) / f64::from(N);
                let b2 = (y + shift) / f64::from(N);
                let point = triangle_point_with::<{ detail::TANGENTS }>(
                    &tables, primitive, b1 as f32, b2 as f32,
                );
                f(&point, area / f64::from(N * N));
            }
        }
    }
}
