//! PLY. Run with `cargo fuzz run ply`, see `Cargo.toml`.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let _ = halflight::mesh::ply::read(data, true, Path::new("fuzz.ply"));
});
