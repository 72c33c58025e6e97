//! Scenes of a few primitives, and their geometry in f64.

// Each test file uses its part.
#![allow(dead_code)]

#[allow(clippy::duplicate_mod)] // Tests take this file with or without the others that need it.
#[path = "empty_tables.rs"]
mod empty_tables;

use bytemuck::Zeroable;
use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, Vec3};
use halflight_kernel::scene::*;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Owned geometry of a test scene.
#[derive(Clone, Debug, Default)]
pub struct Primitives {
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub uvs: Vec<[f32; 2]>,
    pub triangles: Vec<Triangle>,
    pub quadrics: Vec<Quadric>,
    pub shapes: Vec<Shape>,
    pub instances: Vec<Instance>,
}

impl Primitives {
    /// The tables that the kernel reads.
    pub fn tables(&self) -> Tables<'_> {
        Tables {
            positions: &self.positions,
            normals: &self.normals,
            uvs: &self.uvs,
            triangles: &self.triangles,
            quadrics: &self.quadrics,
            shapes: &self.shapes,
            instances: &self.instances,
            ..empty_tables::empty_tables()
        }
    }

    /// One triangle, placed by the second instance.
    pub fn triangle(
        positions: [Vec3; 3],
        normals: Option<[Vec3; 3]>,
        uvs: Option<[[f32; 2]; 3]>,
        flags: u32,
        map: DAffine3,
    ) -> Primitives {
        let mut p = Primitives {
            positions: positions.map(|p| p.to_array()).to_vec(),
            triangles: vec![Triangle {
                vertices: [0, 1, 2],
                shape: 0,
            }],
            ..Primitives::default()
        };
        if let Some(normals) = normals {
            p.normals = normals.map(|n| n.to_array()).to_vec();
        }
        if let Some(uvs) = uvs {
            p.uvs = uvs.to_vec();
        }
        p.shapes = vec![Shape {
            flags,
            normal_offset: if normals.is_some() { 0 } else { NONE },
            uv_offset: if uvs.is_some() { 0 } else { NONE },
            ..Shape::zeroed()
        }];
        p.instances = vec![instance(DAffine3::IDENTITY), instance(map)];
        p
    }

    /// One quadric under `inner`, placed by the second instance under `outer`.
    pub fn quadric(kind: u32, flags: u32, inner: DAffine3, outer: DAffine3) -> Primitives {
        Primitives {
            quadrics: vec![Quadric {
                to_world: rows(inner),
                to_object: rows(inner.inverse()),
                kind,
                shape: 0,
            }],
            shapes: vec![Shape {
                flags,
                normal_offset: NONE,
                uv_offset: NONE,
                ..Shape::zeroed()
            }],
            instances: vec![instance(DAffine3::IDENTITY), instance(outer)],
            ..Primitives::default()
        }
    }
}

fn instance(map: DAffine3) -> Instance {
    Instance {
        to_world: rows(map),
        to_object: rows(map.inverse()),
        root: 0,
        group: 1,
    }
}

/// A map as three rows of four.
pub fn rows(m: DAffine3) -> [f32; 12] {
    let (r, t) = (m.matrix3, m.translation);
    let mut rows = [0.0; 12];
    for i in 0..3 {
        for j in 0..3 {
            rows[4 * i + j] = r.col(j)[i] as f32;
        }
        rows[4 * i + 3] = t[i] as f32;
    }
    rows
}

/// The map that these rows stand for exactly.
pub fn map_of(rows: &[f32; 12]) -> DAffine3 {
    let r = rows.map(f64::from);
    DAffine3 {
        matrix3: DMat3::from_cols(
            DVec3::new(r[0], r[4], r[8]),
            DVec3::new(r[1], r[5], r[9]),
            DVec3::new(r[2], r[6], r[10]),
        ),
        translation: DVec3::new(r[3], r[7], r[11]),
    }
}

/// Position and normal of a canonical quadric.
pub fn canonical(kind: u32, uv: DVec2) -> (DVec3, DVec3) {
    use std::f64::consts::{PI, TAU};
    match kind {
        quadric_kind::SPHERE => {
            let (phi, theta) = (TAU * uv.x, PI * uv.y);
            let p = DVec3::new(
                theta.sin() * phi.cos(),
                theta.sin() * phi.sin(),
                theta.cos(),
            );
            (p, p)
        }
        quadric_kind::DISK => {
            let phi = TAU * uv.y;
            (DVec3::new(phi.cos(), phi.sin(), 0.0) * uv.x, DVec3::Z)
        }
        _ => {
            let phi = TAU * uv.x;
            let n = DVec3::new(phi.cos(), phi.sin(), 0.0);
            (n + DVec3::Z * uv.y, n)
        }
    }
}

/// Position and unit normal under a map.
pub fn placed(map: DAffine3, (p, n): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let n = map.matrix3.inverse().transpose() * n;
    (map.transform_point3(p), n.normalize())
}

/// Points of a cube.
pub fn point(scale: f32) -> impl Strategy<Value = Vec3> + Clone {
    prop::array::uniform3(-1.0f32..1.0).prop_map(move |p| Vec3::from_array(p) * scale)
}

/// Directions, a third of them in planes or along axes.
pub fn direction() -> impl Strategy<Value = Vec3> + Clone {
    (point(1.0), 0u32..12).prop_map(|(mut d, zeros)| {
        for k in 0..3 {
            if zeros & 8 == 0 && zeros & (1 << k) != 0 {
                d[k] = 0.0;
            }
        }
        d.try_normalize().unwrap_or(Vec3::Z)
    })
}

/// Invertible maps: rotation, stretch by 0.2 to 3 with any signs, shear, translation.
pub fn map() -> impl Strategy<Value = DAffine3> + Clone {
    (
        point(1.0),
        0.0f64..6.3,
        prop::array::uniform3(0.2f64..3.0),
        prop::array::uniform3(any::<bool>()),
        -0.5f64..0.5,
        point(4.0),
    )
        .prop_map(|(axis, angle, stretch, mirror, shear, offset)| {
            let axis = axis.as_dvec3().try_normalize().unwrap_or(DVec3::X);
            let signs = DVec3::from_array(mirror.map(|m| if m { -1.0 } else { 1.0 }));
            let shear = DMat3::from_cols(DVec3::X, DVec3::new(shear, 1.0, 0.0), DVec3::Z);
            DAffine3 {
                matrix3: DMat3::from_quat(DQuat::from_axis_angle(axis, angle))
                    * DMat3::from_diagonal(DVec3::from_array(stretch) * signs)
                    * shear,
                translation: offset.as_dvec3(),
            }
        })
}

/// A deterministic runner.
pub fn runner(cases: u32) -> TestRunner {
    TestRunner::new_with_rng(
        Config {
            cases,
            failure_persistence: None,
            max_global_rejects: 1_000_000,
            max_local_rejects: 10_000_000,
            ..Config::default()
        },
        TestRng::deterministic_rng(RngAlgorithm::ChaCha),
    )
}
