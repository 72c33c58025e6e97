//! Regularisation in path tracing, bidirectional path tracing, and vertex connection and merging.

mod full_paths;
mod known_answers;
mod layers;
mod merged;
mod near_specular;
mod no_harm;
mod panel;
mod scenes;
#[path = "../common/vertices.rs"]
mod vertices;
#[path = "../common/view.rs"]
mod view;
mod weights;
