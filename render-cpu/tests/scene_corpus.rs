//! Scenes that nobody here wrote, read as they are.
//!
//! Set `HALFLIGHT_CORPUS` to a folder with a `manifest.json`: a list of objects with `scene`, the path of a scene file
//! in the folder, and `params`, a map of parameters.

use std::path::PathBuf;

use halflight::scene::xml::parse_scene;

fn corpus() -> Option<PathBuf> {
    let folder = std::env::var_os("HALFLIGHT_CORPUS").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: HALFLIGHT_CORPUS is not set");
    }
    folder
}

#[test]
fn every_scene_parses_without_warnings() {
    let Some(folder) = corpus() else { return };
    let manifest = std::fs::read_to_string(folder.join("manifest.json")).expect("manifest.json");
    let entries: Vec<serde_json::Value> = serde_json::from_str(&manifest).expect("a list");
    assert!(!entries.is_empty());
    for entry in &entries {
        let scene = entry["scene"].as_str().expect("a path");
        let defines: Vec<(String, String)> = entry["params"]
            .as_object()
            .into_iter()
            .flatten()
            .map(|(name, value)| {
                (
                    name.clone(),
                    value.as_str().map_or(value.to_string(), str::to_owned),
                )
            })
            .collect();
        let parsed = parse_scene(&folder.join(scene), &defines, true)
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(parsed.warnings(), []);
        assert!(parsed.root.children().count() > 3);
    }
}
