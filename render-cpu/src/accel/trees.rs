//! The trees of a scene: one per group of primitives.

use super::build::leaf_entry::{LeafEntry, leaf_entries};
use super::build::shader_nodes::ShaderNodes;
use super::build::{GroupRange, GroupTree, paired_bounds};
use halflight_kernel::scene::{NONE, Tables};
use std::time::{Duration, Instant};

/// Trees over the primitives of a scene.
#[derive(Clone, Debug, Default)]
pub struct Accel {
    pub(crate) groups: Vec<Group>,
    ranges: Vec<GroupRange>,
    statistics: Statistics,
}

/// The tree of one group.
#[derive(Clone, Debug, Default)]
pub(crate) struct Group {
    /// Nodes; empty for an empty group.
    pub nodes: Vec<obvhs::cwbvh::node::CwBvhNode>,
    /// What lies in the leaves, in their order.
    pub entries: Vec<LeafEntry>,
    /// Whether it holds anything but triangles.
    pub is_mixed: bool,
}

/// What was built.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Statistics {
    /// Nodes of all trees.
    pub nodes: usize,
    /// Primitives in all trees, instances included.
    pub primitives: usize,
    /// Primitives that were left out because their coordinates are not usable.
    pub skipped: usize,
    /// Memory of the trees and of the packed triangles.
    pub bytes: usize,
    /// Greatest depth of a tree in wide nodes.
    pub depth: usize,
    /// Time of the build.
    pub build_time: Duration,
}

impl Accel {
    /// Builds the trees. `groups[0]` is the world; instance i > 0 of the tables is a copy of `groups[instance.group]`.
    pub fn build(tables: Tables<'_>, groups: &[GroupRange]) -> Accel {
        let start = Instant::now();
        let mut accel = Accel {
            groups: vec![Group::default(); groups.len().max(1)],
            ranges: groups.to_vec(),
            statistics: Statistics::default(),
        };
        let mut bounds = vec![obvhs::aabb::Aabb::empty(); accel.groups.len()];
        // The groups first, because the world needs their bounds for its instances.
        for (index, range) in groups.iter().enumerate().rev() {
            let found = paired_bounds(&tables, range, (index == 0).then_some(&bounds[..]));
            accel.statistics.skipped += found.skipped;
            let tree = GroupTree::build(found);
            bounds[index] = tree.bounds;
            accel.statistics.depth = accel.statistics.depth.max(tree.depth);
            let pairs = tree.entries.iter().filter(|entry| entry[1] != NONE).count();
            accel.statistics.primitives += tree.entries.len() + pairs;
            let triangles = tables.triangles.len() as u32;
            accel.groups[index] = Group {
                entries: leaf_entries(&tables, &tree),
                is_mixed: tree.entries.iter().any(|entry| entry[0] >= triangles),
                nodes: tree.nodes,
            };
        }
        for group in &accel.groups {
            accel.statistics.nodes += group.nodes.len();
            accel.statistics.bytes +=
                size_of_val(&group.nodes[..]) + size_of_val(&group.entries[..]);
        }
        accel.statistics.build_time = start.elapsed();
        accel
    }

    /// Trees for the kernel's own walk, [`halflight_kernel::scene::Bvh2Traverse`].
    pub fn shader_nodes(&self, tables: Tables<'_>) -> ShaderNodes {
        ShaderNodes::build(tables, &self.ranges)
    }

    /// What was built.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }
}
