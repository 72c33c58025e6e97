//! The wide trees, the kernel's binary walk and a search of all primitives find the same hits.

#[path = "common/geometry.rs"]
mod geometry;

use geometry::Geometry;
use glam::{Affine3A, Mat3A, Quat, Vec3};
use halflight::accel::collapse::collapse;
use halflight::accel::{Accel, GroupRange, build};
use halflight_kernel::math::Ray;
use halflight_kernel::math::affine::IDENTITY;
use halflight_kernel::scene::*;
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;
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

/// Geometry of the world alone, with its one instance.
fn world(fill: impl FnOnce(&mut Geometry)) -> Geometry {
    let mut g = Geometry::default();
    fill(&mut g);
    g.close_group();
    g.place(0, Affine3A::IDENTITY);
    g
}

/// Deterministic rays from around towards a box of half this size.
fn rays_around(size: f32) -> Vec<Ray> {
    let mut random = Random(1);
    let mut rays = vec![];
    for i in 0..400 {
        let target = random.point() * size;
        let mut direction = random.point();
        if i % 5 == 0 {
            direction[i % 3] = 0.0;
        }
        if i % 7 == 0 {
            direction = Vec3::AXES[i % 3];
        }
        let direction = direction.normalize();
        rays.push(Ray::new(target - direction * (3.0 * size), direction));
    }
    rays
}

/// Numbers in [-1, 1) by a multiplicative generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 40) as f32 / (1u64 << 23) as f32 - 1.0
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
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
    let tables = g.tables();
    for bad in [f32::NAN, f32::INFINITY] {
        for ray in [
            Ray::new(Vec3::splat(bad), Vec3::X),
            Ray::new(Vec3::ZERO, Vec3::new(0.0, bad, 1.0)),
            Ray { t_min: bad, ..ray },
            Ray {
                t_max: f32::NAN,
                ..ray
            },
        ] {
            assert_eq!(accel.traverse(tables).closest_hit(&ray), Hit::MISS);
            assert!(!accel.traverse(tables).is_occluded(&ray));
        }
    }
    let zero = Ray::new(Vec3::ZERO, Vec3::ZERO);
    assert_eq!(accel.traverse(tables).closest_hit(&zero), Hit::MISS);
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

/// Sizes that span eighty octaves make deep trees: they must fit both stacks.
#[test]
fn deep_trees() {
    let mut g = world(|g| {
        for i in 0..4000 {
            let size = 2f32.powf(i as f32 * -0.02);
            let at = Vec3::X * size;
            g.triangle([
                at,
                at + Vec3::Y * size,
                at + Vec3::new(0.1, 0.0, 1.0) * size,
            ]);
        }
    });
    g.check(&rays_around(1.0));
    let nodes = Accel::build(g.tables(), &g.groups).shader_nodes(g.tables());
    assert!(depth(&nodes.nodes) <= bvh2::MAX_DEPTH);
}

fn depth(nodes: &[BvhNode]) -> usize {
    let mut deepest = 0;
    let mut stack = vec![(0, 1)];
    while let Some((index, depth)) = stack.pop() {
        let node = &nodes[index as usize];
        deepest = deepest.max(depth);
        if node.count == 0 {
            stack.extend([(node.first, depth + 1), (node.first + 1, depth + 1)]);
        }
    }
    deepest
}

/// Large trees are built by several threads. Whatever their number, the tree is the same, so that times can be compared. The
/// grid has many boxes of equal size, and every one twice.
#[test]
fn trees_do_not_depend_on_the_number_of_threads() {
    let geometry = world(|g| {
        for i in 0..300 {
            for j in 0..200 {
                let at = Vec3::new(i as f32, j as f32, 0.0);
                for _ in 0..2 {
                    g.triangle([at, at + Vec3::X, at + Vec3::Y]);
                }
            }
        }
    });
    let order = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let tree = pool.unwrap().install(|| {
            let tables = geometry.tables();
            let found = build::primitive_bounds(&tables, &geometry.groups[0], None);
            build::GroupTree::build(found)
        });
        (tree.primitives, tree.nodes)
    };
    let one = order(1);
    assert_eq!(one.0.len(), 120_000);
    for threads in [2, 3, 7] {
        assert!(order(threads) == one, "{threads} threads");
    }
}

/// The wide nodes are those that obvhs makes of the same binary tree, for trees of one leaf, of a few, and of enough that
/// threads share the work; boxes lie in clusters, coincide and have no thickness.
#[test]
fn wide_nodes_are_those_of_obvhs() {
    let mut state = 1_u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    for count in [1, 2, 3, 4, 5, 9, 40, 700, 30_000] {
        let geometry = world(|g| {
            for i in 0..count {
                let spread = if i % 3 == 0 { 100.0 } else { 1.0 };
                let at = Vec3::new(random(), random(), random()) * spread;
                let size = if i % 50 == 0 { 3.0 } else { 0.01 };
                let (a, b) = (random() - 0.5, random() - 0.5);
                for _ in 0..1 + (i % 17 == 0) as u32 {
                    g.triangle([at, at + Vec3::new(size, 0.0, a * size), at + Vec3::Y * b]);
                }
            }
        });
        let found = build::primitive_bounds(&geometry.tables(), &geometry.groups[0], None);
        let binary = build::binary_tree(found, build::MAX_BINARY_DEPTH);
        let expected = bvh2_to_cwbvh(&binary, 3, false, false);
        let wide = collapse(&binary, build::MAX_BINARY_DEPTH).unwrap();
        assert!(wide.nodes == expected.nodes, "{count}");
        assert_eq!(wide.primitives, expected.primitive_indices, "{count}");

        let deepest = build::binary_depth(&binary);
        assert!(collapse(&binary, deepest).is_some(), "{count}");
        assert!(collapse(&binary, deepest - 1).is_none(), "{count}");
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

/// The three node tests find the same children, up to rounding at the edges of boxes.
#[cfg(target_arch = "x86_64")]
#[test]
fn node_tests_agree() {
    use halflight::accel::lanes::{Avx2, Lanes, Portable, Sse2};
    use halflight::accel::node::Children;
    use obvhs::cwbvh::node::CwBvhNode;
    let mut random = Random(5);
    let boxes: Vec<_> = (0..3000)
        .map(|_| {
            let a = glam::Vec3A::from(random.point());
            obvhs::aabb::Aabb::from_points(&[a, a + glam::Vec3A::from(random.point()) * 0.1])
        })
        .collect();
    let nodes = obvhs::cwbvh::builder::build_cwbvh(
        &boxes,
        obvhs::BvhBuildParams::fast_build(),
        &mut std::time::Duration::default(),
    )
    .nodes;
    let has_avx2 = is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma");
    let (mut tested, mut hits, mut different) = (0, 0, 0);
    for ray in rays_around(1.0) {
        for node in nodes.iter().step_by(7) {
            fn children<T: Lanes>(node: &CwBvhNode, ray: &Ray) -> Children {
                T::children(node, &T::ray(ray.origin, ray.direction, 0.0), 10.0)
            }
            let portable = children::<Portable>(node, &ray);
            let mut others = vec![children::<Sse2>(node, &ray)];
            if has_avx2 {
                others.push(children::<Avx2>(node, &ray));
            }
            for other in others {
                tested += 8;
                hits += portable.hits.count_ones();
                different += (portable.hits ^ other.hits).count_ones();
                for k in 0..8 {
                    if portable.inner() & other.inner() & (1 << k) != 0 {
                        let error = (portable.near[k] - other.near[k]).abs();
                        assert!(error <= 2e-5, "{error}");
                    }
                }
            }
        }
    }
    assert!(
        hits > 1000 && different * 100_000 < tested,
        "{different} of {tested}, {hits} hit"
    );
}

/// Blocks of eight triangles give the kernel's own hits to the bit, with AVX2 and without; zeros among the edge functions,
/// slivers and coincident triangles included.
#[test]
fn block_tests_agree_with_the_kernel() {
    use halflight::accel::lanes::{Lanes, Portable};
    use halflight::accel::packed::{BLOCK, TriangleBlock};
    let mut random = Random(11);
    let (mut hits, mut ties) = (0, 0);
    for case in 0..40_000u32 {
        let round = |v: Vec3| if case % 2 == 0 { (v * 2.0).round() } else { v };
        let mut block = TriangleBlock {
            axes: [[[0.0; BLOCK]; 3]; 3],
        };
        for place in 0..BLOCK {
            for vertex in 0..3 {
                let mut p = round(random.point() * 2.0);
                if case % 5 < 2 && place % 3 == 2 {
                    p = block.vertices(place - 1)[vertex];
                }
                for axis in 0..3 {
                    block.axes[axis][vertex][place] = p[axis];
                }
            }
        }
        let origin = round(random.point() * 3.0);
        let direction = round(random.point() * 2.0);
        if direction == Vec3::ZERO {
            continue;
        }
        let sheared = intersect::ShearedRay::new(origin, direction);
        let places = case % 256;
        let name = |place: usize| (place as u32 * 5 + case) % 8;
        let mut expected = (20.0, BLOCK, 0.0, 0.0);
        for place in (0..BLOCK).filter(|place| places & (1 << place) != 0) {
            let [p0, p1, p2] = block.vertices(place);
            let found = intersect::intersect_triangle(&sheared, p0, p1, p2, 0.1, 20.0);
            let is_tie = found.t == expected.0;
            ties += is_tie as u32;
            if found.t < expected.0 || (is_tie && name(place) < name(expected.1)) {
                expected = (found.t, place, found.b1, found.b2);
            }
        }
        hits += (expected.1 < BLOCK) as u32;
        let check = |found: halflight::accel::block::BlockHit| {
            assert_eq!(found.place, expected.1, "case {case}");
            if found.place < BLOCK {
                assert_eq!(
                    (found.t, found.b1, found.b2),
                    (expected.0, expected.2, expected.3)
                );
            }
        };
        check(Portable::nearest(
            &block,
            name,
            &Portable::ray(origin, direction, 0.1),
            places,
            20.0,
        ));
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            use halflight::accel::lanes::Avx2;
            check(Avx2::nearest(
                &block,
                name,
                &Avx2::ray(origin, direction, 0.1),
                places,
                20.0,
            ));
        }
    }
    assert!(hits > 2000 && ties > 100, "{hits} hits, {ties} ties");
}
