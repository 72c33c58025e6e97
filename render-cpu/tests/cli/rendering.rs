//! What a successful run leaves.

use super::{Place, SCENE, read};

#[test]
fn an_image_has_its_layers_metadata_and_a_picture() {
    let place = Place::with_scene();
    place.succeed(&[
        "render",
        "scene.xml",
        "-o",
        "out.exr",
        "--seed",
        "7",
        "--aov",
        "albedo,normal,depth,position,uv,variance,samples",
        "-D",
        "spp=6",
    ]);
    assert_eq!(place.files(), ["out.exr", "out.png", "scene.xml"]);
    let image = read(&place.path("out.exr"));
    assert_eq!((image.width, image.height), (24, 16));
    for name in [
        "R",
        "G",
        "B",
        "albedo.R",
        "normal.Z",
        "depth.Z",
        "position.X",
        "uv.U",
        "variance.G",
        "samples",
    ] {
        let channel = image
            .channel(name)
            .unwrap_or_else(|| panic!("no channel {name}"));
        assert!(channel.iter().all(|v| v.is_finite()), "{name}");
        assert!(channel.iter().any(|v| *v != 0.0), "{name} is all zero");
    }
    assert!(
        image
            .channel("samples")
            .is_some_and(|s| s.iter().all(|&n| n == 6.0))
    );
    assert_eq!(image.attribute("scene"), Some("scene.xml"));
    assert_eq!(image.attribute("seed"), Some("7"));
    assert_eq!(image.attribute("spp"), Some("6"));
    assert_eq!(image.attribute("integrator"), Some("path"));
    let png = std::fs::read(place.path("out.png")).expect("a picture");
    assert!(png.starts_with(b"\x89PNG"));
}

#[test]
fn an_image_does_not_depend_on_threads() {
    let place = Place::with_scene();
    for integrator in ["path", "bdpt", "ptracer"] {
        // Wider than a tile of either driver.
        for (threads, name) in [("1", "one.exr"), ("2", "two.exr"), ("7", "seven.exr")] {
            place.succeed(&[
                "render",
                "scene.xml",
                "--integrator",
                integrator,
                "--size",
                "70x40",
                "--aov",
                "variance,normal",
                "-o",
                name,
                "--threads",
                threads,
                "--no-png",
            ]);
        }
        let one = place.channels("one.exr");
        assert_eq!(one, place.channels("two.exr"), "{integrator}");
        assert_eq!(one, place.channels("seven.exr"), "{integrator}");
        assert!(!place.path("one.png").exists());
    }
}

#[test]
fn size_width_and_crop_choose_pixels() {
    let place = Place::with_scene();
    place.succeed(&["render", "scene.xml", "-o", "w.exr", "--width", "48"]);
    let wide = read(&place.path("w.exr"));
    assert_eq!((wide.width, wide.height), (48, 32));
    place.succeed(&["render", "scene.xml", "-o", "s.exr", "--size", "20x20"]);
    assert_eq!(read(&place.path("s.exr")).height, 20);
    // A crop holds the very pixels of the whole image, away from its own edge, where the filter is cut.
    place.succeed(&["render", "scene.xml", "-o", "all.exr"]);
    place.succeed(&[
        "render",
        "scene.xml",
        "-o",
        "part.exr",
        "--crop",
        "4,3,12,10",
    ]);
    let (all, part) = (read(&place.path("all.exr")), read(&place.path("part.exr")));
    assert_eq!((part.width, part.height), (12, 10));
    let (all, part) = (all.channel("R").unwrap(), part.channel("R").unwrap());
    for y in 2..8 {
        for x in 2..10 {
            assert_eq!(part[y * 12 + x], all[(y + 3) * 24 + x + 4], "at ({x}, {y})");
        }
    }
}

#[test]
fn parts_of_the_samples_merge_to_the_whole() {
    for integrator in ["path", "bdpt", "ptracer"] {
        parts_merge_to_the_whole(integrator);
    }
}

fn parts_merge_to_the_whole(integrator: &str) {
    let place = Place::with_scene();
    let render = |samples: &str, out: &str| {
        place.succeed(&[
            "render",
            "scene.xml",
            "--integrator",
            integrator,
            "-o",
            out,
            "--samples",
            samples,
            "--aov",
            "variance,albedo",
            "--no-png",
        ]);
    };
    render("0..5", "a.exr");
    render("5..12", "b.exr");
    render("0..12", "whole.exr");
    place.succeed(&["merge", "a.exr", "b.exr", "-o", "merged.exr"]);
    let (merged, whole) = (
        read(&place.path("merged.exr")),
        read(&place.path("whole.exr")),
    );
    for (name, values) in &whole.channels {
        let other = merged
            .channel(name)
            .unwrap_or_else(|| panic!("no channel {name}"));
        for (a, b) in values.iter().zip(other) {
            assert!(
                (a - b).abs() <= 1e-5 * a.abs().max(1e-3),
                "{name}: {a} against {b}"
            );
        }
    }
    // The same samples twice are not independent.
    let twice = place.run(&["merge", "a.exr", "whole.exr", "-o", "no.exr"]);
    assert_eq!(twice.status.code(), Some(1));
    assert!(!place.path("no.exr").exists());
}

#[test]
fn comparison_fails_above_a_threshold() {
    let place = Place::with_scene();
    for seed in ["1", "2"] {
        let out = format!("{seed}.exr");
        place.succeed(&[
            "render",
            "scene.xml",
            "-o",
            &out,
            "--seed",
            seed,
            "--spp",
            "16",
            "--aov",
            "variance",
        ]);
    }
    let text = place.succeed(&["compare", "1.exr", "2.exr", "--heatmap", "heat.png"]);
    for metric in ["mse", "psnr", "ssim", "flip", "z-test"] {
        assert!(
            text.to_lowercase().contains(metric),
            "{metric} is missing in {text}"
        );
    }
    assert!(place.path("heat.png").exists());
    assert_eq!(
        place
            .run(&["compare", "1.exr", "2.exr", "--fail-above", "mse=0"])
            .status
            .code(),
        Some(1)
    );
    assert_eq!(
        place
            .run(&["compare", "1.exr", "1.exr", "--fail-above", "mse=0"])
            .status
            .code(),
        Some(0)
    );
}

#[test]
fn adaptive_sampling_moves_samples_and_keeps_their_number() {
    let place = Place::with_scene();
    place.succeed(&[
        "render",
        "scene.xml",
        "-o",
        "a.exr",
        "--adaptive",
        "--spp",
        "48",
    ]);
    let image = read(&place.path("a.exr"));
    let samples = image
        .channel("samples")
        .expect("the layer of sample counts");
    let total: f64 = samples.iter().map(|&n| f64::from(n)).sum();
    assert_eq!(total, 48.0 * 24.0 * 16.0);
    let most = samples.iter().copied().fold(0.0, f32::max);
    let least = samples.iter().copied().fold(f32::MAX, f32::min);
    assert!(least >= 16.0 && most > 1.5 * least, "{least} to {most}");
}

#[test]
fn a_time_limit_ends_a_run() {
    let place = Place::with_scene();
    place.succeed(&["render", "scene.xml", "-o", "t.exr", "--time", "0.5s"]);
    let image = read(&place.path("t.exr"));
    assert!(image.sample_counts().is_some_and(|s| s[0] >= 1.0));
}

#[test]
fn info_says_what_is_there_and_what_is_not() {
    let place = Place::with_scene();
    place.write(
        "odd.xml",
        SCENE.replace("type=\"dielectric\"", "type=\"velvet\""),
    );
    let text = place.succeed(&["info", "odd.xml"]);
    for part in ["24 x 16", "4 triangles", "1 analytic", "velvet", "odd.xml:"] {
        assert!(text.contains(part), "{part} is missing in {text}");
    }
}

#[test]
fn every_example_scene_renders_without_a_warning() {
    let place = Place::with_scene();
    let scenes = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut count = 0;
    for entry in std::fs::read_dir(scenes).expect("example scenes") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy();
        // Files of edits are no scenes.
        if !name.ends_with(".xml") || name.ends_with("-edits.xml") {
            continue;
        }
        count += 1;
        let output = place.run(&[
            "render",
            path.to_str().expect("text"),
            "-o",
            "e.exr",
            "--spp",
            "1",
            "--width",
            "48",
            "--strict",
        ]);
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{}: {errors}", path.display());
        assert!(!errors.contains("WARN"), "{}: {errors}", path.display());
        let image = read(&place.path("e.exr"));
        assert!(
            image
                .channel("G")
                .is_some_and(|g| g.iter().any(|&v| v > 0.0)),
            "{}",
            path.display()
        );
    }
    assert!(count >= 5, "only {count} example scenes");
}

#[test]
fn a_scene_needs_no_command_wherever_it_stands() {
    let place = Place::with_scene();
    place.write("scene", SCENE);
    for arguments in [
        &["-q", "scene.xml"][..],
        &["-v", "scene.xml", "--no-png"],
        &["-vv", "scene.xml"],
        &["--threads", "1", "scene.xml"],
        &["-o", "scene.exr", "scene.xml"],
        &["-q", "-o", "scene.exr", "--", "scene.xml"],
        &["--", "scene.xml"],
        &["scene"],
    ] {
        let _ = std::fs::remove_file(place.path("scene.exr"));
        place.succeed(arguments);
        assert!(place.path("scene.exr").is_file(), "{arguments:?}");
    }
    // What is a command, or nearly one, is none of this.
    for arguments in [
        &["-q", "info", "scene.xml"][..],
        &["--version"],
        &["help"],
        &["-v", "list", "bsdfs"],
    ] {
        place.succeed(arguments);
    }
    let output = place.run(&["rendr", "scene.xml"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(text.contains("unrecognized subcommand"), "{text}");
}
