//! The ray tracer of the CPU front end: obvhs's compressed eight-wide trees, one per group of primitives.
//!
//! Group 0 is the world; its tree holds its own triangles and quadrics and, as further primitives, the instances, each of
//! which leads into the tree of the group that it places. Triangles lie in the order of the tree's leaves
//! ([`build::packed`]), two by two where they share an edge ([`build::pairs`]), and those that a node has for a ray are tested together
//! ([`single::block`]). Intersections are those of
//! [`halflight_kernel::scene::intersect`], with the same rounding: the CPU and a shader find the same hit, also
//! where surfaces coincide (see [`halflight_kernel::scene::Traverse::closest_hit`]).
//!
//! Primitives with NaN, infinite or absurd coordinates (beyond [`build::MAX_COORDINATE`]) are left out and counted; rays
//! that are not finite miss. Checked: the same hits as a search of all primitives and as the kernel's BVH2 walk.

pub mod build;
pub mod single;
#[cfg(target_arch = "x86_64")]
mod stream;
pub mod traverse;

use build::packed::{self, Place};
use build::{GroupTree, place_bounds};
use halflight_kernel::scene::{NONE, Tables};
use std::ops::Range;
use std::time::{Duration, Instant};

pub use build::shader_nodes::ShaderNodes;
pub use traverse::CpuTraverse;

/// The primitives of a group, by their places in the tables.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct GroupRange {
    /// Triangles.
    pub triangles: Range<u32>,
    /// Quadrics.
    pub quadrics: Range<u32>,
}

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
    /// What lies in the leaves.
    pub places: Vec<Place>,
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
    /// Builds the trees. `groups[0]` is the world; instance i > 0 of the tables places `groups[instance.group]`.
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
            let found = place_bounds(&tables, range, (index == 0).then_some(&bounds[..]));
            accel.statistics.skipped += found.skipped;
            let tree = GroupTree::build(found);
            bounds[index] = tree.bounds;
            accel.statistics.depth = accel.statistics.depth.max(tree.depth);
            let pairs = tree.places.iter().filter(|place| place[1] != NONE).count();
            accel.statistics.primitives += tree.places.len() + pairs;
            let triangles = tables.triangles.len() as u32;
            accel.groups[index] = Group {
                places: packed::places(&tables, &tree),
                is_mixed: tree.places.iter().any(|place| place[0] >= triangles),
                nodes: tree.nodes,
            };
        }
        for group in &accel.groups {
            accel.statistics.nodes += group.nodes.len();
            accel.statistics.bytes +=
                size_of_val(&group.nodes[..]) + size_of_val(&group.places[..]);
        }
        accel.statistics.build_time = start.elapsed();
        accel
    }

    /// The traverser over these trees; `tables` are those of [`Accel::build`].
    pub fn traverse<'a>(&'a self, tables: Tables<'a>) -> CpuTraverse<'a> {
        CpuTraverse::new(self, tables)
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
