//! Readers of measured scattering functions.

pub mod merl;
