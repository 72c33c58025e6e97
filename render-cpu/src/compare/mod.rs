//! How two images differ: metrics, a comparison of two files by all of them, and error maps as pictures.

pub mod comparison;
pub mod heatmap;
pub mod metrics;
