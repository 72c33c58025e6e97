//! Halflight.

pub mod accel;
pub mod adaptive;
pub mod aov;
pub mod atomic_file;
pub mod bytes;
pub mod checkpoint;
pub mod commands;
pub mod comparison;
pub mod exr_output;
pub mod film;
pub mod heatmap;
pub mod image_io;
pub mod image_metadata;
pub mod merge;
pub mod mesh;
pub mod metrics;
pub mod png_output;
pub mod progress;
pub mod render;
pub mod scene;
