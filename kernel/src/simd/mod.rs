//! Data parallelism on processors: structures of arrays, and loops over them compiled per instruction set.
//!
//! [`lanes`] holds the arrays; the macro `multiversioned!` of [`multiversion`] defines functions that loop over them once for
//! the instruction set that the crate is compiled for and once for AVX-512.
//!
//! Hosts only: the lanes of a shader are the device's own.

pub mod lanes;
pub mod multiversion;

pub use multiversion::SimdLevel;
pub(crate) use multiversion::multiversioned;
