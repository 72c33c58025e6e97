//! Path tracing and direct illumination on the device give the processor's image.

mod common;
mod images;

use common::device;
use images::{compare, load};
use std::path::Path;

fn agrees(name: &str, integrator: &str, width: u32, spp: u32) {
    let Some(device) = device() else { return };
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../render-cpu/scenes")
        .join(name);
    let scene = load(&path, width, Some(integrator), Vec::new());
    compare(&device, &scene, spp)
        .expect("an image")
        .assert_small(name);
}

/// Diffuse walls and a diffuse box: inter-reflection, Russian roulette, an area light.
#[test]
fn path_tracing_of_a_diffuse_scene() {
    agrees("cornell-box.xml", "path", 48, 4);
}

/// Refraction, an analytic shape and paths that only the walk finds.
#[test]
fn path_tracing_through_glass() {
    agrees("glass-sphere.xml", "path", 48, 4);
}

/// Branches that look behind surfaces, with emitter and BSDF samples.
#[test]
fn direct_illumination() {
    agrees("cornell-box.xml", "direct", 48, 4);
}
