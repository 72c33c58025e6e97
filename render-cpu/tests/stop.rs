//! Passes that end early: nothing is taken once the run is to stop, and what is cut goes on to the same bits.

use halflight::accel::Accel;
use halflight::film::Film;
use halflight::film::aov::{Aov, AovSet};
use halflight::film::checkpoint::{Progress, read_checkpoint, write_checkpoint};
use halflight::render::{
    Backend, CpuBackend, Goal, NoObserver, Outcome, PassEnd, RenderOptions, RunState, Stop, render,
};
use halflight::scene::build::{BuildOptions, Scene, build_scene};
use halflight::scene::xml::parse_scene;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

fn scene(integrator: &str, width: u32) -> Scene {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell-box.xml");
    let parsed = parse_scene(&file, &[], false).expect("a scene");
    let mut options = BuildOptions {
        integrator: Some(integrator.into()),
        ..BuildOptions::default()
    };
    options.film.width = Some(width);
    build_scene(&parsed, &options).expect("a scene")
}

fn empty(scene: &Scene) -> Film {
    let [width, height] = scene.tables.camera.crop_size;
    let layers = AovSet::NONE.with(Aov::Normal);
    Film::new(width, height, [0; 2], layers).expect("a film")
}

fn options(goal: Goal, adaptive: bool) -> RenderOptions {
    RenderOptions {
        goal,
        seed: 3,
        first_sample: 0,
        adaptive,
    }
}

#[test]
fn a_pass_takes_nothing_once_it_is_to_stop() {
    for integrator in ["path", "ao", "bdpt"] {
        let scene = scene(integrator, 64);
        let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
        let options = options(Goal::Samples(4), false);
        let mut backend = CpuBackend::new(&scene, &accel, &options);
        let mut film = empty(&scene);
        let asked = AtomicBool::new(true);
        let now = Instant::now();
        let long_ago = now.checked_sub(Duration::from_secs(2)).expect("an uptime");
        let never = AtomicBool::new(false);
        for stop in [Stop::new(&asked, None), Stop::new(&never, Some(long_ago))] {
            let end = backend.pass(&mut film, 4, None, &stop).expect("a pass");
            assert_eq!(end, PassEnd::Cut, "{integrator}");
            assert_eq!(film.total_samples(), 0, "{integrator}");
        }
        let end = backend.pass(&mut film, 4, None, &Stop::NEVER);
        assert_eq!(end.expect("a pass"), PassEnd::Complete);
        assert_eq!(film.total_samples(), 4 * 64 * u64::from(film.height()));
    }
}

#[test]
fn passes_count_what_they_take() {
    for integrator in ["path", "ao", "bdpt", "vcm", "sppm", "mmlt", "mlt"] {
        let scene = scene(integrator, 64);
        let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
        let options = options(Goal::Samples(2), false);
        let mut backend = CpuBackend::new(&scene, &accel, &options);
        let mut film = empty(&scene);
        let (never, taken) = (AtomicBool::new(false), AtomicU64::new(0));
        let stop = Stop::new(&never, None).counting(Some(&taken));
        let end = backend.pass(&mut film, 1, None, &stop).expect("a pass");
        assert_eq!(end, PassEnd::Complete, "{integrator}");
        let all = film.total_samples() as f64;
        let counted = taken.load(Ordering::Relaxed) as f64;
        // The rounds of chains are rounded down.
        assert!(
            counted <= all && counted > 0.95 * all,
            "{integrator}: {counted} of {all}"
        );
    }
}

/// Through the bytes of a checkpoint and back.
fn reread(state: &RunState, film: &Film) -> (RunState, Film) {
    let progress = Progress {
        passes: state.passes,
        next_sample: state.samples,
        render_seconds: state.seconds,
        ..Progress::default()
    };
    let mut bytes = Vec::new();
    write_checkpoint(&mut bytes, &progress, film).expect("memory");
    let (progress, film) = read_checkpoint(
        &mut bytes.as_slice(),
        bytes.len() as u64,
        Path::new("memory"),
    )
    .expect("what was written");
    let state = RunState {
        passes: progress.passes,
        samples: progress.next_sample,
        seconds: progress.render_seconds,
    };
    (state, film)
}

/// Stops a run at many moments, each time through a checkpoint, and compares it with a straight one.
fn cut_anywhere(integrator: &str, adaptive: bool, samples: u32, may_be_uneven: bool) {
    let scene = scene(integrator, 64);
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let all = options(Goal::Samples(samples), adaptive);
    let never = AtomicBool::new(false);
    let mut straight = empty(&scene);
    render(
        &scene,
        &accel,
        &all,
        &mut straight,
        &mut RunState::default(),
        &never,
        &mut NoObserver,
    )
    .expect("a film");

    let (mut film, mut state) = (empty(&scene), RunState::default());
    let mut was_uneven = false;
    let mut outcome = Outcome::Interrupted;
    for attempt in 0..10_000u64 {
        let stop = AtomicBool::new(false);
        // Longer and longer, so that it ends on any machine.
        let delay = Duration::from_micros(500 + attempt * 48_271 % 2_000 + 40 * attempt);
        outcome = std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(delay);
                stop.store(true, Ordering::Relaxed);
            });
            render(
                &scene,
                &accel,
                &all,
                &mut film,
                &mut state,
                &stop,
                &mut NoObserver,
            )
        })
        .expect("a pass");
        was_uneven |= film.pending().is_some();
        (state, film) = reread(&state, &film);
        if outcome == Outcome::Finished {
            break;
        }
    }
    assert_eq!(outcome, Outcome::Finished, "{integrator}");
    assert_eq!(was_uneven, may_be_uneven, "{integrator}");
    assert_eq!(state.samples, samples);
    assert!(film == straight, "{integrator}: another image");
}

#[test]
fn runs_that_are_cut_anywhere_come_to_the_same_bits() {
    cut_anywhere("path", false, 16, true);
    cut_anywhere("ao", false, 12, true);
    cut_anywhere("path", true, 24, true);
    cut_anywhere("bdpt", false, 4, false);
}

#[test]
fn a_lower_goal_is_met_where_a_pass_was_cut() {
    // Two pixels of three have 5 samples, one has 2; all shall have 4.
    let scene = scene("path", 32);
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let four = options(Goal::Samples(4), false);
    let mut backend = CpuBackend::new(&scene, &accel, &four);
    let mut film = empty(&scene);
    let counts: Vec<u32> = (0..film.statistics().len())
        .map(|i| if i % 3 == 0 { 2 } else { 5 })
        .collect();
    backend
        .pass(&mut film, 5, Some(&counts), &Stop::NEVER)
        .expect("a pass");
    *film.pending_mut() = Some(halflight::film::pending_samples::PendingSamples {
        per_pixel: 3,
        counts: counts.iter().map(|count| 5 - count).collect(),
    });
    let mut state = RunState {
        samples: 2,
        ..RunState::default()
    };
    let never = AtomicBool::new(false);
    let go_on = |goal, film: &mut Film, state: &mut RunState| {
        let options = options(Goal::Samples(goal), false);
        render(
            &scene,
            &accel,
            &options,
            film,
            state,
            &never,
            &mut NoObserver,
        )
        .expect("a film")
    };
    go_on(4, &mut film, &mut state);
    assert_eq!(state.samples, 4);
    for (pixel, count) in film.statistics().iter().zip(&counts) {
        assert_eq!(pixel.count, (*count).max(4));
    }
    go_on(7, &mut film, &mut state);
    assert_eq!((state.samples, film.pending()), (7, None));
    let mut straight = empty(&scene);
    go_on(7, &mut straight, &mut RunState::default());
    assert!(film == straight);
}

#[test]
fn a_large_layer_of_splats_is_taken_in_parts_alike() {
    // More tiles than are taken at a time.
    let scene = scene("bdpt", 544);
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let one = options(Goal::Samples(1), false);
    let take = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let mut film = empty(&scene);
        pool.install(|| {
            let mut backend = CpuBackend::new(&scene, &accel, &one);
            backend.pass(&mut film, 1, None, &Stop::NEVER)
        })
        .expect("a pass");
        film
    };
    let (a, b) = (take(1), take(3));
    assert!(a == b);
    assert!(a.statistics().iter().all(|p| p.count == 1));
    // Its parts hold all of the light: as much as a crop-free small film of the same view.
    let mean = |film: &Film| {
        let sum: f64 = film.mean().iter().map(|p| p[1]).sum();
        sum / film.statistics().len() as f64
    };
    let small = scene_mean();
    assert!(
        (mean(&a) / small - 1.0).abs() < 0.02,
        "{} against {small}",
        mean(&a)
    );
}

/// Mean green of the view by path tracing.
fn scene_mean() -> f64 {
    let scene = scene("path", 96);
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let options = options(Goal::Samples(64), false);
    let mut film = empty(&scene);
    let never = AtomicBool::new(false);
    render(
        &scene,
        &accel,
        &options,
        &mut film,
        &mut RunState::default(),
        &never,
        &mut NoObserver,
    )
    .expect("a film");
    let sum: f64 = film.mean().iter().map(|p| p[1]).sum();
    sum / film.statistics().len() as f64
}
