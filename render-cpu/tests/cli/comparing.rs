//! Algorithms side by side: `render --strategy-sheet` and `experiment convergence`.

use super::Place;

/// The picture's size.
fn picture(place: &Place, name: &str) -> (u32, u32) {
    image::open(place.path(name))
        .expect("a picture")
        .into_rgb8()
        .dimensions()
}

#[test]
fn a_strategy_sheet_is_a_picture() {
    let place = Place::with_scene();
    let sheet = [
        "render",
        "scene.xml",
        "--integrator",
        "bdpt",
        "--strategy-sheet",
        "sheet.png",
    ];
    place.succeed(&[&sheet[..], &["--spp", "2", "--sheet-length", "3"]].concat());
    assert_eq!(place.files(), ["scene.xml", "sheet.png"]);
    let small = picture(&place, "sheet.png");
    place.succeed(&[&sheet[..], &["--spp", "1", "--unweighted"]].concat());
    let large = picture(&place, "sheet.png");
    assert!(
        large.0 > small.0 && large.1 > small.1,
        "six lengths by default"
    );
}

#[test]
fn a_comparison_prints_a_table_and_draws() {
    let place = Place::with_scene();
    place.succeed(&[
        "render",
        "scene.xml",
        "-o",
        "r.exr",
        "--no-png",
        "--spp",
        "64",
        "--aov",
        "variance",
    ]);
    let compare = [
        "experiment",
        "convergence",
        "scene.xml",
        "--integrators",
        "path,bdpt",
        "--spp",
        "16",
        "-q",
    ];
    let drawn = [
        "--reference",
        "r.exr",
        "-o",
        "plot.png",
        "--sheet",
        "sheet.png",
        "--inset",
        "2,2,8,8",
    ];
    let text = place.succeed(&[&compare[..], &drawn].concat());
    assert!(
        text.contains("relative variance") && text.contains("bdpt"),
        "{text}"
    );
    assert!(picture(&place, "plot.png").0 > 1000 && picture(&place, "sheet.png").0 > 700);
    let text = place.succeed(&[&compare[..], &["--json"]].concat());
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json["reference"], serde_json::Value::Null);
    let last = &json["integrators"][1]["curve"][4];
    assert_eq!(last["samples"], 16);
    assert!(
        last["relative_mse"].as_f64().is_some_and(|e| e > 0.0),
        "{text}"
    );
}

#[test]
fn requests_that_cannot_be_met_get_one_line() {
    let place = Place::with_scene();
    place.succeed(&[
        "render",
        "scene.xml",
        "-o",
        "small.exr",
        "--no-png",
        "--spp",
        "1",
        "--size",
        "8x8",
    ]);
    let compare = [
        "experiment",
        "convergence",
        "scene.xml",
        "--spp",
        "1",
        "--integrators",
    ];
    let sheet = ["render", "scene.xml", "--strategy-sheet"];
    for (arguments, part) in [
        ([&compare[..], &["pathos"]].concat(), "known are path"),
        (
            [&compare[..], &["path", "--reference", "small.exr"]].concat(),
            "8 x 8",
        ),
        (
            [&compare[..], &["path", "--reference", "none.exr"]].concat(),
            "none.exr",
        ),
        (
            [&compare[..], &["path", "-o", "plot.exr"]].concat(),
            "ends in .png",
        ),
        (
            [&compare[..], &["path", "--sheet", "no/where.png"]].concat(),
            "no folder",
        ),
        (
            [
                &compare[..],
                &["path", "--sheet", "s.png", "--inset", "20,0,9,4"],
            ]
            .concat(),
            "--inset",
        ),
        ([&sheet[..], &["sheet.png"]].concat(), "--integrator bdpt"),
        (
            [&sheet[..], &["sheet.exr", "--integrator", "bdpt"]].concat(),
            "ends in .png",
        ),
        (
            [
                &sheet[..],
                &["s.png", "--integrator", "bdpt", "--sheet-length", "0"],
            ]
            .concat(),
            "--sheet-length",
        ),
    ] {
        let output = place.run(&arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
        assert_eq!(message.matches("error: ").count(), 1, "{message}");
        assert!(message.contains(part), "{arguments:?}: {message}");
        assert_eq!(place.files(), ["scene.xml", "small.exr"], "{arguments:?}");
    }
    for arguments in [
        &["experiment", "convergence", "scene.xml"][..],
        &[
            "experiment",
            "convergence",
            "scene.xml",
            "--integrators",
            "path",
            "--integrator",
            "ao",
        ],
        &["render", "scene.xml", "--unweighted"],
        &[
            "render",
            "scene.xml",
            "--strategy-sheet",
            "s.png",
            "--strategies",
            "1,2",
        ],
        &["experiment"],
    ] {
        let output = place.run(arguments);
        assert_eq!(
            output.status.code(),
            Some(2),
            "{arguments:?}: clap's own error"
        );
    }
}
