//! Bidirectional path tracing and the path layer on scenes from text.

mod scenes;
mod strategy_films;
mod weights;
