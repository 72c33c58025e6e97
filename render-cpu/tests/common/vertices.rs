//! Room for the vertices of light walks, for tests.

use halflight_kernel::path::PathVertex;
use halflight_kernel::transport::bidirectional::VertexStore;

/// Vertices by their index.
#[derive(Default)]
pub struct Vertices(pub Vec<PathVertex>);

impl VertexStore for Vertices {
    fn push(&mut self, vertex: &PathVertex) -> u32 {
        self.0.push(*vertex);
        self.0.len() as u32 - 1
    }

    fn get(&self, index: u32) -> PathVertex {
        self.0[index as usize]
    }
}
