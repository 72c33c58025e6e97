//! From a scene to a film: the run loop, what takes its samples, and what tells about its progress.
//!
//! [`run_loop`] asks a [`Backend`] for passes of samples until a [`Goal`] is reached; [`CpuBackend`] takes them on all
//! threads, a tile of the film at a time (`tile_job`).

mod backend;
mod bidirectional_job;
mod chains;
mod checkpoint_file;
mod cpu_backend;
mod divided_layers;
mod division;
mod film_tiles;
mod first_radii;
mod followed_samples;
mod layer_photons;
mod lockstep_walks;
mod options;
mod own_layers;
mod pass_context;
mod passes;
mod photon_cache;
mod photon_job;
mod photon_pass;
mod photon_statistics;
mod pilot;
pub mod progress;
pub mod record;
mod regularized_paths;
pub mod run_loop;
mod splat;
mod splatting;
mod stop;
mod strategy_films;
mod surface_sample;
mod tile_job;

pub use crate::integrators::{Shape, divides_paths, shape};
pub use backend::{Backend, PassEnd, PassError};
pub use chains::MutationsPerPixel;
pub use checkpoint_file::CheckpointFile;
pub use cpu_backend::{CpuBackend, render, render_film};
pub use options::{Goal, Outcome, RenderOptions, RunState};
pub use own_layers::own_layers;
pub use photon_cache::{PhotonList, SortedPhotons};
pub use run_loop::{NoObserver, Observer, render_with};
pub use stop::Stop;
pub use strategy_films::{StrategyBackend, StrategyPyramid};
