//! OpenEXR with all layers. Run with `cargo fuzz run exr`, see `Cargo.toml`.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(
    // The reader turns panics of the decoder into errors; libFuzzer's hook would abort before it can.
    init: { let _ = std::panic::take_hook(); },
    |data: &[u8]| {
        let _ = halflight::image::read_exr_bytes(data, Path::new("fuzz.exr"));
    }
);
