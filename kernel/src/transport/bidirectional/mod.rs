//! Bidirectional path tracing and light tracing (Veach 1997, chapter 10; Lafortune and Willems 1993).
//!
//! Each sample of a pixel traces one walk from an emitter and one through the pixel. Every vertex of the one is connected to
//! every vertex of the other, to the lens and to an emitter point, and what the walks meet by chance counts too; weights
//! combine all strategies that can make the same path:
//!
//! ```text
//! I_j = sum_(s,t) w_(s,t) C_(s,t) / p_(s,t),   sum_s w_(s, k+1-s) = 1
//! ```
//!
//! Strategies with t < 2 splat light anywhere on the film. Light tracing is the part with t = 1, unweighted.
//!
//! The bounces are steps of [`Walk`](crate::path::Walk)s whose rays the caller traces: [`sample`] one at a time, a front end those of many
//! samples together. Random numbers come from two streams, one for each walk and the connections of its vertices, so that the
//! length of one walk does not shift the numbers of the other.
//! Invariants (tests): the mean is that of path tracing; weights of all strategies of a path sum to one.
//!
//! - `algorithm`: the bounces of both walks and their connections;
//! - `vertex_store`: where a front end keeps the vertices of light subpaths;
//! - `reuse`: connections with a few of the vertices of many light walks;
//! - `sample`: one sample by itself;
//! - `divided`: the same, divided by path expressions;
//! - `manifold`: the same, with connections to lights through refracting interfaces;
//! - `adaptive`: the same, regularised as each path needs it.

// Hosts only: both subpaths are kept.
#[cfg(not(target_arch = "spirv"))]
pub mod adaptive;
mod algorithm;
mod divided;
#[cfg(not(target_arch = "spirv"))]
pub mod manifold;
mod reuse;
mod sample;
mod vertex_store;

pub use algorithm::{Bidirectional, ConnectedPoints, LightSubpath};
pub use divided::{DividedPhotons, DividedSample, StateStore, counted};
pub use reuse::SharedWalks;
pub use sample::{PathObserver, SharedObserver, Unshadowed, sample, sample_observed};
pub use vertex_store::VertexStore;
