//! Halflight on the CPU: scene files in, images out.
//!
//! The mathematics is in `halflight-kernel`; this crate reads scenes, meshes and images ([`scene`], [`mesh`],
//! [`image`]), traces rays ([`accel`]), drives samples over threads ([`mod@render`]), keeps them ([`film`]), and
//! writes, merges and compares images ([`image`], [`compare`]), divides them by path expressions ([`expression`]), and one image
//! among machines ([`farm`]).
//! The command `halflight` is [`commands`].
//!
//! ```
//! use halflight::film::aov::AovSet;
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
pub mod atomic_file;
pub mod bytes;
pub mod commands;
pub mod compare;
pub mod experiment;
pub mod expression;
pub mod farm;
pub mod film;
pub mod image;
pub mod inspect;
pub mod integrators;
pub mod material;
pub mod measured;
pub mod mesh;
pub mod plot;
pub mod processor;
pub mod render;
pub mod run_lock;
pub mod say;
pub mod scene;
pub mod source_stamp;
