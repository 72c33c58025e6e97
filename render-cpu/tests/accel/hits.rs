//! The wide trees, the kernel's binary walk and a search of all primitives find the same hits.

use crate::geometry::{Geometry, Random, check_batches, rays_around, world};
use glam::{Affine3A, Mat3A, Quat, Vec3};
use halflight::accel::{Accel, GroupRange};
use halflight_kernel::math::Ray;
use halflight_kernel::math::affine::IDENTITY;
use halflight_kernel::scene::*;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

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

/// Triangles, of which every other one shares an edge with the one before, in either direction.
fn triangles() -> impl Strategy<Value = Vec<[Vec3; 3]>> + Clone {
    let one = (
        point(3.0),
        point(1.0),
        point(1.0),
        0usize..18,
        any::<bool>(),
    );
    prop::collection::vec(one, 0..40).prop_map(|parts| {
        let mut triangles: Vec<[Vec3; 3]> = vec![];
        for (a, b, c, turns, is_neighbour) in parts {
            triangles.push(match triangles.last() {
                Some(last) if is_neighbour => {
                    let mut edge = [last[(turns + 1) % 3], last[turns % 3]];
                    if turns >= 9 && turns % 2 == 0 {
                        edge.reverse();
                    }
                    let mut next = [edge[0], edge[1], edge[0] + b];
                    next.rotate_left(turns / 3 % 3);
                    next
                }
                _ => [a, a + b, a + c],
            });
        }
        triangles
    })
}

fn group() -> impl Strategy<Value = (Vec<[Vec3; 3]>, Vec<(u32, Affine3A)>)> + Clone {
    (triangles(), prop::collection::vec((0u32..3, map()), 0..6))
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

#[test]
fn nothing_to_hit() {
    let rays = rays_around(1.0);
    world(|_| ()).check(&rays);
    let none = Accel::build(Geometry::default().tables(), &[]);
    assert!(
        !none
            .traverse(Geometry::default().tables())
            .is_occluded(&rays[0])
    );
    // An instance of an empty group, and one of a group that does not exist.
    let mut g = world(|g| g.triangle([Vec3::X, Vec3::Y, Vec3::Z]));
    g.close_group();
    g.place(1, Affine3A::IDENTITY);
    g.check(&rays);
    g.instances[1].group = 7;
    let accel = Accel::build(g.tables(), &g.groups);
    assert_eq!(accel.statistics().primitives, 1);
}

#[test]
fn single_primitives() {
    world(|g| g.triangle([Vec3::X, Vec3::Y, Vec3::Z])).check(&rays_around(1.0));
    for kind in 0..3 {
        world(|g| g.quadric(kind, Affine3A::IDENTITY)).check(&rays_around(1.0));
    }
}

/// Equal primitives: the first of them is the hit.
#[test]
fn coincident_primitives() {
    world(|g| {
        for _ in 0..2000 {
            g.triangle([Vec3::X, Vec3::Y, Vec3::Z]);
            g.quadric(quadric_kind::SPHERE, Affine3A::from_scale(Vec3::splat(0.5)));
        }
    })
    .check(&rays_around(1.0)[..100]);
}

/// Boxes that stand in, on and next to each other share planes, edges and whole faces, within a group and between instances,
/// the same group placed twice in one place among them. What is hit there is the lowest primitive in the lowest instance,
/// in whatever order the faces come and whatever tree is made of them.
#[test]
fn coincident_faces() {
    // Coordinates on a coarse lattice, whose planes are no round numbers.
    let at = |i: u32| 0.37 * i as f32 - 0.9;
    let edge = (0u32..5, 1u32..4).prop_map(move |(a, size)| (at(a), at(a + size)));
    let cuboid = (edge.clone(), edge.clone(), edge, 0usize..6);
    let faces = prop::collection::vec(cuboid, 1..8).prop_map(|boxes| {
        let mut faces = vec![];
        for (x, y, z, first) in boxes {
            for face in (first..first + 6).map(|f| f % 6) {
                let (axis, is_far) = (face / 2, face % 2 == 1);
                let corner = |u: bool, v: bool| {
                    let mut side = [false; 3];
                    side[axis] = is_far;
                    side[(axis + 1) % 3] = u;
                    side[(axis + 2) % 3] = v;
                    let pick = |far: bool, (a, b): (f32, f32)| if far { b } else { a };
                    Vec3::new(pick(side[0], x), pick(side[1], y), pick(side[2], z))
                };
                let [a, b, c, d] = [
                    corner(false, false),
                    corner(true, false),
                    corner(true, true),
                    corner(false, true),
                ];
                faces.extend([[a, b, c], [a, c, d]]);
            }
        }
        faces
    });
    // At anything, at corners and edges, along the axes.
    let corner = prop::array::uniform3(0u32..6).prop_map(move |p| Vec3::from_array(p.map(at)));
    let target = prop_oneof![3 => point(0.9), 1 => corner];
    let rays = (point(3.0), target, 0usize..9).prop_map(|(from, to, straight)| {
        let (from, direction) = if straight < 3 {
            let along = Vec3::AXES[straight];
            (to - along * 4.0, along)
        } else {
            (from, (to - from).try_normalize().unwrap_or(Vec3::Z))
        };
        Ray::new(from, direction)
    });
    let scene = (
        prop::collection::vec(faces.prop_shuffle(), 3),
        prop::collection::vec((1u32..3, 0u32..2), 1..6),
        prop::collection::vec(rays, 60),
    );
    let shared = std::cell::Cell::new(0);
    runner(200)
        .run(&scene, |(groups, placements, rays)| {
            let mut g = Geometry::default();
            for triangles in &groups {
                triangles.iter().for_each(|t| g.triangle(*t));
                g.close_group();
            }
            g.place(0, Affine3A::IDENTITY);
            for (group, steps) in &placements {
                let shift = Vec3::X * (0.37 * *steps as f32);
                g.place(*group, Affine3A::from_translation(shift));
            }
            g.check(&rays);
            let here = rays.iter().filter(|ray| g.is_shared(ray)).count();
            shared.set(shared.get() + here);
            Ok(())
        })
        .unwrap();
    let shared = shared.get();
    assert!(
        shared > 1000,
        "{shared} of 12,000 rays end on several faces"
    );
}

/// Points and segments in place of triangles are never hit and disturb nothing.
#[test]
fn degenerate_triangles() {
    world(|g| {
        let mut random = Random(2);
        for _ in 0..100 {
            let (a, b) = (random.point(), random.point());
            g.triangle([a, a, a]);
            g.triangle([a, b, a]);
            g.triangle([a, a + (b - a) * 0.5, b]);
            g.triangle([a, a + b * 0.2, a + random.point() * 0.2]);
        }
    })
    .check(&rays_around(1.0));
}

/// Coordinates that cannot be traced are left out and counted, and the rest is found.
#[test]
fn unusable_coordinates() {
    let mut g = world(|g| {
        g.triangle([Vec3::X, Vec3::Y, Vec3::Z]);
        for bad in [f32::NAN, f32::INFINITY, 1e30] {
            g.triangle([Vec3::X, Vec3::Y, Vec3::new(0.0, 0.0, bad)]);
            g.quadric(
                quadric_kind::SPHERE,
                Affine3A::from_translation(Vec3::new(bad, 0.0, 0.0)),
            );
        }
    });
    let statistics = Accel::build(g.tables(), &g.groups).statistics();
    assert_eq!((statistics.primitives, statistics.skipped), (1, 6));
    // The search knows nothing of what is left out: only rays that meet the triangle tell.
    let ray = Ray::new(Vec3::ZERO, Vec3::ONE.normalize());
    g.positions.truncate(3);
    g.triangles.truncate(1);
    g.quadrics.clear();
    g.groups = vec![GroupRange {
        triangles: 0..1,
        quadrics: 0..0,
    }];
    g.check(&[ray]);
    let accel = Accel::build(g.tables(), &g.groups);
    let traverse = accel.traverse(g.tables());
    let mut untraceable = vec![Ray::new(Vec3::ZERO, Vec3::ZERO)];
    for bad in [f32::NAN, f32::INFINITY] {
        untraceable.extend([
            Ray::new(Vec3::splat(bad), Vec3::X),
            Ray::new(Vec3::ZERO, Vec3::new(0.0, bad, 1.0)),
            Ray { t_min: bad, ..ray },
            Ray {
                t_max: f32::NAN,
                ..ray
            },
        ]);
    }
    for ray in &untraceable {
        assert_eq!(traverse.closest_hit(ray), Hit::MISS);
        assert!(!traverse.is_occluded(ray));
    }
    // Beside one that can be traced.
    let mixed: Vec<_> = untraceable.iter().flat_map(|bad| [*bad, ray]).collect();
    check_batches::<64>(&traverse, &mixed);
}

/// From microns to megametres; obvhs's own walk ignores hits nearer than 1e-4.
#[test]
fn any_scale() {
    for scale in [1e-6f32, 1e-3, 1e3, 1e6] {
        let mut g = world(|g| {
            let mut random = Random(3);
            for _ in 0..300 {
                let a = random.point();
                g.triangle(
                    [a, a + random.point() * 0.2, a + random.point() * 0.2].map(|p| p * scale),
                );
            }
            g.quadric(
                quadric_kind::SPHERE,
                Affine3A::from_scale(Vec3::splat(scale * 0.3)),
            );
        });
        g.check(&rays_around(scale));
    }
}

/// A flat grid whose boxes have no thickness and touch along whole numbers: rays straight and slanted at edges, corners
/// and centres all hit.
#[test]
fn flat_grids_do_not_leak() {
    let n = 24;
    for axis in 0..3 {
        let place = |u: usize, v: usize| {
            let mut p = [0.0; 3];
            p[axis] = 3.0;
            p[(axis + 1) % 3] = u as f32 - 12.0;
            p[(axis + 2) % 3] = v as f32 - 12.0;
            Vec3::from_array(p)
        };
        let mut g = world(|g| {
            for u in 0..n {
                for v in 0..n {
                    let corner = |i, j| place(u + i, v + j);
                    g.triangle([corner(0, 0), corner(1, 0), corner(1, 1)]);
                    g.triangle([corner(0, 0), corner(1, 1), corner(0, 1)]);
                }
            }
        });
        let mut rays = vec![];
        for u in 1..n {
            for v in 1..n {
                for (du, dv) in [(0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.5, 0.5)] {
                    let mut target = place(u, v);
                    target[(axis + 1) % 3] += du;
                    target[(axis + 2) % 3] += dv;
                    target = target.min(Vec3::splat(11.5));
                    target[axis] = 3.0;
                    let up = Vec3::AXES[axis];
                    rays.push(Ray::new(target - up * 5.0, up));
                    let slanted = target - Vec3::new(0.3, -2.7, 1.1) - up * 5.0;
                    rays.push(Ray::new(slanted, (target - slanted).normalize()));
                    rays.push(Ray::new(slanted, target - slanted));
                }
            }
        }
        for ray in &rays {
            assert!(g.search(ray).is_hit());
        }
        g.check(&rays);
    }
}
