//! Half-vector space: chains of glossy and specular interactions as manifolds.

pub mod breakup;
pub mod chain;
pub mod constraint;
pub mod exploration;
pub mod half_vector;
pub mod mutation;
pub mod projection;
pub mod step_size;
pub mod vertex;
pub mod walk;

pub use chain::ChainJacobian;
pub use constraint::half_vector_form;
pub use vertex::{ChainVertex, vertex_kind};

/// The most vertices of a chain on a host. Shaders choose a smaller capacity.
pub const MAX_CHAIN: usize = 32;
