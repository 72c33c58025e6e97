//! Scenes that nobody here wrote, read as they are.
//!
//! Set `HALFLIGHT_CORPUS` to a folder with a `manifest.json`: a list of objects with `scene`, the path of a scene file
//! in the folder, and `params`, a map of parameters.

#[path = "common/skip.rs"]
mod skip;

use std::path::PathBuf;

use halflight::scene::color::ColorUse;
use halflight::scene::xml::{Object, ObjectKind, ParsedScene, Value, parse_scene};

/// Every scene of the corpus, read strictly.
fn scenes() -> Option<Vec<ParsedScene>> {
    let folder = std::env::var_os("HALFLIGHT_CORPUS").map(PathBuf::from);
    let folder = folder.ok_or("HALFLIGHT_CORPUS does not name a folder of scenes");
    let folder = skip::available(folder, "HALFLIGHT_REQUIRE_CORPUS")?;
    let manifest = std::fs::read_to_string(folder.join("manifest.json")).expect("manifest.json");
    let entries: Vec<serde_json::Value> = serde_json::from_str(&manifest).expect("a list");
    assert!(!entries.is_empty());
    let read = |entry: &serde_json::Value| {
        let scene = entry["scene"].as_str().expect("a path");
        let text =
            |value: &serde_json::Value| value.as_str().map_or(value.to_string(), str::to_owned);
        let parameters = entry["params"].as_object().into_iter().flatten();
        let defines: Vec<_> = parameters
            .map(|(name, value)| (name.clone(), text(value)))
            .collect();
        parse_scene(&folder.join(scene), &defines, true).unwrap_or_else(|error| panic!("{error}"))
    };
    Some(entries.iter().map(read).collect())
}

#[test]
fn every_scene_parses_without_warnings() {
    let Some(scenes) = scenes() else { return };
    for scene in scenes {
        assert_eq!(scene.warnings(), []);
        for kind in [ObjectKind::Sensor, ObjectKind::Integrator] {
            assert!(
                scene
                    .root
                    .single_child_of(kind)
                    .expect("at most one")
                    .is_some()
            );
        }
        assert!(scene.root.children_of(ObjectKind::Shape).count() > 0);
    }
}

#[test]
fn every_colour_is_in_gamut() {
    fn look(object: &Object, inside_emitter: bool, count: &mut usize) {
        let inside_emitter = inside_emitter || object.kind == ObjectKind::Emitter;
        for property in object.properties.iter() {
            let unbounded = matches!(property.name.as_str(), "eta" | "k");
            let usage = match (inside_emitter, unbounded) {
                (true, _) => ColorUse::Emission,
                (_, true) => ColorUse::Unbounded,
                _ => ColorUse::Reflectance,
            };
            match &property.value {
                Value::Rgb(_) | Value::Spectrum(_) => {
                    object
                        .opt_rgb(&property.name, usage)
                        .unwrap_or_else(|error| panic!("{error}"));
                    *count += 1;
                }
                Value::Object(child) => look(child, inside_emitter, count),
                _ => {}
            }
        }
    }
    let Some(scenes) = scenes() else { return };
    let mut count = 0;
    for scene in scenes {
        look(&scene.root, false, &mut count);
        assert_eq!(scene.warnings(), []);
    }
    assert!(count > 100);
}
