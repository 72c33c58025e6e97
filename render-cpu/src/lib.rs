//! Halflight.

pub mod bytes;
pub mod image_io;
