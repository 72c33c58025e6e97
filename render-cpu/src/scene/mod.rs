//! From scene files to the kernel's tables.
//!
//! [`xml`] reads a Mitsuba scene into a tree of objects with typed properties, [`color`] turns spectra into linear
//! sRGB, [`ior`] holds indices of refraction by name, [`transform`] prepares matrices, and [`build`] fills the tables. Every
//! error is an [`error::SceneError`] with file, line and element.

pub mod build;
pub mod color;
pub mod daylight;
pub mod edits;
pub mod error;
pub mod file_cache;
pub mod ior;
pub mod tables;
pub mod transform;
pub mod xml;
