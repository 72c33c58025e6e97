//! Trees: as deep as stacks allow, the same for any number of threads, and those of obvhs.

use crate::geometry::{rays_around, world};
use glam::Vec3;
use halflight::accel::build::collapse::collapse;
use halflight::accel::{Accel, build};
use halflight_kernel::scene::{BvhNode, bvh2};
use obvhs::cwbvh::bvh2_to_cwbvh::bvh2_to_cwbvh;

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
        (tree.entries, tree.nodes)
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
        let binary = build::binary_tree::binary_tree(found, build::MAX_BINARY_DEPTH);
        /// Of a primitive in obvhs.
        const COST: f32 = 0.3;
        let expected = bvh2_to_cwbvh(&binary, 3, true, false);
        let wide = collapse(&binary, COST, build::MAX_BINARY_DEPTH).unwrap();
        assert!(wide.nodes == expected.nodes, "{count}");
        assert_eq!(wide.primitives, expected.primitive_indices, "{count}");

        let deepest = build::binary_depth(&binary);
        assert!(collapse(&binary, COST, deepest).is_some(), "{count}");
        assert!(collapse(&binary, COST, deepest - 1).is_none(), "{count}");
    }
}
