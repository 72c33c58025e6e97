//! Metropolis light transport: Markov chains of paths (Veach and Guibas 1997, "Metropolis light transport").
//!
//! A chain visits paths with a density proportional to a scalar I of what they contribute, the luminance of F: from x it
//! proposes y with a density T(x -> y) and goes there with the probability
//!
//! ```text
//! a = min(1, I(y) T(y -> x) / (I(x) T(x -> y))).
//! ```
//!
//! The image is b times the mean of F / I over the states, with b the integral of I. Here chains come in **groups**. A group
//! draws candidates by another algorithm, estimates b by the mean of their weights I / p, and starts its chains from candidates
//! drawn in proportion to their weights. Then b F / I is an unbiased estimate from the first step on, however short the
//! chains are (Veach 1997, section 11.3.1), so the groups are independent estimates of the image: their mean is the image,
//! their spread is its variance, and b becomes more precise with each of them.
//!
//! Each step counts both x with 1 - a and y with a ("expected values"), so little of what was computed is thrown away.
//!
//! - [`algorithm`]: what a driver needs to know of an algorithm;
//! - [`state`]: what a state adds to the image;
//! - [`importance`]: how often chains come to the parts of the image;
//! - [`annealing`]: targets that are mollified less and less;
//! - [`primary_space`]: paths as functions of primary samples: over `path`, over `bdpt`, and multiplexed (`multiplexed`);
//! - [`primary_chain`]: chains of primary samples;
//! - [`veach`]: chains of full paths;
//! - [`half_vector`]: their mutations in half-vector space.
//!
//! Hosts only: the records of a chain are long.

pub mod algorithm;
pub mod annealing;
pub mod half_vector;
pub mod importance;
mod multiplexed;
pub mod primary_chain;
pub mod primary_space;
pub mod state;
pub mod veach;

pub use algorithm::ChainAlgorithm;
pub use primary_chain::PrimaryChains;
pub use state::{Splat, State};
pub use veach::VeachChains;
