//! Waves of paths give what single paths do, to the bit.

mod any_scene;
mod cameras;
mod emitters;
mod files;
mod geometry;
mod integrators;
mod materials;
mod room;
mod samples;
mod sizes;
mod textures;
#[path = "../common/view.rs"]
mod view;
