//! Measured scattering functions: readers, and synthetic measurements to show them with.

pub mod merl;
pub mod rgl;
pub mod synthetic;
pub mod tensor_file;
