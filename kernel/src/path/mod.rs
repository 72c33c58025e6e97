//! What every algorithm over whole paths stands on.
//!
//! A [`Walk`] is the moving end of a subpath, from the sensor or from an emitter; a [`PathVertex`] is a point where it may be
//! connected; an [`Interaction`] is that point looked up again, with one evaluation for all kinds of connections;
//! [`PartialWeights`] hold what the weights need to know of a subpath. A [`Contribution`] is what a connection adds unless
//! something stands in its way: to the pixel from which the camera walk started, or as a splat where light arrives at the
//! lens. Walks always sample the model as it is.
//!
//! - [`rules`]: depth, hidden emitters, strict normals, Russian roulette;
//! - [`walk`]: starts, arrival, scattering;
//! - [`evaluation`]: values and densities at a surface;
//! - [`strategies`]: what can make a path;
//! - [`weight`]: the heuristics and their recursion;
//! - [`connection`]: emission that is met, next event estimation, connections to the lens and between subpaths;
//! - [`visibility`]: what is left of light along a segment.

pub mod connection;
pub mod evaluation;
pub mod rules;
pub mod strategies;
pub mod visibility;
pub mod walk;
pub mod weight;

pub use connection::{Connector, Contribution, LightEnd};
pub use evaluation::{Evaluation, Interaction};
pub use rules::PathRules;
pub use strategies::Strategies;
pub use walk::{PathVertex, Walk};
pub use weight::{Heuristic, PartialWeights};
