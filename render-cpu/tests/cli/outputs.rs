//! Where files go is looked at before anything is rendered.

use super::Place;

/// The error line of a command that renders nothing.
fn refused(place: &Place, arguments: &[&str]) -> String {
    let before = place.files();
    let output = place.run(arguments);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {text}");
    assert_eq!(text.matches("error: ").count(), 1, "{text}");
    assert!(!text.contains("spp"), "it rendered: {text}");
    assert_eq!(place.files(), before, "{arguments:?}");
    text
}

#[test]
fn what_cannot_be_written_costs_nothing() {
    let place = Place::with_scene();
    place.succeed(&["render", "scene.xml", "-o", "a.exr", "--no-png"]);
    std::fs::create_dir(place.path("folder.exr")).expect("a folder");
    place.write("old.exr", "kept");
    let mut mode = std::fs::metadata(place.path("old.exr"))
        .expect("a file")
        .permissions();
    mode.set_readonly(true);
    std::fs::set_permissions(place.path("old.exr"), mode).expect("its mode");
    let long = ["--spp", "100000", "--size", "2000x2000"];
    for (arguments, part) in [
        (
            vec!["render", "scene.xml", "-o", "no/where.exr"],
            "there is no folder",
        ),
        (
            vec!["render", "scene.xml", "-o", "folder.exr"],
            "no regular file",
        ),
        (vec!["render", "scene.xml", "-o", "old.exr"], "read-only"),
        (vec!["render", "scene.xml", "-o", "out.gif"], "ends in .exr"),
        (
            vec!["render", "scene.xml", "-o", "x.exr", "--checkpoint", "no/c"],
            "there is no folder",
        ),
        (
            vec![
                "render",
                "scene.xml",
                "-o",
                "x.exr",
                "--checkpoint",
                "scene.xml",
            ],
            "it would replace scene.xml",
        ),
    ] {
        let text = refused(&place, &[&arguments[..], &long].concat());
        assert!(text.contains(part), "{arguments:?}: {text}");
    }
    for (arguments, part) in [
        (vec!["material", "Au", "-o", "sheet.exr"], "ends in .png"),
        (
            vec!["material", "scene.xml", "-o", "scene.xml"],
            "ends in .png",
        ),
        (
            vec!["compare", "a.exr", "a.exr", "--heatmap", "map.jpg"],
            "ends in .png",
        ),
        (vec!["merge", "a.exr", "-o", "m.png"], "ends in .exr"),
        (
            vec!["merge", "a.exr", "-o", "a.exr"],
            "it would replace a.exr",
        ),
        (
            vec!["experiment", "bounds", "-o", "no/where.png"],
            "there is no folder",
        ),
        (
            vec!["farm", "plan", "scene.xml", "-o", "f.png", "--tasks", "2"],
            "ends in .exr",
        ),
    ] {
        let text = refused(&place, &arguments);
        assert!(text.contains(part), "{arguments:?}: {text}");
    }
}

#[cfg(unix)]
#[test]
fn links_are_followed() {
    use std::os::unix::fs::symlink;
    let place = Place::with_scene();
    place.succeed(&["render", "scene.xml", "-o", "a.exr", "--no-png"]);
    symlink("a.exr", place.path("link.exr")).expect("a link");
    let text = refused(&place, &["merge", "a.exr", "-o", "link.exr"]);
    assert!(text.contains("it would replace a.exr"), "{text}");
    // To a file that is not there yet.
    std::fs::create_dir(place.path("images")).expect("a folder");
    symlink("images/new.exr", place.path("later.exr")).expect("a link");
    place.succeed(&["render", "scene.xml", "-o", "later.exr", "--no-png"]);
    assert!(place.path("images/new.exr").is_file());
    assert!(place.path("later.exr").is_symlink());
    symlink("nowhere/new.exr", place.path("lost.exr")).expect("a link");
    let text = refused(&place, &["render", "scene.xml", "-o", "lost.exr"]);
    assert!(text.contains("there is no folder nowhere"), "{text}");
}

#[test]
fn what_a_killed_run_left_is_removed_by_the_next() {
    let place = Place::with_scene();
    place.write(".out.exr.aB3dE6.partial", "half of an image");
    place.write(".other.exr.aB3dE6.partial", "half of another");
    // One that somebody writes at the moment.
    place.write(".out.exr.Xy1234.partial", "under way");
    let under_way = std::fs::File::open(place.path(".out.exr.Xy1234.partial")).expect("a file");
    under_way.lock().expect("a lock");
    place.succeed(&["render", "scene.xml", "-o", "out.exr", "--no-png"]);
    assert_eq!(
        place.files(),
        [
            ".other.exr.aB3dE6.partial",
            ".out.exr.Xy1234.partial",
            "out.exr",
            "scene.xml"
        ]
    );
}

#[test]
fn an_absurd_number_of_threads_is_refused() {
    let place = Place::with_scene();
    for command in [
        &["render", "scene.xml", "-o", "x.exr", "--threads", "1000000"][..],
        &[
            "experiment",
            "convergence",
            "scene.xml",
            "--integrators",
            "path",
            "--threads",
            "1000000",
        ],
    ] {
        let text = refused(&place, command);
        assert!(
            text.contains("1000000 threads are more than this machine"),
            "{text}"
        );
    }
}

#[test]
fn an_image_is_not_lost_with_its_folder() {
    let place = Place::with_scene();
    std::fs::create_dir(place.path("images")).expect("a folder");
    std::fs::create_dir(place.path("tmp")).expect("a folder");
    let mut command = place.command(&[
        "render",
        "scene.xml",
        "-o",
        "images/a.exr",
        "--time",
        "3s",
        "--checkpoint",
        "c",
        "--checkpoint-interval",
        "0.1s",
    ]);
    let child = command
        .env("TMPDIR", place.path("tmp"))
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the command runs");
    let start = std::time::Instant::now();
    while !place.path("c").exists() {
        assert!(start.elapsed().as_secs() < 120, "it never began");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    std::fs::remove_dir_all(place.path("images")).expect("a folder");
    let output = child.wait_with_output().expect("a status");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{text}");
    let folder = std::fs::read_dir(place.path("tmp"))
        .expect("a folder")
        .next();
    let image = folder
        .expect("an entry")
        .expect("an entry")
        .path()
        .join("a.exr");
    assert!(
        text.contains(&format!("the image is {} instead", image.display())),
        "{text}"
    );
    assert!(super::read(&image).channel("R").is_some());
}

#[test]
fn inputs_of_another_kind_are_named() {
    let place = Place::with_scene();
    place.succeed(&["render", "scene.xml", "-o", "a.exr"]);
    for (arguments, part) in [
        (
            &["compare", "a.exr", "a.png"][..],
            "is no OpenEXR file, but of the format PNG",
        ),
        (
            &[
                "inspect",
                "scene.xml",
                "--tool",
                "false-color",
                "-o",
                "f.png",
                "--min",
                "5",
                "--max",
                "1",
            ],
            "--min must be below --max",
        ),
    ] {
        let output = place.run(arguments);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(
            !output.status.success() && text.contains(part),
            "{arguments:?}: {text}"
        );
    }
}

#[cfg(unix)]
#[test]
fn a_limit_on_the_length_of_files_is_an_error() {
    let place = Place::with_scene();
    let command = place.command(&[]);
    let program = command.get_program().to_str().expect("text");
    let line = format!("ulimit -f 1; exec {program} render scene.xml -o a.exr --size 200x200");
    let output = std::process::Command::new("sh")
        .args(["-c", &line])
        .current_dir(place.path("."))
        .env("TMPDIR", place.path("."))
        .output()
        .expect("a shell");
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("cannot write a.exr"), "{text}");
}

#[test]
fn two_files_are_not_written_to_one_place() {
    let place = Place::with_scene();
    for (arguments, part) in [
        (
            &["render", "scene.xml", "-o", "q.exr", "--record", "q.exr"][..],
            "the image and the record of paths cannot be one file",
        ),
        (
            &["render", "scene.xml", "-o", "q.exr", "--record", "./q.png"],
            "the PNG beside the image and the record of paths",
        ),
        (
            &[
                "render",
                "scene.xml",
                "-o",
                "x.exr",
                "--checkpoint",
                "x.exr",
            ],
            "the image and the checkpoint cannot be one file",
        ),
        (
            &[
                "render",
                "scene.xml",
                "-o",
                "x.exr",
                "--checkpoint",
                "c",
                "--record",
                "c",
            ],
            "the checkpoint and the record of paths",
        ),
        (
            &[
                "render",
                "scene.xml",
                "-o",
                "x.exr",
                "--record",
                "scene.xml",
            ],
            "it would replace scene.xml",
        ),
        (
            &[
                "render",
                "scene.xml",
                "-o",
                "x.exr",
                "--record",
                "no/where.jsonl",
            ],
            "there is no folder",
        ),
        (
            &[
                "experiment",
                "convergence",
                "scene.xml",
                "--integrators",
                "path",
                "-o",
                "cv.png",
                "--sheet",
                "cv.png",
            ],
            "the diagram and the sheet cannot be one file",
        ),
    ] {
        let text = refused(&place, arguments);
        assert!(text.contains(part), "{arguments:?}: {text}");
    }
}

#[test]
fn what_a_file_cannot_hold_is_refused() {
    let place = Place::with_scene();
    for (output, options, part) in [
        ("x.png", &["--aov", "albedo"][..], "--aov"),
        ("x.hdr", &["--aov", "all"], "--aov"),
        ("x.pfm", &["--aov", "all"], "--aov"),
        ("x.png", &["--lpe", "a=C.*L"], "--lpe"),
        ("x.jpg", &["--half"], "--half"),
        ("x.png", &["--owner", "me"], "--owner"),
        ("x.png", &["--no-png"], "--no-png"),
        ("x.exr", &["--exposure", "3", "--no-png"], "--exposure"),
        ("x.jpg", &["--live"], "--live"),
    ] {
        let arguments = [&["render", "scene.xml", "-o", output], options].concat();
        let text = refused(&place, &arguments);
        assert!(text.contains(part), "{arguments:?}: {text}");
    }
    // What the scene asks for is said, and the image is made.
    let scene = super::SCENE.replace(
        "<integrator type=\"path\">",
        "<integrator type=\"aov\"><string name=\"aovs\" value=\"d:depth\"/><integrator type=\"path\">",
    );
    let scene = scene.replace("</integrator>", "</integrator></integrator>");
    place.write("layers.xml", scene);
    let output = place.run(&["render", "layers.xml", "-o", "x.png"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("cannot hold the layers"), "{text}");
}
