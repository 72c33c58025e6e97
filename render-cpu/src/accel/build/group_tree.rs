//! The wide tree of a group: a binary tree ([`super::binary_tree`]), folded into eight-wide nodes ([`super::collapse`]).

use super::binary_tree::{clustered_tree, median_split_tree};
use super::bounds::PrimitiveBounds;
use super::collapse::{WideTree, collapse};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::node::CwBvhNode;

/// The deepest binary tree that is accepted from the builder.
pub const MAX_BINARY_DEPTH: usize = 96;

/// The deepest wide tree that the walk's stack holds.
pub const MAX_WIDE_DEPTH: usize = 32;

/// Cost of a leaf entry, where that of a node is 1. From 0.4 to 0.7 times of rendering do not differ.
const ENTRY_COST: f32 = 0.5;

/// The wide tree of a group.
#[derive(Clone, Debug, Default)]
pub struct GroupTree {
    /// Nodes; empty for an empty group.
    pub nodes: Vec<CwBvhNode>,
    /// Primitives in the order of the leaves, with their partners or [`halflight_kernel::scene::NONE`].
    pub entries: Vec<[u32; 2]>,
    /// The box of everything.
    pub bounds: Aabb,
    /// Wide nodes from the root to the deepest leaf.
    pub depth: usize,
}

impl GroupTree {
    /// Builds the tree.
    pub fn build(mut found: PrimitiveBounds) -> GroupTree {
        let partners = std::mem::take(&mut found.partners);
        if found.leaves.is_empty() {
            return GroupTree {
                bounds: Aabb::empty(),
                ..GroupTree::default()
            };
        }
        let mut binary = clustered_tree(found, MAX_BINARY_DEPTH);
        let wide = collapse(&binary, ENTRY_COST, MAX_BINARY_DEPTH);
        let wide = wide
            .filter(|wide| wide.depth <= MAX_WIDE_DEPTH)
            .unwrap_or_else(|| {
                binary = median_split_tree(&binary);
                // It is as shallow as can be.
                collapse(&binary, ENTRY_COST, MAX_BINARY_DEPTH).unwrap_or_default()
            });
        let WideTree {
            nodes,
            primitives,
            depth,
        } = wide;
        let entries = primitives.into_iter();
        GroupTree {
            nodes,
            entries: entries.map(|p| [p, partners.of(p)]).collect(),
            bounds: *binary.nodes[0].aabb(),
            depth,
        }
    }
}
