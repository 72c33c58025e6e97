//! Options of Markov chains, their maps, and what their images say of them.

use super::interruption::kill_and_resume;
use super::{Place, SCENE};
use std::time::Duration;

/// The room with small groups of chains.
fn place(integrator: &str) -> Place {
    let place = Place::with_scene();
    let own =
        format!(r#"<integrator type="{integrator}"><integer name="group_mutations" value="16"/>"#);
    place.write(
        "chains.xml",
        SCENE.replace(r#"<integrator type="path">"#, &own),
    );
    place
}

#[test]
fn half_vector_options_and_maps_are_taken() {
    let place = place("hslt");
    let layers = "acceptance,iterations,jumps,mutations";
    let mut common = vec![
        "render",
        "chains.xml",
        "--spp",
        "32",
        "--no-png",
        "--aov",
        layers,
    ];
    common.extend(["--json", "-o"]);
    let mut images = vec![];
    for (name, own) in [
        ("a.exr", vec![]),
        ("b.exr", vec!["--hslt", "original"]),
        (
            "c.exr",
            vec!["--roughness", "global", "--half-vectors", "projected"],
        ),
        (
            "d.exr",
            vec![
                "--hslt",
                "improved",
                "--roughness",
                "local",
                "--half-vectors",
                "slopes",
            ],
        ),
    ] {
        let text = place.succeed(&[&common[..], &[name], &own].concat());
        let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let counts = &report["mutations"]["half-vector"];
        assert!(counts["accepted"].as_u64() > Some(100), "{counts}");
        assert!(counts["walks"]["found"].as_u64() > Some(100), "{counts}");
        let channels = place.channels(name);
        for layer in layers.split(',') {
            assert!(channels.iter().any(|(name, _)| name == layer), "{layer}");
        }
        let attributes = super::read(&place.path(name)).attributes;
        let found = attributes.iter().find(|(name, _)| name == "mutations");
        assert!(found.is_some_and(|(_, text)| text.contains("half-vector")));
        images.push(channels);
    }
    // The last names the defaults.
    assert_eq!(images[0], images[3]);
    assert!(images[0] != images[1] && images[0] != images[2]);
}

#[test]
fn names_of_plugins_choose_mutations() {
    for (integrator, mutation) in [
        ("memlt", "manifold"),
        ("meerpt", "manifold"),
        ("hslt", "half-vector"),
    ] {
        let place = place(integrator);
        let arguments = ["render", "chains.xml", "--spp", "16", "--no-png", "--json"];
        let text = place.succeed(&arguments);
        let report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        let counts = report["mutations"].as_object().expect("counts");
        let names: Vec<_> = counts.keys().map(String::as_str).collect();
        let expected = if integrator == "meerpt" {
            vec![mutation]
        } else {
            vec!["bidirectional", mutation]
        };
        assert_eq!(names, expected, "{integrator}");
        let rays = report["rays_per_mutation"].as_f64();
        assert!(rays > Some(1.0) && rays < Some(100.0), "{rays:?}");
    }
}

#[test]
fn options_of_other_algorithms_are_refused() {
    let place = place("mlt");
    for (arguments, part) in [
        (vec!["--hslt", "original"], "half-vector mutation"),
        (vec!["--roughness", "global"], "half-vector mutation"),
        (
            vec!["--integrator", "path", "--aov", "acceptance"],
            "chains of whole paths",
        ),
    ] {
        let all = [&["render", "chains.xml"], &arguments[..]].concat();
        let output = place.run(&all);
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{all:?}: {text}");
        assert!(text.contains(part), "{text}");
    }
}

#[test]
fn killed_chains_resume_to_the_same_bits_and_counts() {
    for (integrator, delay) in [("mlt", 0), ("pssmlt", 70), ("hslt", 130)] {
        let place = place(integrator);
        let delay = Duration::from_millis(delay);
        kill_and_resume(&place, ["chains.xml", "16"], "-KILL", delay, &[]);
        let counts = |name: &str| {
            let attributes = super::read(&place.path(name)).attributes;
            let found = attributes.into_iter().find(|(name, _)| name == "mutations");
            found.expect("counts of mutations").1
        };
        assert_eq!(
            counts("resumed.exr"),
            counts("straight.exr"),
            "{integrator}"
        );
    }
}

/// Sums of layers stand beside those of maps in the film.
#[test]
fn layers_of_expressions_leave_maps_as_they_are() {
    let place = place("mlt");
    let common = ["render", "chains.xml", "--spp", "16", "--no-png"];
    let maps = [
        "--direct-samples",
        "0",
        "--aov",
        "acceptance,iterations,jumps",
        "-o",
    ];
    let common = [&common[..], &maps].concat();
    place.succeed(&[&common[..], &["alone.exr"]].concat());
    let layers = [
        "beside.exr",
        "--lpe",
        "direct=L D E",
        "--lpe",
        "rest=L X X+ E",
    ];
    place.succeed(&[&common[..], &layers].concat());
    let (alone, beside) = (place.channels("alone.exr"), place.channels("beside.exr"));
    for name in ["acceptance", "iterations", "jumps"] {
        let of = |channels: &[(String, Vec<u32>)]| {
            let found = channels.iter().find(|(n, _)| n == name);
            found.expect("a map").1.clone()
        };
        assert_eq!(of(&alone), of(&beside), "{name}");
    }
}
