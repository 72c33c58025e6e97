//! Ordinary scenes: every one must load without a warning, and at least 95 % of the images must pass at a false-alarm rate of
//! 1e-3 per image.

use super::{Entry, compare, folder, is_asked_for, load, number, read_reference, render, report};
use halflight_kernel::transport::integrator_kind;
use std::path::Path;

/// Scenes whose reference differs for a reason that lies in the other renderer, found by evaluating it directly
/// (Mitsuba 3.9.1).
const EXPECTED_DIFFERENCES: [(&str, &str); 2] = [
    (
        "scene-hello",
        "its `direct` integrator multiplies delta lights by emitter_samples, and its rotate does not normalise the axis",
    ),
    (
        "bsdf_roughconductor_textured_carbon",
        "its checkerboard swaps the two colours when it is looked up as a scalar",
    ),
];

/// Share of the images that must pass.
const LEAST_SHARE: f64 = 0.95;

fn entries(folder: &Path) -> Vec<Entry> {
    let text = std::fs::read_to_string(folder.join("manifest.json")).expect("a manifest");
    let manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let text = |value: &serde_json::Value| match value {
        serde_json::Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    manifest
        .as_array()
        .expect("a list")
        .iter()
        .map(|entry| Entry {
            name: text(&entry["name"]),
            scene: folder.join(text(&entry["scene"])),
            defines: entry["params"]
                .as_object()
                .expect("parameters")
                .iter()
                .map(|(name, value)| (name.clone(), text(value)))
                .collect(),
            width: Some(entry["width"].as_u64().expect("a width") as u32),
            reference: folder.join(text(&entry["reference"])),
            reference_spp: Some(entry["reference_spp"].as_f64().expect("a number")),
            reference_runs: entry["reference_runs"].as_f64().expect("a number"),
        })
        .filter(|entry| is_asked_for(&entry.name))
        .collect()
}

/// Renders the scenes by their own integrators, or those that trace paths by another, with the seeds.
fn agree(entries: &[Entry], integrator: Option<&str>, spp: u32, seeds: std::ops::Range<u32>) {
    let (mut passed, mut images) = (0, 0);
    let mut failures = Vec::new();
    for entry in entries {
        let error = |e: String| -> ! { panic!("{}: {e}", entry.name) };
        let own = load(entry, None).unwrap_or_else(|e| error(e));
        assert!(
            own.warnings.is_empty(),
            "{}: {:?}",
            entry.name,
            own.warnings
        );
        if integrator.is_some() && own.settings.kind != integrator_kind::PATH {
            println!("     {}: the reference is not of all light", entry.name);
            continue;
        }
        let scene = load(entry, integrator).unwrap_or_else(|e| error(e));
        let reference = read_reference(entry).unwrap_or_else(|e| error(e));
        let known = EXPECTED_DIFFERENCES
            .iter()
            .find(|(name, _)| *name == entry.name);
        for seed in seeds.clone() {
            images += 1;
            let outcome = compare(&render(&scene, spp, seed), &reference);
            if report(&format!("{} seed {seed}", entry.name), &outcome) {
                passed += 1;
            } else if let Some((_, reason)) = known {
                println!("     expected: {reason}");
            } else {
                failures.push(format!("{} seed {seed}", entry.name));
            }
        }
    }
    println!("{passed} of {images} pass at {spp} samples per pixel");
    let unexpected = failures.len() as f64 / f64::from(images.max(1));
    assert!(
        unexpected <= 1.0 - LEAST_SHARE && (failures.is_empty() || images >= 20),
        "differ without a known reason: {failures:?}"
    );
}

#[test]
fn path_tracing() {
    if let Some(folder) = folder("HALFLIGHT_CORPUS") {
        let entries = entries(&folder);
        assert!(!entries.is_empty(), "no scene to test");
        agree(&entries, None, number("HALFLIGHT_CORPUS_SPP", 64), 1..2);
    }
}

/// Every algorithm that makes an image of all light.
fn by(integrator: &str) {
    if let Some(folder) = folder("HALFLIGHT_CORPUS") {
        let step = number("HALFLIGHT_CORPUS_STEP", 1) as usize;
        let entries: Vec<_> = entries(&folder).into_iter().step_by(step).collect();
        assert!(!entries.is_empty(), "no scene to test");
        let seeds = number("HALFLIGHT_CORPUS_SEEDS", 1);
        let spp = number("HALFLIGHT_CORPUS_SPP", 64).min(24);
        agree(&entries, Some(integrator), spp, 1..1 + seeds);
    }
}

#[test]
fn bidirectional_path_tracing() {
    by("bdpt");
}
