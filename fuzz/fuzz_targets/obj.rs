//! Wavefront OBJ. Run with `cargo fuzz run obj`, see `Cargo.toml`.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = halflight::mesh::obj::read(data, true, Path::new("fuzz.obj"));
});
