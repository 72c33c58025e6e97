//! Scenes whose light path tracing loses. References of path tracing have independent pixels; those of Markov chains understate
//! their variance where chains seldom go, so where there is no other the reference is our own path tracing, with
//! [`PATH_SAMPLES`] times as many samples.

use super::{Entry, compare, folder, is_asked_for, load, number, read_reference, render, report};
use std::path::Path;

/// Scenes and the samples per pixel of their path-traced references, where there is one.
const SCENES: [(&str, Option<f64>); 6] = [
    ("torus", Some(2048.0)),
    ("glass-sphere-lamp", Some(2048.0)),
    ("veach-bidir", None),
    ("ring", Some(2048.0)),
    ("glossy-chain", Some(2048.0)),
    ("door-ajar", Some(2048.0)),
];

/// Samples of our own path tracing per sample that is tested.
const PATH_SAMPLES: u32 = 16;

fn entries(folder: &Path) -> Vec<Entry> {
    SCENES
        .iter()
        .filter(|(name, _)| is_asked_for(name))
        .map(|(name, spp)| Entry {
            name: (*name).into(),
            scene: folder.join(name).join("scene.xml"),
            defines: Vec::new(),
            width: None,
            reference: folder.join(format!("reference/mitsuba3/{name}.exr")),
            reference_spp: *spp,
            reference_runs: 8.0,
        })
        .collect()
}

fn by(integrator: &str) {
    let Some(folder) = folder("HALFLIGHT_HARD") else {
        return;
    };
    let spp = number("HALFLIGHT_HARD_SPP", 32);
    let mut failures = Vec::new();
    for entry in entries(&folder) {
        let error = |e: String| -> ! { panic!("{}: {e}", entry.name) };
        let scene = load(&entry, Some(integrator)).unwrap_or_else(|e| error(e));
        let reference = if entry.reference_spp.is_some() {
            read_reference(&entry).unwrap_or_else(|e| error(e))
        } else {
            let path = load(&entry, Some("path")).unwrap_or_else(|e| error(e));
            render(&path, PATH_SAMPLES * spp, 1000)
        };
        for seed in 1..1 + number("HALFLIGHT_CORPUS_SEEDS", 1) {
            let outcome = compare(&render(&scene, spp, seed), &reference);
            let what = format!("{} {integrator} seed {seed}", entry.name);
            if !report(&what, &outcome) {
                failures.push(what);
            }
        }
    }
    assert!(failures.is_empty(), "differ: {failures:?}");
}

#[test]
fn path_tracing() {
    by("path");
}

#[test]
fn bidirectional_path_tracing() {
    by("bdpt");
}
