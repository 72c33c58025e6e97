//! Veach's Metropolis light transport: mutations of full paths (Veach 1997, chapter 11; Veach and Guibas 1997).
//!
//! - [`bidirectional`]: part of the path is deleted and replaced by walks from both of its ends;
//! - [`perturbation`], [`lens_perturbation`], [`caustic_perturbation`]: the vertices of one end of a path move a little, through the
//!   same discrete events;
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
pub mod caustic_perturbation;
pub mod chain;
pub mod ends;
pub mod group;
pub mod lens_perturbation;
pub mod perturbation;

pub use group::VeachChains;

use crate::path::full_path::Path;

/// Most vertices of a path.
pub const MAX_VERTICES: usize = 32;

/// A path of a chain.
pub type ChainPath = Path<MAX_VERTICES>;
