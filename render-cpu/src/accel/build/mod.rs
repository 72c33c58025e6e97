//! From primitives to trees.
//!
//! [`bounds`] puts boxes around the primitives of a group, [`pairs`] joins triangles that share an edge, [`binary_tree`] builds
//! over the boxes, [`collapse`] folds binary nodes into wide ones (whose slots it orders by `slots`), [`group_tree`] is the
//! result and [`leaf_entry`] what lies in its leaves. [`shader_nodes`] are the binary trees of the walk in shaders.

pub mod binary_tree;
pub mod bounds;
pub mod collapse;
pub mod group_tree;
pub mod leaf_entry;
pub mod pairs;
pub mod shader_nodes;
mod slots;

pub use binary_tree::binary_depth;
pub use bounds::{GroupRange, MAX_COORDINATE, PrimitiveBounds, paired_bounds, primitive_bounds};
pub use group_tree::{GroupTree, MAX_BINARY_DEPTH, MAX_WIDE_DEPTH};
