//! Mitsuba scene files. Run with `cargo fuzz run scene_xml`, see `Cargo.toml`.
#![no_main]

use std::path::Path;

use halflight::scene::color::ColorUse;
use halflight::scene::xml::{Object, parse_scene_from_str, unused};

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    // No such folder: the files that a scene names are not found.
    let path = Path::new("no such folder/fuzz.xml");
    if let Ok(scene) = parse_scene_from_str(text, path, &[], false) {
        for child in scene.root.children() {
            look(child.object);
        }
        let _ = unused::warn_unused(&scene.root);
    }
});

/// Reads every property of an object as a colour.
fn look(object: &Object) {
    for property in object.properties.iter() {
        for usage in [ColorUse::Reflectance, ColorUse::Emission, ColorUse::Unbounded] {
            if let Ok(Some(rgb)) = object.opt_rgb(&property.name, usage) {
                assert!(rgb.iter().all(|x| x.is_finite() && *x >= 0.0));
            }
        }
    }
}
