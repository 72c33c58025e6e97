//! The command `halflight-gpu` as its users meet it, also on machines where something is missing.

mod common;

use common::device;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A folder of a test, and the command run there on an example scene.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Place {
        Place(tempfile::tempdir().expect("a folder"))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halflight-gpu"));
        command.args(arguments).current_dir(self.0.path());
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().expect("the command runs")
    }

    /// Ambient occlusion in a Cornell box, small.
    fn render(&self, arguments: &[&str]) -> Output {
        let scene = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../render-cpu/scenes/cornell-box.xml"
        );
        let common = [
            "render",
            scene,
            "--integrator",
            "ao",
            "--size",
            "24x24",
            "-o",
            "out.exr",
        ];
        self.run(&[&common, arguments].concat())
    }

    /// Samples per pixel of the image.
    fn samples(&self) -> f32 {
        let image = halflight::image::read_exr(self.path("out.exr")).expect("an image");
        image.sample_counts().expect("counts")[0]
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The only line of a failure.
fn failure(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(1), "{}", stderr(output));
    stderr(output)
}

#[test]
fn devices_are_listed_with_their_limits() {
    let Some(device) = device() else { return };
    let output = Place::new().run(&["devices"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(text.contains(&device.description().name), "{text}");
    assert!(text.contains("MiB, buffers up to"), "{text}");
}

#[test]
fn path_expressions_are_for_the_processor() {
    let place = Place::new();
    for arguments in [["--lpe", "a=C.*L"], ["--only", "C.*L"]] {
        let message = failure(&place.render(&arguments));
        assert!(message.contains("use halflight render"), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

#[test]
fn a_scene_is_measured_beside_the_processor() {
    if device().is_none() {
        return;
    }
    let scene = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../render-cpu/scenes/cornell-box.xml"
    );
    let arguments = [
        "bench",
        scene,
        "--integrator",
        "ao",
        "--size",
        "32x32",
        "--seconds",
        "0.2",
    ];
    let output = Place::new().run(&arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout);
    let parts = [
        "Msamples/s",
        "Mrays/s",
        "rays per sample",
        "MiB",
        "processor",
        "ratio",
    ];
    for part in parts {
        assert!(text.contains(part), "{part} is missing in {text}");
    }
}

#[test]
fn a_render_leaves_an_image_and_a_picture() {
    if device().is_none() {
        return;
    }
    let place = Place::new();
    let output = place.render(&["--spp", "2"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(place.path("out.png").is_file());
    assert_eq!(place.samples(), 2.0);
}

#[test]
fn what_a_lost_device_took_is_kept() {
    if device().is_none() {
        return;
    }
    let place = Place::new();
    let arguments = [
        "--spp",
        "9",
        "--simulate-device-loss",
        "3",
        "--checkpoint",
        "run.checkpoint",
    ];
    let text = failure(&place.render(&arguments));
    assert!(text.contains("was lost"), "{text}");
    assert!(
        text.contains("out.exr holds what was rendered before"),
        "{text}"
    );
    assert_eq!(place.samples(), 3.0);
    // The run goes on where the device was lost.
    let output = place.render(&["--spp", "9", "--resume", "run.checkpoint"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(place.samples(), 9.0);
}

#[test]
fn a_device_without_room_says_how_much_and_loses_nothing() {
    if device().is_none() {
        return;
    }
    let place = Place::new();
    let text = failure(&place.render(&["--spp", "9", "--simulate-memory", "5000"]));
    assert!(
        text.contains("has no room for") && text.contains("bytes are in use"),
        "{text}"
    );
    assert!(!place.path("out.exr").exists());
    // A run that cannot go on writes what it resumed.
    place.render(&[
        "--spp",
        "9",
        "--simulate-device-loss",
        "2",
        "--checkpoint",
        "run.checkpoint",
    ]);
    std::fs::remove_file(place.path("out.exr")).expect("an image");
    let arguments = [
        "--spp",
        "9",
        "--resume",
        "run.checkpoint",
        "--simulate-memory",
        "5000",
    ];
    let text = failure(&place.render(&arguments));
    assert!(text.contains("has no room for"), "{text}");
    assert_eq!(place.samples(), 2.0);
}

#[test]
fn a_machine_without_a_driver_is_told_so() {
    let output = Place::new()
        .command(&["devices"])
        .env("VK_ICD_FILENAMES", "no-such-driver.json")
        .env("VK_DRIVER_FILES", "no-such-driver.json")
        .output()
        .expect("the command runs");
    let text = failure(&output);
    assert!(text.contains("no Vulkan"), "{text}");
}

#[test]
fn an_unknown_device_is_answered_with_those_there_are() {
    let Some(device) = device() else { return };
    let text = failure(&Place::new().render(&["--device", "no such device"]));
    assert!(text.contains(&device.description().name), "{text}");
}

/// The whole way under the validation layer where it is installed, and a clear sentence where it is not.
#[test]
fn validation_is_silent_or_named_as_missing() {
    if device().is_none() {
        return;
    }
    let place = Place::new();
    let output = place.render(&["--spp", "1", "--aov", "normal", "--validate"]);
    if halflight_spirv::vulkan::Instance::new(true).is_ok() {
        assert!(output.status.success(), "{}", stderr(&output));
    } else {
        let text = failure(&output);
        assert!(text.contains("vulkan-validationlayers"), "{text}");
        eprintln!("without the validation layer: {text}");
    }
}

#[test]
fn shaders_are_compiled_once_and_said_to_be() {
    if device().is_none() {
        return;
    }
    let place = Place::new();
    let cache = place.path("cache");
    let render = |arguments: &[&str]| {
        let scene = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../render-cpu/scenes/cornell-box.xml"
        );
        let common = [
            "render",
            scene,
            "--integrator",
            "ao",
            "--size",
            "8x8",
            "--spp",
            "1",
            "-o",
            "a.exr",
        ];
        let mut command = place.command(&[&common[..], arguments].concat());
        let output = command
            .env("XDG_CACHE_HOME", &cache)
            .output()
            .expect("the command runs");
        assert!(output.status.success(), "{}", stderr(&output));
        stderr(&output)
    };
    let files = || std::fs::read_dir(cache.join("halflight")).map_or(0, Iterator::count);
    let first = render(&[]);
    assert!(
        first.contains("compiling shaders for ") && first.contains("the first time"),
        "{first}"
    );
    assert_eq!(files(), 1, "one file for the device");
    let second = render(&[]);
    assert!(
        second.contains("compiling shaders for ") && !second.contains("the first time"),
        "{second}"
    );
    assert_eq!(render(&["-q"]), "");
    assert_eq!(files(), 1);
}
