//! Checkpoints are gone on from or left alone, and a run says how it goes on.

use super::{Place, SCENE};
use clap::Parser;
use halflight::commands::render::{RenderArgs, run_with};
use halflight::render::Outcome;
use std::process::ExitCode;

fn stderr(place: &Place, arguments: &[&str], code: i32) -> String {
    let output = place.run(arguments);
    let text = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
    text
}

const RENDER: [&str; 5] = ["render", "scene.xml", "--checkpoint", "c", "-o"];

#[test]
fn one_option_starts_or_goes_on() {
    let place = Place::with_scene();
    place.succeed(&[&RENDER[..], &["a.exr", "--spp", "3"]].concat());
    let text = stderr(
        &place,
        &[&RENDER[..], &["b.exr", "--spp", "8", "-v"]].concat(),
        0,
    );
    assert!(text.contains("resumed after 3 samples"), "{text}");
    place.succeed(&["render", "scene.xml", "-o", "straight.exr", "--spp", "8"]);
    assert_eq!(place.channels("b.exr"), place.channels("straight.exr"));
    // A goal below what there is.
    let text = stderr(&place, &[&RENDER[..], &["d.exr", "--spp", "5"]].concat(), 0);
    assert!(
        text.contains("c holds 8 samples per pixel already, more than the 5"),
        "{text}"
    );
    assert_eq!(place.channels("d.exr"), place.channels("straight.exr"));
}

#[test]
fn a_checkpoint_is_never_replaced_by_another_run() {
    let place = Place::with_scene();
    place.succeed(&[&RENDER[..], &["a.exr"]].concat());
    place.write("notes.txt", "not a checkpoint");
    let before = std::fs::read(place.path("c")).expect("a checkpoint");
    place.write("d", &before);
    place.write("deep.xml", SCENE.replace("value=\"8\"", "value=\"3\""));
    place.write("blue.xml", SCENE.replace("0.4, 0.3, 0.2", "0.2, 0.3, 0.4"));
    place.write("moved.xml", SCENE);
    let cases: [(&[&str], &str); 6] = [
        (
            &["scene.xml", "--checkpoint", "c", "--seed", "9"],
            "seed is 0 there and 9 here",
        ),
        (
            &["deep.xml", "--checkpoint", "c"],
            "max_depth is 8 there and 3 here;",
        ),
        (
            &["blue.xml", "--checkpoint", "c"],
            "they differ in the content of the scene",
        ),
        (
            &["scene.xml", "--checkpoint", "c", "--integrator", "bdpt"],
            "integrator is path there and bdpt here",
        ),
        (
            &["scene.xml", "--checkpoint", "notes.txt"],
            "no checkpoint of Halflight",
        ),
        (
            &["scene.xml", "--checkpoint", "d", "--resume", "c"],
            "d is there already and is not replaced",
        ),
    ];
    for (arguments, part) in cases {
        let all = [&["render", "-o", "b.exr"], arguments].concat();
        let text = stderr(&place, &all, 1);
        assert!(text.contains(part), "{arguments:?}: {text}");
        for word in ["{", "IntegratorSettings", "u32"] {
            assert!(!text.contains(word), "{arguments:?}: {text}");
        }
        assert!(!place.path("b.exr").exists());
    }
    assert_eq!(
        std::fs::read(place.path("c")).expect("a checkpoint"),
        before
    );
    assert_eq!(
        std::fs::read(place.path("d")).expect("a checkpoint"),
        before
    );
    // The same scene under another name is the same scene.
    place.succeed(&["render", "-o", "b.exr", "moved.xml", "--checkpoint", "c"]);
}

/// The arguments of a render, parsed in this process.
#[derive(clap::Parser)]
struct Alone {
    #[command(flatten)]
    render: RenderArgs,
}

#[test]
fn a_run_without_a_sample_leaves_files_alone() {
    let place = Place::with_scene();
    place.write("old.exr", "an image");
    place.write("old.png", "a picture");
    let path = |name: &str| place.path(name).display().to_string();
    let alone = Alone::parse_from([
        "render",
        &path("scene.xml"),
        "-o",
        &path("old.exr"),
        "--checkpoint",
        &path("c"),
    ]);
    let run = |outcome: Outcome| run_with(&alone.render, true, |_, _, _, _, _| Ok(outcome));
    let interrupted = run(Outcome::Interrupted).expect("an exit code");
    assert_eq!(interrupted, ExitCode::from(130));
    let error = run(Outcome::Finished).expect_err("no image");
    assert!(error.to_string().contains("left as it was"), "{error}");
    let lost = run_with(&alone.render, true, |_, _, _, _, _| Err("lost".into()));
    assert_eq!(lost.expect_err("no image").to_string(), "lost");
    for (name, content) in [("old.exr", "an image"), ("old.png", "a picture")] {
        let found = std::fs::read_to_string(place.path(name));
        assert_eq!(found.expect("a file"), content);
    }
    assert!(!place.path("c").exists());
}

#[cfg(unix)]
mod signals {
    use super::super::Place;
    use std::io::Read;
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    fn wait_for(path: &std::path::Path) {
        let start = Instant::now();
        while !path.exists() {
            assert!(
                start.elapsed() < Duration::from_secs(120),
                "{path:?} never appeared"
            );
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn send(signal: &str, process: u32) {
        let sent = Command::new("kill")
            .args([signal, &process.to_string()])
            .status();
        assert!(sent.expect("kill").success());
    }

    #[test]
    fn signals_that_shall_be_ignored_are() {
        // As nohup does it, and shells for what a script runs in the background.
        for signal in ["HUP", "INT"] {
            let place = Place::with_scene();
            let command = place.command(&[]);
            let program = command.get_program().to_str().expect("text");
            let line = format!(
                "trap '' {signal}; exec {program} render scene.xml -o out.exr --time 4s --checkpoint c --checkpoint-interval 0.1s"
            );
            let mut child = Command::new("sh")
                .args(["-c", &line])
                .current_dir(place.path("."))
                .stderr(Stdio::null())
                .spawn()
                .expect("a shell");
            wait_for(&place.path("c"));
            send(&format!("-{signal}"), child.id());
            assert_eq!(
                child.wait().expect("a status").code(),
                Some(0),
                "it ended early"
            );
        }
    }

    #[test]
    fn an_interrupted_run_says_so_and_how_it_goes_on() {
        let place = Place::with_scene();
        let render = ["render", "scene.xml", "-o", "out.exr", "-D", "spp=1000000"];
        let more = ["--checkpoint", "a run", "--checkpoint-interval", "0.1s"];
        let mut child = place
            .command(&[&render[..], &more].concat())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the command runs");
        wait_for(&place.path("a run"));
        send("-INT", child.id());
        let mut text = String::new();
        let stderr = child.stderr.as_mut().expect("a pipe");
        stderr.read_to_string(&mut text).expect("text");
        assert_eq!(child.wait().expect("a status").code(), Some(130), "{text}");
        assert!(
            text.contains("interrupted: what there is will be written"),
            "{text}"
        );
        let command = "render scene.xml -o out.exr -D spp=1000000 --checkpoint 'a run' --checkpoint-interval 0.1s";
        assert!(
            text.contains("to go on: ") && text.contains(command),
            "{text}"
        );
    }
}
