//! Mutations of full paths on small scenes with poles: see the module that the tests of chains share.
#![no_main]

#[path = "../../render-cpu/tests/chains/hostile_scenes.rs"]
mod hostile_scenes;

use libfuzzer_sys::fuzz_target;
use std::path::PathBuf;
use std::sync::LazyLock;

/// The mesh of the scenes lies here.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = std::env::temp_dir().join("halflight-fuzz-mutations");
    let (name, text) = hostile_scenes::MESH;
    let written =
        std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(folder.join(name), text));
    written.expect("room for a mesh");
    folder
});

fuzz_target!(|bytes: &[u8]| {
    hostile_scenes::check(bytes, &FOLDER);
});
