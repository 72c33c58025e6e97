//! Lines that nobody can read any more: no render ends for them, and nothing panics.
#![cfg(unix)]

use super::{Place, SCENE};
use std::fs::File;
use std::os::fd::OwnedFd;
use std::process::{Output, Stdio};

/// A pipe whose reader has gone.
fn closed_pipe() -> Stdio {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    OwnedFd::from(writer).into()
}

/// A device that is always full.
fn full_disk() -> Option<Stdio> {
    let file = File::options().write(true).open("/dev/full").ok()?;
    Some(file.into())
}

/// Runs with standard output or standard error gone.
fn run(place: &Place, arguments: &[&str], is_error: bool, stdio: Stdio) -> Output {
    let mut command = place.command(arguments);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    if is_error {
        command.stderr(stdio);
    } else {
        command.stdout(stdio);
    }
    command.output().expect("the command runs")
}

#[test]
fn a_render_is_finished_whatever_becomes_of_its_messages() {
    let place = Place::with_scene();
    // Warnings, and lines about what is done.
    place.write(
        "odd.xml",
        SCENE.replace("type=\"dielectric\"", "type=\"velvet\""),
    );
    let render = ["render", "odd.xml", "-o", "out.exr", "-vv", "--spp", "8"];
    for stdio in [Some(closed_pipe()), full_disk()].into_iter().flatten() {
        let output = run(&place, &render, true, stdio);
        assert_eq!(output.status.code(), Some(0));
        assert!(place.path("out.exr").exists() && place.path("out.png").exists());
        std::fs::remove_file(place.path("out.exr")).expect("the image");
    }
    // An error that cannot be told is one all the same.
    let output = run(&place, &["render", "none.xml"], true, closed_pipe());
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn who_closes_standard_output_has_read_enough() {
    let place = Place::with_scene();
    place.succeed(&["render", "scene.xml", "-o", "a.exr", "--no-png"]);
    let commands: [&[&str]; 8] = [
        &["info", "scene.xml"],
        &["compare", "a.exr", "a.exr"],
        &["compare", "a.exr", "a.exr", "--json"],
        &["material", "--list"],
        &["material", "diffuse", "--spp", "1"],
        &["experiment", "list"],
        &["experiment", "bounds", "--quick"],
        &["--help"],
    ];
    for arguments in commands {
        let output = run(&place, arguments, false, closed_pipe());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {message}");
        assert!(message.is_empty(), "{arguments:?}: {message}");
    }
    // What was asked for besides is done, and what is wrong is said by the exit code.
    assert!(place.path("material.png").exists());
    let failing = ["compare", "a.exr", "a.exr", "--fail-below", "ssim=2"];
    let output = run(&place, &failing, false, closed_pipe());
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn results_that_do_not_fit_on_the_disk_are_an_error() {
    let place = Place::with_scene();
    place.succeed(&["render", "scene.xml", "-o", "a.exr", "--no-png"]);
    let commands: [&[&str]; 4] = [
        &["info", "scene.xml"],
        &["compare", "a.exr", "a.exr"],
        &["material", "--list"],
        &["experiment", "list"],
    ];
    for arguments in commands {
        let Some(stdio) = full_disk() else {
            return;
        };
        let output = run(&place, arguments, false, stdio);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {message}");
        assert!(
            message.starts_with("error: cannot write to standard output"),
            "{arguments:?}: {message}"
        );
    }
}

#[test]
fn verbosity_has_three_steps_above_silence() {
    let place = Place::with_scene();
    place.write(
        "odd.xml",
        SCENE.replace("type=\"dielectric\"", "type=\"velvet\""),
    );
    let lines = |flag: &str| {
        let mut arguments = vec!["render", "odd.xml", "-o", "out.exr"];
        arguments.extend(Some(flag).filter(|f| !f.is_empty()));
        let output = place.run(&arguments);
        assert!(output.status.success());
        let text = String::from_utf8(output.stderr).expect("text");
        assert!(!text.contains('\u{1b}'), "colours in {text}");
        text.lines().count()
    };
    let counts = ["-q", "", "-v", "-vv"].map(lines);
    assert_eq!(counts[0], 0);
    assert!(counts.is_sorted_by(|a, b| a < b), "{counts:?}");
}
