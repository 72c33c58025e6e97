//! The layer that all algorithms over full paths share: subpaths, connections between them, and multiple importance
//! sampling weights.
//!
//! A [`Walk`] is the moving end of a subpath that starts at the sensor or at an emitter. A [`PathVertex`] is a stored vertex
//! of it; an [`Interaction`] is that vertex with its surface point and BSDF looked up again, and evaluates the scattering for
//! connections of all kinds. [`PartialWeights`] are the sums over shorter subpaths that the weights need. A [`Contribution`]
//! is the weighted value of one strategy before its visibility is known; it belongs to the pixel from which the camera
//! subpath started, or is a splat. Walks always sample the BSDF itself.
//!
//! - [`discrete_event`], [`mollified`]: discrete directions of a material, and the same blurred;
//! - `path_node`, `path_weights`: vertices of subpaths whose regularisation depends on the full path, and weights of its
//!   strategies;
//! - [`spread`]: what the heuristics of regularisation know of a camera walk;
//! - [`specular_chain`]: which paths nothing samples, and where they are connected all the same;
//! - [`remainder`]: what path tracing leaves to chains;
//! - [`rules`]: path depth, hidden emitters, strict normals, Russian roulette;
//! - [`subpath`]: the moving end of every random walk, its arrival at surfaces and its departure;
//! - [`walk`]: random walks from the sensor and from emitters that can be connected;
//! - `walk_weights`: the partial sums of their weights;
//! - [`arrival`]: what all of them do where they meet a surface;
//! - [`vertex`]: their vertices, as records;
//! - [`evaluation`]: BSDF values and densities at a vertex, in both directions of transport;
//! - [`strategies`]: which sampling strategies exist and enter the weights;
//! - [`weight`]: the balance and power heuristics, and the recursion that evaluates them;
//! - [`photon_density`]: what the weights of merging know of photons;
//! - [`connection`]: emission that is hit, next event estimation, connections between subpaths;
//! - [`lens`]: connections to the lens, and walks that hit it;
//! - [`contribution`]: what a strategy returns;
//! - [`visibility`]: transmittance along a segment;
//! - [`expression`], [`expression_shares`], [`scattered`], [`path_states`]: which sets of paths a path belongs to, and the walks that
//!   find out;
//! - `retarget`, `retarget_states`, `retargeted`: edits, which paths they turn, and what they do at a vertex;
//! - `through_interfaces`: connections through glass, by walks on manifolds (hosts only);
//! - `full_path`, `tracer`, `specular`: full paths with the densities of all strategies, for Markov chains.

pub mod arrival;
pub mod connection;
pub mod contribution;
pub mod discrete_event;
pub mod evaluation;
pub mod expression;
pub mod expression_shares;
// Full paths are for hosts only: chains keep their surface points, for which a shader has no room.
#[cfg(not(target_arch = "spirv"))]
pub mod full_path;
pub mod lens;
pub mod mollified;
// Vertices with what heuristics know of them are for hosts only: a shader has no storage for all of a path.
#[cfg(not(target_arch = "spirv"))]
pub mod path_node;
pub mod path_states;
#[cfg(not(target_arch = "spirv"))]
pub mod path_weights;
pub mod photon_density;
pub mod remainder;
// Edits are for hosts only: they keep several choices per vertex, for which shaders have no storage.
#[cfg(not(target_arch = "spirv"))]
pub mod retarget;
#[cfg(not(target_arch = "spirv"))]
pub mod retarget_states;
#[cfg(not(target_arch = "spirv"))]
pub mod retargeted;
pub mod rules;
pub mod scattered;
pub mod shading_point;
#[cfg(not(target_arch = "spirv"))]
pub mod specular;
pub mod specular_chain;
pub mod spread;
pub mod strategies;
pub mod subpath;
#[cfg(not(target_arch = "spirv"))]
pub mod through_interfaces;
#[cfg(not(target_arch = "spirv"))]
pub mod tracer;
pub mod vertex;
pub mod visibility;
pub mod walk;
mod walk_weights;
pub mod weight;

pub use connection::Connector;
pub use contribution::{Contribution, Contributions};
pub use evaluation::{Evaluation, Interaction};
pub use expression::PathExpressions;
pub use expression_shares::Shares;
pub use path_states::PathStates;
pub use photon_density::PhotonDensity;
pub use rules::PathRules;
pub use scattered::Scattered;
pub use shading_point::ShadingPoint;
pub use strategies::Strategies;
pub use subpath::Subpath;
pub use vertex::{LightEnd, PathVertex};
pub use walk::Walk;
pub use weight::{Heuristic, PartialWeights};
