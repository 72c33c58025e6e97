//! Runs that end early and go on.

use super::{Place, read};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Waits for a file to appear.
fn wait_for(path: &std::path::Path) {
    let start = Instant::now();
    while !path.exists() {
        assert!(
            start.elapsed() < Duration::from_secs(60),
            "{} never appeared",
            path.display()
        );
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Kills a long run some time after its first checkpoint, continues it to a few samples beyond, and compares with an
/// uninterrupted run of as many.
fn killed_and_resumed(signal: &str, delay: Duration, extra: &[&str]) {
    let place = Place::with_scene();
    kill_and_resume(&place, ["scene.xml", "1"], signal, delay, extra);
}

/// The same for a scene of which every pixel's sample is `unit` of what users ask for.
pub fn kill_and_resume(
    place: &Place,
    [scene, unit]: [&str; 2],
    signal: &str,
    delay: Duration,
    extra: &[&str],
) {
    let checkpoint = place.path("run.checkpoint");
    let mut arguments = vec![
        "render",
        scene,
        "-o",
        "out.exr",
        "--spp",
        "100000000",
        "--aov",
        "variance,normal",
        "--checkpoint",
        "run.checkpoint",
        "--checkpoint-interval",
        "0.1s",
    ];
    arguments.extend(extra);
    let mut child = place
        .command(&arguments)
        .stderr(Stdio::null())
        .spawn()
        .expect("the command runs");
    wait_for(&checkpoint);
    std::thread::sleep(delay);
    let killed = std::process::Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status()
        .expect("kill");
    assert!(killed.success());
    let status = child.wait().expect("an exit status");
    if signal == "-KILL" {
        assert!(
            !place.path("out.exr").exists(),
            "a killed run left an image"
        );
    } else {
        assert_eq!(status.code(), Some(130));
        assert!(read(&place.path("out.exr")).channel("R").is_some());
    }

    // Beyond the pixel that has most: a run that was interrupted within a pass keeps all samples.
    let film = halflight::film::checkpoint::read_checkpoint(
        &mut std::fs::File::open(&checkpoint).expect("the checkpoint"),
        std::fs::metadata(&checkpoint).expect("its length").len(),
        &checkpoint,
    )
    .expect("a whole checkpoint")
    .1;
    let counts = film.statistics().iter().map(|p| p.count);
    let unit: u32 = unit.parse().expect("a number");
    let total = ((counts.max().expect("pixels") + 5) * unit).to_string();
    let finish = |more: &[&str]| {
        let mut arguments = vec![
            "render",
            scene,
            "--spp",
            &total,
            "--aov",
            "variance,normal",
            "--no-png",
        ];
        arguments.extend(extra);
        arguments.extend(more);
        place.succeed(&arguments);
    };
    finish(&["-o", "resumed.exr", "--resume", "run.checkpoint"]);
    finish(&["-o", "straight.exr"]);
    assert_eq!(
        place.channels("resumed.exr"),
        place.channels("straight.exr")
    );
}

#[test]
fn a_killed_run_resumes_to_the_same_bits() {
    killed_and_resumed("-KILL", Duration::ZERO, &[]);
}

#[test]
fn an_interrupted_run_resumes_to_the_same_bits() {
    killed_and_resumed("-INT", Duration::ZERO, &["--sampler", "sobol"]);
}

#[test]
fn an_adaptive_run_resumes_to_the_same_bits() {
    killed_and_resumed("-KILL", Duration::ZERO, &["--adaptive"]);
}

#[test]
fn killed_runs_that_splat_resume_to_the_same_bits() {
    // At any moment: between checkpoints, and while one is written.
    let delay = |i: u64| Duration::from_micros(i * 48_271 % 250_000);
    for i in 0..4 {
        killed_and_resumed("-KILL", delay(i), &["--integrator", "bdpt"]);
    }
    let sobol = ["--integrator", "ptracer", "--sampler", "sobol"];
    killed_and_resumed("-KILL", delay(5), &sobol);
}

#[test]
fn a_checkpoint_of_another_run_is_refused() {
    let place = Place::with_scene();
    place.succeed(&[
        "render",
        "scene.xml",
        "-o",
        "a.exr",
        "--checkpoint",
        "a.checkpoint",
    ]);
    let other = place.run(&[
        "render",
        "scene.xml",
        "-o",
        "b.exr",
        "--resume",
        "a.checkpoint",
        "--seed",
        "9",
    ]);
    assert_eq!(other.status.code(), Some(1));
    let message = String::from_utf8_lossy(&other.stderr).into_owned();
    assert!(message.contains("seed is 0 there and 9 here"), "{message}");
    assert!(!place.path("b.exr").exists());
    let whole = std::fs::read(place.path("a.checkpoint")).expect("a checkpoint");
    place.write("short.checkpoint", &whole[..whole.len() - 9]);
    let short = place.run(&[
        "render",
        "scene.xml",
        "-o",
        "b.exr",
        "--resume",
        "short.checkpoint",
    ]);
    assert_eq!(short.status.code(), Some(1));
}
