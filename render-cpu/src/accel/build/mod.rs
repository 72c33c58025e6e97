//! From primitives to trees.
//!
//! [`group_tree`] makes a tree for each group of primitives; [`pairs`] joins triangles that share an edge, [`collapse`] folds
//! binary nodes into wide ones, in whose slots `slots` orders them, and [`packed`] lays out what lies in the leaves.
//! [`shader_nodes`] are the binary trees of the walk in shaders.

pub mod collapse;
pub mod group_tree;
pub mod packed;
pub mod pairs;
pub mod shader_nodes;
mod slots;

pub use group_tree::{
    GroupTree, MAX_BINARY_DEPTH, MAX_COORDINATE, MAX_WIDE_DEPTH, PrimitiveBounds, binary_depth,
    binary_tree, place_bounds, primitive_bounds,
};
