//! Halflight on the CPU: scene files in, images out.
//!
//! The mathematics is in `halflight-kernel`; this crate reads scenes, meshes and images ([`scene`], [`mesh`],
//! [`image_io`]), traces rays ([`accel`]), drives samples over threads ([`mod@render`], [`adaptive`]), keeps them
//! ([`film`], [`checkpoint`]), and writes and judges images ([`exr_output`], [`png_output`], [`metrics`], [`merge`]).
//! The command `halflight` is [`commands`].
//!
//! ```
//! use halflight::aov::AovSet;
//! use halflight::render::{Goal, RenderOptions, render_film};
//! use halflight::scene::build::{BuildOptions, build_scene};
//! use halflight::scene::xml::parse_scene;
//!
//! let parsed = parse_scene("scenes/cornell-box.xml".as_ref(), &[], false)?;
//! let mut options = BuildOptions::default();
//! options.film.width = Some(16);
//! let scene = build_scene(&parsed, &options)?;
//! let goal = Goal::Samples(4);
//! let film = render_film(&scene, &RenderOptions { goal, seed: 0, first_sample: 0, adaptive: false }, AovSet::NONE)?;
//! assert!(film.mean().iter().any(|pixel| pixel[0] > 0.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod accel;
pub mod adaptive;
pub mod aov;
pub mod atomic_file;
pub mod bytes;
pub mod checkpoint;
pub mod commands;
pub mod comparison;
pub mod experiment;
pub mod exr_output;
pub mod film;
pub mod heatmap;
pub mod image_io;
pub mod image_metadata;
pub mod material;
pub mod measured;
pub mod merge;
pub mod mesh;
pub mod metrics;
pub mod pixel_statistics;
pub mod plot;
pub mod png_output;
pub mod processor;
pub mod progress;
pub mod render;
pub mod scene;
mod tile_job;
