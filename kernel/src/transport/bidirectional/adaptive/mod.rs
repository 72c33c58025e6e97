//! Bidirectional path tracing and vertex merging whose regularisation depends on the path: the heuristics of Jendersie and
//! Grosch 2019, section 3.5.
//!
//! - *path diffusion*: tau of a vertex is `tau / sigma`, sigma the spread of the path from the sensor to it. A vertex of a light
//!   subpath has another tau for each camera subpath that it is connected to;
//! - *sampler quality*: a share of each path, which depends on its best connection, is regularised
//!   ([`crate::regularize::heuristic::quality_share`]); the rest is what the algorithm without regularisation makes of it.
//!
//! Either way what is regularised at a vertex is a function of the full path, so that the weights of its strategies (equation 13)
//! are a partition of one; they are summed for each path anew ([`crate::path::path_weights`]). Paths along which nothing is
//! shiny have the weights of the recursion, and so has the share that is not regularised.
//!
//! Both subpaths sample the model as it is, and their random numbers are those without regularisation. Light walks do not meet a
//! lens here (t = 0), and paths have [`MAX_EDGES`] edges at most. What a merge finds is none of the connections whose quality counts.
//!
//! Invariants (tests): without shiny surfaces the image is that of the algorithm, and with plain values it has its mean.
//!
//! Hosts only, because it keeps both subpaths.
//!
//! - `records`: what the two subpaths of a sample and the photons of a pass keep;
//! - `algorithm`: the algorithm, and the densities of a path that is put together from two subpaths;
//! - `emission`, `lens`, `connection`, `merging`: the strategies;
//! - `sample`: the two walks of a sample;
//! - `photon`: the bounce of a light walk whose photons are merged.

mod algorithm;
mod connection;
mod emission;
mod lens;
mod merging;
mod photon;
mod records;
mod sample;

pub use algorithm::Adaptive;
pub use photon::photon_bounce;
pub use records::{AdaptivePhotons, AdaptiveWorkspace, MAX_EDGES, NodeStore};
