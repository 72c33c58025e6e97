//! Light transport with edits ([`crate::path::retarget`]; Kaplanyan 2017, section 9.2).
//!
//! - [`path`]: path tracing;
//! - [`bidirectional`]: the walks of bidirectional path tracing, light tracing and vertex merging;
//! - `connections`: what completes their paths;
//! - [`photons`]: photons that are merged, and the camera walks of progressive photon mapping;
//! - [`bounce`]: what a bounce of such walks does, those of photons too.
//!
//! Bounces are those of the algorithms without edits, with guesses where a walk goes against the flow that is turned, and with one
//! connection for each label that its ends allow. Invariants (tests): without edits that apply the images are those of the
//! algorithms to the bit; with edits all have the same mean.
//!
//! Hosts only, as edits are.

pub mod bidirectional;
pub mod bounce;
mod connections;
pub mod path;
pub mod photons;
