//! Pictures of materials: a ball, and diagrams of how it scatters.
//!
//! [`source`] finds a BSDF by name or in a file, [`preview`] puts it on the material ball and renders that, [`curves`] samples
//! lobes, albedo and local roughness, [`sheet`] draws all of it; [`gallery`] draws the ball in the materials of [`examples`].

pub mod curves;
pub mod examples;
pub mod gallery;
pub mod preview;
pub mod sheet;
pub mod source;
