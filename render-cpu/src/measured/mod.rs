//! Measured scattering functions: readers, and a synthetic measurement to show them with.

pub mod merl;
pub mod synthetic;
