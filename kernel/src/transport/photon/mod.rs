//! Photon mapping: a cache of photons, algorithms over it, radii and statistics of the density estimate.
//!
//! | file | content |
//! |---|---|
//! | [`cache`] | photons, sorted to be found |
//! | [`tracing`] | light walks that leave photons |
//! | [`estimate`] | the density estimate at a vertex |
//! | [`merging`] | vertex merging |
//! | [`nearest`] | the distance to the k-th nearest photon |
//! | [`progressive`] | progressive photon mapping |
//! | `metropolis` | light walks that leave photons where camera walks look (hosts only) |
//! | [`adaptive`] | a radius for each pixel |
//! | [`schedule`] | radii that shrink by a fixed rule |
//! | [`statistics`] | a radius per pixel from its own statistics: bias, variance, Laplacian |
//!
//! psi, p_l and Delta I of the papers are contribution, density and Laplacian in [`statistics`]. The kernels are those of
//! [`crate::regularize::mollifier`].

pub mod adaptive;
pub mod cache;
pub mod divided;
pub mod estimate;
pub mod merging;
// Its chains are long records.
#[cfg(not(target_arch = "spirv"))]
pub mod metropolis;
pub mod nearest;
pub mod progressive;
pub mod schedule;
pub mod statistics;
pub mod tracing;
