//! Progressive photon mapping: radii and statistics of the density estimate.
//!
//! | file | content |
//! |---|---|
//! | [`schedule`] | radii that shrink by a fixed rule |
//! | [`statistics`] | a radius per pixel from its own statistics: bias, variance, Laplacian |
//!
//! psi, p_l and Delta I of the papers are contribution, density and Laplacian in [`statistics`]. The kernels are those of
//! [`crate::regularize::mollifier`].

pub mod schedule;
pub mod statistics;
