//! The storage of light vertices that a front end lends: a list of one sample's vertices, or an array that the vertices of many
//! light subpaths share.

use crate::path::PathVertex;

/// Where the vertices of light walks are kept.
pub trait VertexStore {
    /// Keeps a vertex and returns its index, or [`NONE`](crate::scene::NONE) where there is no space.
    fn push(&mut self, vertex: &PathVertex) -> u32;
    /// A vertex that was kept.
    fn get(&self, index: u32) -> PathVertex;
}
