//! A folder of scenes, each rendered on the device and on the processor, as a table.
//!
//! `HALFLIGHT_CORPUS` names the folder; its `manifest.json` lists scenes with their parameters.
//! `HALFLIGHT_CORPUS_ONLY` is a part of the names, `HALFLIGHT_CORPUS_WIDTH` the width of the images (default 40), and with
//! `HALFLIGHT_CORPUS_VULKAN_STEP=N` only every Nth scene is taken: compiling the shaders of all takes many minutes. All must
//! agree. Without the folder or without a device the test is skipped.

mod common;
mod images;

use common::{device, skip};
use images::{compare, load};
use std::path::PathBuf;

#[test]
fn every_scene_is_the_processors() {
    let folder = std::env::var_os("HALFLIGHT_CORPUS").map(PathBuf::from);
    let folder = folder.ok_or("HALFLIGHT_CORPUS does not name a folder of scenes");
    let Some(folder) = skip::available(folder, "HALFLIGHT_REQUIRE_CORPUS") else {
        return;
    };
    let Some(device) = device() else { return };
    let only = std::env::var("HALFLIGHT_CORPUS_ONLY").unwrap_or_default();
    let width = std::env::var("HALFLIGHT_CORPUS_WIDTH")
        .map_or(40, |width| width.parse().expect("a width in pixels"));
    let every = std::env::var("HALFLIGHT_CORPUS_VULKAN_STEP")
        .map_or(1, |step| step.parse().expect("a number of scenes"));
    let text = std::fs::read_to_string(folder.join("manifest.json")).expect("a manifest");
    let manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let text = |value: &serde_json::Value| match value {
        serde_json::Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    println!("| scene | mean difference | pixels outside | ready (s) | samples (s) |");
    println!("|---|---|---|---|---|");
    let mut failed = Vec::new();
    for entry in manifest.as_array().expect("a list").iter().step_by(every) {
        let name = text(&entry["name"]);
        if !name.contains(&only) {
            continue;
        }
        let defines = entry["params"]
            .as_object()
            .expect("parameters")
            .iter()
            .map(|(name, value)| (name.clone(), text(value)))
            .collect();
        let scene = load(&folder.join(text(&entry["scene"])), width, None, defines);
        match compare(&device, &scene, 2) {
            Ok(d) => {
                println!(
                    "| {name} | {:.1e} | {:.2} % | {:.1} | {:.1} |",
                    d.mean,
                    100.0 * d.outside,
                    d.ready,
                    d.seconds
                );
                if !d.is_small() {
                    failed.push(name);
                }
            }
            Err(error) => {
                println!("| {name} | {error} | | | |");
                failed.push(name);
            }
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}
