//! The wide trees, the kernel's binary walk and a search of all primitives find the same hits.

use bytemuck::Zeroable;
use glam::{Affine3A, Mat3A, Quat, Vec3};
use halflight::accel::{Accel, GroupRange};
use halflight_kernel::math::Ray;
use halflight_kernel::math::affine::{IDENTITY, transform_point, transform_vector};
use halflight_kernel::math::vec3;
use halflight_kernel::scene::intersect::{ShearedRay, intersect_quadric, intersect_triangle};
use halflight_kernel::scene::*;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Owned geometry of a test scene.
#[derive(Clone, Debug, Default)]
struct Geometry {
    positions: Vec<[f32; 3]>,
    triangles: Vec<Triangle>,
    quadrics: Vec<Quadric>,
    instances: Vec<Instance>,
    groups: Vec<GroupRange>,
}

impl Geometry {
    fn tables(&self) -> Tables<'_> {
        Tables {
            positions: &self.positions,
            normals: &[],
            uvs: &[],
            triangles: &self.triangles,
            quadrics: &self.quadrics,
            shapes: &[],
            instances: &self.instances,
            materials: &[],
            lobes: &[],
            factors: &[],
            frame_maps: &[],
            textures: &[],
            texels: &[],
            data: &[],
            emitters: &[],
            camera: Camera::zeroed(),
            info: SceneInfo::zeroed(),
        }
    }

    fn triangle(&mut self, points: [Vec3; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(points.map(|p| p.to_array()));
        self.triangles.push(Triangle {
            vertices: [first, first + 1, first + 2],
            shape: 0,
        });
    }

    fn quadric(&mut self, kind: u32, to_world: Affine3A) {
        self.quadrics.push(Quadric {
            to_world: rows(to_world),
            to_object: rows(to_world.inverse()),
            kind,
            shape: 0,
        });
    }

    /// Everything so far from these starts on makes the next group.
    fn close_group(&mut self) {
        let (triangles, quadrics) = self
            .groups
            .last()
            .map_or((0, 0), |g| (g.triangles.end, g.quadrics.end));
        self.groups.push(GroupRange {
            triangles: triangles..self.triangles.len() as u32,
            quadrics: quadrics..self.quadrics.len() as u32,
        });
    }

    fn place(&mut self, group: u32, to_world: Affine3A) {
        self.instances.push(Instance {
            to_world: rows(to_world),
            to_object: rows(to_world.inverse()),
            root: 0,
            group,
        });
    }

    /// The nearest hit by a search of everything, in single precision with the kernel's own intersections.
    fn search(&self, ray: &Ray) -> Hit {
        let tables = self.tables();
        let mut hit = Hit::MISS;
        for (instance, record) in self.instances.iter().enumerate() {
            let group = &self.groups[record.group as usize];
            let origin = transform_point(&record.to_object, ray.origin);
            let direction = transform_vector(&record.to_object, ray.direction);
            let sheared = ShearedRay::new(origin, direction);
            for i in group.triangles.clone() {
                let [a, b, c] = tables.triangles[i as usize]
                    .vertices
                    .map(|v| vec3(tables.positions[v as usize]));
                let t_max = hit.t.min(ray.t_max);
                let found = intersect_triangle(&sheared, a, b, c, ray.t_min, t_max);
                if found.t < t_max {
                    hit = Hit {
                        t: found.t,
                        b1: found.b1,
                        b2: found.b2,
                        primitive: i,
                        instance: instance as u32,
                    };
                }
            }
            for i in group.quadrics.clone() {
                let q = &tables.quadrics[i as usize];
                let t = intersect_quadric(
                    q.kind,
                    transform_point(&q.to_object, origin),
                    transform_vector(&q.to_object, direction),
                    ray.t_min,
                    hit.t.min(ray.t_max),
                );
                if t < hit.t.min(ray.t_max) {
                    hit = Hit {
                        t,
                        b1: 0.0,
                        b2: 0.0,
                        primitive: tables.triangles.len() as u32 + i,
                        instance: instance as u32,
                    };
                }
            }
        }
        hit
    }

    /// Compares the three on one ray; coincident primitives may differ in name but not in distance.
    fn check(&mut self, rays: &[Ray]) {
        let accel = Accel::build(self.tables(), &self.groups);
        let nodes = accel.shader_nodes(self.tables());
        for instance in &mut self.instances {
            instance.root = nodes.roots[instance.group as usize];
        }
        let tables = self.tables();
        let wide = accel.traverse(tables);
        let walk = Bvh2Traverse {
            tables,
            nodes: &nodes.nodes,
            primitive_indices: &nodes.primitive_indices,
        };
        for ray in rays {
            let expected = self.search(ray);
            for (name, hit, occluded) in [
                ("wide", wide.closest_hit(ray), wide.is_occluded(ray)),
                ("binary", walk.closest_hit(ray), walk.is_occluded(ray)),
            ] {
                assert_eq!(
                    hit.t, expected.t,
                    "{name}: {hit:?} {expected:?} along {ray:?}"
                );
                assert_eq!(occluded, expected.is_hit(), "{name} along {ray:?}");
                if hit.primitive == expected.primitive && hit.instance == expected.instance {
                    assert_eq!(hit, expected, "{name} along {ray:?}");
                }
            }
        }
    }
}

fn rows(m: Affine3A) -> [f32; 12] {
    let (r, t) = (m.matrix3.transpose(), m.translation);
    [
        r.x_axis.x, r.x_axis.y, r.x_axis.z, t.x, r.y_axis.x, r.y_axis.y, r.y_axis.z, t.y,
        r.z_axis.x, r.z_axis.y, r.z_axis.z, t.z,
    ]
}

fn point(scale: f32) -> impl Strategy<Value = Vec3> + Clone {
    prop::array::uniform3(-1.0f32..1.0).prop_map(move |p| Vec3::from_array(p) * scale)
}

/// Invertible maps: rotation, stretch by 0.1 to 3 with any signs, shear, translation.
fn map() -> impl Strategy<Value = Affine3A> + Clone {
    (
        point(1.0),
        0.0f32..6.3,
        prop::array::uniform3(0.1f32..3.0),
        prop::array::uniform3(any::<bool>()),
        -0.5f32..0.5,
        point(4.0),
    )
        .prop_map(|(axis, angle, stretch, mirror, shear, offset)| {
            let axis = axis.try_normalize().unwrap_or(Vec3::X);
            let signs = Vec3::from_array(mirror.map(|m| if m { -1.0 } else { 1.0 }));
            let m = Mat3A::from_quat(Quat::from_axis_angle(axis, angle))
                * Mat3A::from_diagonal(Vec3::from_array(stretch) * signs)
                * Mat3A::from_cols(
                    Vec3::X.into(),
                    Vec3::new(shear, 1.0, 0.0).into(),
                    Vec3::Z.into(),
                );
            Affine3A {
                matrix3: m,
                translation: offset.into(),
            }
        })
}

fn group() -> impl Strategy<Value = (Vec<[Vec3; 3]>, Vec<(u32, Affine3A)>)> + Clone {
    (
        prop::collection::vec(
            (point(3.0), point(1.0), point(1.0)).prop_map(|(a, b, c)| [a, a + b, a + c]),
            0..40,
        ),
        prop::collection::vec((0u32..3, map()), 0..6),
    )
}

/// Rays in all directions, along axes, in short intervals.
fn ray() -> impl Strategy<Value = Ray> + Clone {
    (
        point(8.0),
        prop_oneof![
            3 => point(1.0),
            1 => (0usize..3, any::<bool>()).prop_map(|(k, s)| {
                let mut d = Vec3::ZERO;
                d[k] = if s { -1.0 } else { 1.0 };
                d
            }),
            1 => (point(1.0), 0usize..3).prop_map(|(mut d, k)| {
                d[k] = 0.0;
                d
            }),
        ],
        prop_oneof![3 => Just((0.0f32, f32::MAX)), 1 => (0.0f32..5.0, 5.0f32..10.0)],
    )
        .prop_map(|(origin, d, (t_min, t_max))| Ray {
            origin,
            direction: d.try_normalize().unwrap_or(Vec3::Z),
            t_min,
            t_max,
        })
}

fn runner(cases: u32) -> TestRunner {
    TestRunner::new_with_rng(
        Config {
            cases,
            failure_persistence: None,
            ..Config::default()
        },
        TestRng::deterministic_rng(RngAlgorithm::ChaCha),
    )
}

#[test]
fn random_scenes_with_quadrics_and_instances() {
    let scene = (
        prop::collection::vec(group(), 1..4),
        prop::collection::vec((1u32..4, map()), 0..8),
        prop::collection::vec(ray(), 60),
    );
    runner(150)
        .run(&scene, |(groups, placements, rays)| {
            let mut g = Geometry::default();
            for (triangles, quadrics) in &groups {
                triangles.iter().for_each(|t| g.triangle(*t));
                quadrics.iter().for_each(|(k, m)| g.quadric(*k, *m));
                g.close_group();
            }
            g.place(0, Affine3A::IDENTITY);
            assert_eq!(g.instances[0].to_world, IDENTITY);
            for (group, map) in &placements {
                if (*group as usize) < groups.len() {
                    g.place(*group, *map);
                }
            }
            g.check(&rays);
            Ok(())
        })
        .unwrap();
}
