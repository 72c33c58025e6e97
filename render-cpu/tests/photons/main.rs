//! Photon mapping: the cache against brute force, images against what is known of them, passes as pieces of a run.

mod cache;
mod images;
mod passes;
mod scenes;
