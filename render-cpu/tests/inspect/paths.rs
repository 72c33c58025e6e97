//! The picture of path bundles, and which recorded paths an expression matches.

use crate::records::{CHOICE, lit_ball, recorded};
use halflight::expression::{PartsRequest, PathParts};
use halflight::inspect::paths::matching::matched;
use std::process::Command;

#[test]
fn expressions_match_recorded_paths_as_they_match_walks() {
    let scene = lit_ball();
    let everything = recorded(&scene, None, &CHOICE);
    for text in [
        "L D E",
        "L[sky] S^T{2} D E",
        "O .* E",
        "L .* X[ball] D{floor} E",
    ] {
        let request = PartsRequest {
            layers: Vec::new(),
            only: Some(text.to_owned()),
        };
        let parts = PathParts::new(&request, &scene.tables.view(), &scene.names).unwrap();
        let expressions = parts.view().unwrap();
        let own: f64 = (everything.paths.iter())
            .filter(|p| matched(&expressions, p) == 1)
            .map(|p| f64::from(p.weight))
            .sum();
        // What walks have matched, all of it; the share of a choice of 4000 paths varies by a fiftieth.
        let share =
            recorded(&scene, Some(text), &CHOICE).header.luminance / everything.header.luminance;
        let found = own / everything.header.luminance;
        assert!(
            share > 0.001 && (found - share).abs() < 0.02,
            "{text}: {found} {share}"
        );
        let only = recorded(&scene, Some(text), &CHOICE);
        assert!(
            only.paths.iter().all(|p| matched(&expressions, p) == 1),
            "{text}"
        );
    }
}

#[test]
fn the_command_draws_bundles_and_prints_clusters() {
    let folder = tempfile::tempdir().unwrap();
    let text = format!(
        "<scene version=\"3.0.0\">{}</scene>",
        crate::records::lit_ball_text()
    );
    std::fs::write(folder.path().join("s.xml"), text).unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halflight"));
        command.args(arguments).current_dir(folder.path());
        let output = command.output().unwrap();
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        (
            output.status.success(),
            String::from_utf8(output.stdout).unwrap(),
            error,
        )
    };
    let (ok, _, error) = run(&[
        "render", "s.xml", "--spp", "16", "--record", "p.bin", "-o", "o.exr",
    ]);
    assert!(ok, "{error}");
    let tool = [
        "inspect", "s.xml", "--tool", "paths", "--json", "--width", "60", "--spp", "4", "-o",
    ];
    let (ok, json, error) = run(&[&tool[..], &["a.png", "--paths", "p.bin"]].concat());
    assert!(ok, "{error}");
    let tree: serde_json::Value = serde_json::from_str(&json).unwrap();
    let sum: f64 = (tree["children"].as_array().unwrap().iter())
        .map(|c| c["weight"].as_f64().unwrap())
        .sum();
    assert!((sum / tree["weight"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    let (ok, _, error) = run(&[
        &tool[..],
        &["b.png", "--paths", "p.bin", "--only", "L S+ D E"],
    ]
    .concat());
    assert!(ok && error.contains("bundles"), "{error}");
    let picture = |name: &str| image::open(folder.path().join(name)).unwrap().to_rgb8();
    let (all, some) = (picture("a.png"), picture("b.png"));
    let colored = |p: &image::RgbImage| {
        let is_amber = |c: &&image::Rgb<u8>| c.0[0] > 180 && c.0[2] < 80;
        p.pixels().filter(is_amber).count()
    };
    assert!(all != some && colored(&all) > 50 && colored(&some) > 50);
    let (ok, _, error) = run(&[&tool[..], &["c.png", "--paths", "s.xml"]].concat());
    assert!(
        !ok && error.contains("s.xml: this is no record of paths"),
        "{error}"
    );
}
