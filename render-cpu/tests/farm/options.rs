//! Options of `halflight render` that change the image reach the tasks of a farm.

use super::Place;
use std::collections::BTreeSet;
use std::process::{Command, Output};

/// Options that do not change the image, or cannot be divided, each with the reason.
const NOT_FOR_FARMS: &[(&str, &str)] = &[
    ("time", "a share ends with its samples"),
    ("samples", "the shares are the farm's"),
    ("adaptive", "where samples go depends on all tasks"),
    ("threads", "of farm task"),
    ("checkpoint", "each task has its own"),
    ("checkpoint-interval", "of farm task"),
    ("resume", "tasks go on by themselves"),
    ("png", "the default"),
    ("live", "nothing is shown"),
    ("tev", "nothing is shown"),
    ("json", "nothing is printed"),
    ("strategy-sheet", "a picture of its own"),
    ("sheet-length", "of that picture"),
    ("record", "a file of its own, which one process writes"),
    ("record-where", "of that file"),
    ("record-pixels", "of that file"),
    ("record-count", "of that file"),
];

fn halflight(place: &Place, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_halflight"))
        .args(arguments)
        .current_dir(place.folder.path())
        .output()
        .expect("the command runs")
}

#[track_caller]
fn succeed(place: &Place, arguments: &[&str]) -> String {
    let output = halflight(place, arguments);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        text(&output.stderr)
    );
    text(&output.stdout)
}

/// The long options in a help text.
fn long_options(help: &str) -> BTreeSet<String> {
    let lines = help.lines().map(str::trim_start);
    let options = lines.filter(|line| line.starts_with('-'));
    let words = options.flat_map(str::split_whitespace);
    words
        .filter_map(|word| word.strip_prefix("--"))
        .map(|word| word.trim_end_matches(',').to_owned())
        .collect()
}

#[test]
fn a_farm_takes_every_option_that_changes_the_image() {
    let place = Place::with_scene();
    let render = long_options(&succeed(&place, &["help", "render"]));
    for command in ["plan", "slurm"] {
        let farm = long_options(&succeed(&place, &["farm", command, "--help"]));
        assert!(render.len() > 30 && farm.len() > 15, "{render:?} {farm:?}");
        for option in &render {
            let is_excluded = NOT_FOR_FARMS.iter().any(|(name, _)| name == option);
            assert!(
                farm.contains(option) || is_excluded,
                "--{option} of render, and farm {command}"
            );
        }
        for (name, _) in NOT_FOR_FARMS {
            assert!(render.contains(*name), "there is no --{name} any more");
        }
    }
}

#[test]
fn options_make_the_image_that_they_make_in_one_run() {
    let place = Place::with_scene();
    // Options, samples per pixel, tasks.
    let cases: &[(&[&str], &str, &str)] = &[
        (
            &[
                "--integrator",
                "bdpt",
                "--heuristic",
                "balance",
                "--connections",
                "2",
            ],
            "6",
            "3",
        ),
        (
            &[
                "--integrator",
                "bdpt",
                "--strategies",
                "2,*",
                "--unweighted",
            ],
            "4",
            "2",
        ),
        (
            &[
                "--integrator",
                "sppm",
                "--photons",
                "500",
                "--radius",
                "0.2",
            ],
            "6",
            "3",
        ),
        (&["--integrator", "vcm", "--photons", "300"], "4", "2"),
        (
            &[
                "--integrator",
                "mmlt",
                "--chains",
                "7",
                "--direct-samples",
                "2",
            ],
            "9000",
            "2",
        ),
        (&["--regularize", "tau=10"], "6", "3"),
        (&["--lpe", "direct=C[DG]L"], "6", "3"),
        (
            &["--clamp", "0.3", "--sampler", "sobol", "--aov", "albedo"],
            "8",
            "3",
        ),
        (
            &[
                "--half",
                "--owner",
                "me",
                "--exposure",
                "1.5",
                "--width",
                "20",
            ],
            "4",
            "2",
        ),
        (&["--no-png", "--crop", "3,2,9,7", "--seed", "9"], "4", "2"),
    ];
    for (i, (options, spp, tasks)) in cases.iter().enumerate() {
        let (one, many) = (format!("one-{i}.exr"), format!("many-{i}.exr"));
        let folder = format!("many-{i}.farm");
        let mut render = vec!["render", "scene.xml", "-o", &one, "--spp", spp];
        let mut plan = vec![
            "farm",
            "plan",
            "scene.xml",
            "-o",
            &many,
            "--spp",
            spp,
            "--tasks",
            tasks,
        ];
        render.extend(*options);
        plan.extend(*options);
        succeed(&place, &render);
        succeed(&place, &plan);
        for task in 0..tasks.parse::<u32>().expect("a number") {
            succeed(&place, &["farm", "task", &folder, &task.to_string()]);
        }
        succeed(&place, &["farm", "merge", &folder]);
        let read = |name: &str| halflight::image::read_exr(place.path(name)).expect("an image");
        let (expected, found) = (read(&one), read(&many));
        assert_eq!(expected.channels.len(), found.channels.len(), "{options:?}");
        for ((name, wanted), (_, values)) in expected.channels.iter().zip(&found.channels) {
            assert!(wanted.iter().any(|v| *v != 0.0), "{options:?}: {name}");
            let limit = if options.contains(&"--half") {
                2e-3
            } else {
                3e-7
            };
            for (value, wanted) in values.iter().zip(wanted) {
                let error = (value - wanted).abs();
                assert!(
                    error <= limit * wanted.abs(),
                    "{options:?}: {name} {value}, not {wanted}"
                );
            }
        }
        for attribute in [
            "owner",
            "spp",
            "settings",
            "sceneDigest",
            "sampleRanges",
            "worldToCamera",
            "worldToNDC",
            "samplesPerPixel",
        ] {
            assert_eq!(
                found.attribute(attribute),
                expected.attribute(attribute),
                "{options:?}: {attribute}"
            );
        }
        let png = |name: &str| std::fs::read(place.path(name).with_extension("png")).ok();
        assert_eq!(png(&one).is_some(), png(&many).is_some(), "{options:?}");
        if options.contains(&"--exposure") {
            assert_eq!(png(&one), png(&many));
        }
    }
}

#[test]
fn chains_are_divided_by_groups_or_seeds() {
    let place = Place::with_scene();
    let plan = |extra: &[&str]| {
        let mut words = vec![
            "farm",
            "plan",
            "scene.xml",
            "-o",
            "c.exr",
            "--integrator",
            "pssmlt",
            "--folder",
        ];
        words.extend(extra);
        halflight(&place, &words)
    };
    // A group of a small image is a million mutations, 2605 of each pixel.
    let few = plan(&["few", "--spp", "64", "--tasks", "4"]);
    let message = String::from_utf8_lossy(&few.stderr).into_owned();
    assert!(
        message.contains("4 tasks cannot share 1 groups of"),
        "{message}"
    );
    assert!(
        plan(&["groups", "--spp", "20000", "--tasks", "4"])
            .status
            .success()
    );
    let seeds = plan(&[
        "seeds", "--spp", "6000", "--tasks", "2", "--divide", "seeds",
    ]);
    assert!(seeds.status.success());
    for task in ["0", "1"] {
        succeed(&place, &["farm", "task", "seeds", task]);
    }
    succeed(&place, &["farm", "merge", "seeds"]);
    let image = halflight::image::read_exr(place.path("c.exr")).expect("an image");
    let ranges = image.attribute("sampleRanges").expect("ranges");
    assert_eq!(ranges.split(' ').count(), 2, "{ranges}");
    let pixels = halflight(
        &place,
        &[
            "farm",
            "plan",
            "scene.xml",
            "-o",
            "p.exr",
            "--integrator",
            "mlt",
            "--spp",
            "9000",
            "--tasks",
            "2",
            "--divide",
            "pixels",
        ],
    );
    assert!(String::from_utf8_lossy(&pixels.stderr).contains("divide them by samples or seeds"));
}
