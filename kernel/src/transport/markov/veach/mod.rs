//! Veach's Metropolis light transport: mutations of whole paths (Veach 1997, chapter 11; Veach and Guibas 1997).
//!
//! - [`bidirectional`]: part of the path is deleted and replaced by walks from both of its ends;
//! - [`perturbation`]: the lens, multi-chain and caustic perturbations move some of the vertices a little;
//! - [`candidate`]: paths from which chains start;
//! - [`ends`]: what connections may make of the ends of their edge;
//! - [`group`], [`chain`]: what a group of chains looks for, and the steps of a chain;
//! - [`balance`]: what path tracing finds for them.
//!
//! A mutation is chosen among those that the path allows, in proportion to their weights; the probability of the choice is part of
//! T. Perturbations keep what decides which are allowed, so that it cancels there.
//!
//! Paths have at most [`MAX_VERTICES`] vertices; what longer ones carry is lost.

pub mod balance;
pub mod bidirectional;
pub mod candidate;
pub mod chain;
pub mod ends;
pub mod group;
pub mod perturbation;

pub use group::VeachChains;

use crate::path::whole::Path;

/// Most vertices of a path.
pub const MAX_VERTICES: usize = 32;

/// A path of a chain.
pub type ChainPath = Path<MAX_VERTICES>;
