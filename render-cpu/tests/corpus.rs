//! Scenes that nobody here wrote, against another renderer's images.
//!
//! `HALFLIGHT_CORPUS` names a folder with `manifest.json`: scenes, film widths, parameters, and reference images with the
//! variance of their mean. Each scene must load without a warning and pass the z-test of `halflight compare` at a
//! false-alarm rate of 1e-3 per image; at least 95 % must pass. `HALFLIGHT_CORPUS_SPP` sets the samples per pixel
//! (default 64; the references have 1024 and more), `HALFLIGHT_CORPUS_ONLY` a part of the names.
//!
//! Without the variable the test is skipped; with `HALFLIGHT_REQUIRE_CORPUS` set that is a failure.

#[path = "common/skip.rs"]
mod skip;

use halflight::compare::metrics::RgbImage;
use halflight::compare::metrics::ztest::{Estimate, Outcome, Settings, ztest};
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::image::read_exr;
use halflight::render::{Goal, RenderOptions, render_film};
use halflight::scene::build::{BuildOptions, FilmOverride, build_scene};
use halflight::scene::xml::parse_scene;
use std::path::{Path, PathBuf};

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

/// Share of the scenes that must pass.
const LEAST_SHARE: f64 = 0.95;

struct Entry {
    name: String,
    scene: PathBuf,
    reference: PathBuf,
    width: u32,
    spp: f64,
    runs: f64,
    defines: Vec<(String, String)>,
}

fn entries(folder: &Path) -> Vec<Entry> {
    let text = std::fs::read_to_string(folder.join("manifest.json")).expect("a manifest");
    let manifest: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let only = std::env::var("HALFLIGHT_CORPUS_ONLY").unwrap_or_default();
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
            reference: folder.join(text(&entry["reference"])),
            width: entry["width"].as_u64().expect("a width") as u32,
            spp: entry["reference_spp"].as_f64().expect("a number"),
            runs: entry["reference_runs"].as_f64().expect("a number"),
            defines: entry["params"]
                .as_object()
                .expect("parameters")
                .iter()
                .map(|(name, value)| (name.clone(), text(value)))
                .collect(),
        })
        .filter(|entry| entry.name.contains(&only))
        .collect()
}

/// Renders an entry; the warnings that it gave, the film and the comparison.
fn compare(entry: &Entry, spp: u32) -> Result<(Vec<String>, Outcome), String> {
    let parsed = parse_scene(&entry.scene, &entry.defines, false).map_err(|e| e.to_string())?;
    let scene = build_scene(
        &parsed,
        &BuildOptions {
            film: FilmOverride {
                width: Some(entry.width),
                ..FilmOverride::default()
            },
            // Samples that know of each other have less variance than the film can tell.
            sampler: Some("independent".into()),
            ..BuildOptions::default()
        },
    )
    .map_err(|e| e.to_string())?;
    let options = RenderOptions {
        goal: Goal::Samples(spp),
        seed: 1,
        first_sample: 0,
        adaptive: false,
    };
    let film = render_film(&scene, &options, AovSet::NONE).map_err(|e| e.to_string())?;
    let warnings = scene.warnings.iter().map(ToString::to_string).collect();
    let reference = read_exr(&entry.reference).map_err(|e| e.to_string())?;
    let size = (reference.width as usize, reference.height as usize);
    let channels = |names: [&str; 3]| -> Result<RgbImage, String> {
        let planes = names.map(|name| reference.channel(name));
        let [Some(r), Some(g), Some(b)] = planes else {
            return Err(format!("{} lacks {names:?}", entry.reference.display()));
        };
        let pixels = (0..r.len())
            .map(|i| [r[i], g[i], b[i]].map(f64::from))
            .collect();
        Ok(RgbImage::new(size.0, size.1, pixels))
    };
    let (width, height) = (film.width() as usize, film.height() as usize);
    if (width, height) != size {
        return Err(format!(
            "{width} x {height} pixels against {} x {}",
            size.0, size.1
        ));
    }
    let outcome = test_film(
        &film,
        &channels(["R", "G", "B"])?,
        &channels(["variance.R", "variance.G", "variance.B"])?,
        entry,
        spp,
    );
    Ok((warnings, outcome))
}

fn test_film(
    film: &Film,
    mean: &RgbImage,
    variance: &RgbImage,
    entry: &Entry,
    spp: u32,
) -> Outcome {
    let image = |pixels| RgbImage::new(mean.width, mean.height, pixels);
    ztest(
        Estimate {
            mean: &image(film.mean()),
            variance: &image(film.variance_of_mean()),
            degrees_of_freedom: f64::from(spp) - 1.0,
            samples: Some(f64::from(spp)),
        },
        Estimate {
            mean,
            variance,
            degrees_of_freedom: entry.runs - 1.0,
            samples: Some(entry.spp),
        },
        Settings::default(),
    )
}

#[test]
fn other_peoples_scenes_agree_with_another_renderer() {
    let folder = std::env::var_os("HALFLIGHT_CORPUS");
    let folder = folder.ok_or("HALFLIGHT_CORPUS does not name a folder of scenes");
    let Some(folder) = skip::available(folder, "HALFLIGHT_REQUIRE_CORPUS") else {
        return;
    };
    let spp = std::env::var("HALFLIGHT_CORPUS_SPP")
        .ok()
        .map_or(64, |text| text.parse().expect("a number of samples"));
    let mut passed = 0;
    let mut failures = Vec::new();
    let entries = entries(Path::new(&folder));
    assert!(!entries.is_empty(), "no scene to test");
    for entry in &entries {
        let known = EXPECTED_DIFFERENCES
            .iter()
            .find(|(name, _)| *name == entry.name);
        match compare(entry, spp) {
            Ok((warnings, outcome)) => {
                let verdict = if outcome.passes() { "pass" } else { "FAIL" };
                let levels = outcome
                    .levels
                    .map(|level| format!("{:.2}", level.severity()));
                println!(
                    "{verdict} {:40} severity of pixels, 8 x 8, 32 x 32, image: {}; mean z {:+.3}",
                    entry.name,
                    levels.join(" "),
                    outcome.mean_z
                );
                assert!(warnings.is_empty(), "{}: {warnings:?}", entry.name);
                if outcome.passes() {
                    passed += 1;
                } else if let Some((_, reason)) = known {
                    println!("     expected: {reason}");
                } else {
                    failures.push(entry.name.clone());
                }
            }
            Err(error) => panic!("{}: {error}", entry.name),
        }
    }
    let share = f64::from(passed) / entries.len() as f64;
    println!(
        "{passed} of {} pass at {spp} samples per pixel",
        entries.len()
    );
    assert!(
        failures.is_empty(),
        "differ without a known reason: {failures:?}"
    );
    assert!(
        share >= LEAST_SHARE || entries.len() < 20,
        "only {:.1} % pass",
        share * 100.0
    );
}
