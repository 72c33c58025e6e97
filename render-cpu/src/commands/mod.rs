//! The subcommands of `halflight`, one per file, and what they share.

pub mod chain_args;
pub mod compare;
pub mod convergence;
pub mod estimator_args;
pub mod experiment;
pub mod farm;
pub mod image;
pub mod info;
mod info_report;
pub mod interrupt;
pub mod list;
pub mod manual;
pub mod material;
pub mod merge;
mod output_file;
pub mod photon_args;
mod preview;
pub mod processor;
pub mod render;
pub mod render_args;
mod render_observer;
mod render_output;
mod render_state;
mod render_values;
pub mod scene_args;
pub mod strategy_sheet;
pub mod terminal;
