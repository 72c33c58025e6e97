//! Trees for the walk that shaders use.

use super::binary_tree::binary_tree;
use super::bounds::{GroupRange, primitive_bounds};
use halflight_kernel::scene::bvh2::{MAX_DEPTH, MAX_LEAF};
use halflight_kernel::scene::{BvhNode, Tables};
use obvhs::aabb::Aabb;
use obvhs::bvh2::leaf_collapser::collapse;

/// One node array for all groups: what [`halflight_kernel::scene::Bvh2Traverse`] borrows.
#[derive(Clone, Debug, Default)]
pub struct ShaderNodes {
    /// The world's nodes, then those of the groups.
    pub nodes: Vec<BvhNode>,
    /// What the leaves hold.
    pub primitive_indices: Vec<u32>,
    /// Root node of each group, for [`halflight_kernel::scene::Instance::root`]; 0 for groups without primitives, which
    /// no leaf names.
    pub roots: Vec<u32>,
}

impl ShaderNodes {
    /// Builds binary trees that fit the walk's stack.
    pub fn build(tables: Tables<'_>, groups: &[GroupRange]) -> ShaderNodes {
        let mut trees = Vec::with_capacity(groups.len());
        let mut bounds = vec![Aabb::empty(); groups.len()];
        for (index, range) in groups.iter().enumerate().rev() {
            let found = primitive_bounds(&tables, range, (index == 0).then_some(&bounds[..]));
            let mut tree = binary_tree(found, MAX_DEPTH);
            if let Some(root) = tree.nodes.first() {
                bounds[index] = *root.aabb();
            }
            collapse(&mut tree, MAX_LEAF as u32, 2.0);
            trees.push(tree);
        }
        let mut result = ShaderNodes {
            roots: vec![0; groups.len()],
            ..ShaderNodes::default()
        };
        for (group, tree) in trees.into_iter().rev().enumerate() {
            if tree.nodes.is_empty() {
                continue;
            }
            let first_node = result.nodes.len() as u32;
            let first_primitive = result.primitive_indices.len() as u32;
            result.roots[group] = first_node;
            for node in &tree.nodes {
                let bounds = node.aabb();
                let base = if node.is_leaf() {
                    first_primitive
                } else {
                    first_node
                };
                result.nodes.push(BvhNode {
                    min: bounds.min.into(),
                    first: base + node.first_index,
                    max: bounds.max.into(),
                    count: node.prim_count,
                });
            }
            result.primitive_indices.extend(&tree.primitive_indices);
        }
        result
    }
}
