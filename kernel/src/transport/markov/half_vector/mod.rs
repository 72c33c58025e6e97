//! Mutations of paths in half-vector space, for chains of full paths.
//!
//! What half vectors, their constraints and walks are: [`crate::manifold`]. Here they meet real scenes:
//!
//! - [`path_chain`]: a path as a chain of half vectors;
//! - [`measure`]: what a path carries per half vectors;
//! - [`reconnection`], [`closing`]: walks between an end that has moved and one that stays;
//! - [`tracing`]: ends that move before;
//! - [`steps`]: steps of half vectors;
//! - [`verdict`]: acceptance, with the walk back at last;
//! - [`half_vector_mutation`]: half-vector space light transport, original and improved;
//! - [`manifold_perturbation`]: manifold exploration; [`plan`], [`direction_lobe`]: its choice of vertices, and of directions.

pub mod closing;
pub mod direction_lobe;
pub mod half_vector_mutation;
pub mod manifold_perturbation;
pub mod measure;
pub mod path_chain;
pub mod plan;
pub mod reconnection;
pub mod settings;
pub mod steps;
pub mod tracing;
pub mod verdict;

pub use settings::HalfVectorSettings;
