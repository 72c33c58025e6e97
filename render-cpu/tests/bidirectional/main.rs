//! Bidirectional path tracing and the path layer on scenes from text.

mod agreement;
mod case;
mod densities;
mod features;
mod interfaces;
mod masks;
mod matrix;
mod reverse;
mod scenes;
mod single_strategies;
mod strategy_films;
mod weight_counts;
mod weight_samples;
mod weights;
