//! PNG, JPEG, BMP, TGA, HDR and EXR textures. Run with `cargo fuzz run bitmap`, see `Cargo.toml`.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(
    // The OpenEXR reader turns panics of its decoder into errors; libFuzzer's hook would abort before it can.
    init: { let _ = std::panic::take_hook(); },
    |data: &[u8]| {
        // The name makes what has no magic number a TGA.
        let _ = halflight::image::read_bitmap(data, false, Path::new("fuzz.tga"));
    }
);
