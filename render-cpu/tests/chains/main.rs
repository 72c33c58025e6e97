//! Metropolis algorithms on scenes from text: the image that other algorithms make, whatever the threads and interruptions.

#[path = "../bidirectional/agreement.rs"]
#[allow(dead_code)]
mod agreement;
mod areas;
mod brightness;
mod broken_up;
mod edited;
mod full_paths;
mod half_vectors;
mod hostile_scenes;
mod hotelling;
mod measures;
mod mollified;
mod path_tracing;
mod perturbations;
mod promises;
mod proposals;
mod replay;
mod returns;
#[path = "../bidirectional/scenes.rs"]
#[allow(dead_code)]
mod scenes;
mod stationary;
mod steps;
mod total;
mod tracing;
mod two_stages;
mod variants;
