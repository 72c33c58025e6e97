//! Pictures of materials: a ball, and diagrams of how it scatters.
//!
//! [`source`] finds the BSDF that a person means, [`preview`] puts it on the material ball and renders that, [`curves`]
//! samples lobes, albedo and local roughness, [`sheet`] draws all of it, and [`gallery`] draws the ball in many materials.

pub mod curves;
pub mod examples;
pub mod gallery;
pub mod preview;
pub mod sheet;
pub mod source;
