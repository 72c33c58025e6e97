//! Images of chains do not depend on threads or interruptions, shares merge, darkness is no error.

use crate::scenes::{LAMP, PINHOLE, room, scene};
use halflight::accel::Accel;
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::render::{
    Goal, MutationsPerPixel, NoObserver, RenderOptions, RunState, render, render_film,
};
use halflight::scene::build::Scene;
use halflight_kernel::transport::settings::{ChainSettings, integrator_kind};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

fn small_scene(lamp: &str) -> Scene {
    let wall = r#"<bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf>"#;
    let mut scene = scene(&[PINHOLE, &room(wall), lamp].concat(), &[]);
    scene.settings.kind = integrator_kind::PRIMARY_SAMPLE_MLT;
    scene.settings.chains = ChainSettings {
        candidates: 64,
        chains: 12,
        mutations: 50,
        ..ChainSettings::DEFAULT
    };
    scene
}

fn options(first_sample: u32, groups: u32) -> RenderOptions {
    RenderOptions {
        goal: Goal::Samples(groups),
        seed: 5,
        first_sample,
        adaptive: false,
    }
}

fn image(scene: &Scene, first: u32, groups: u32) -> Film {
    render_film(scene, &options(first, groups), AovSet::NONE).unwrap()
}

#[test]
fn images_do_not_depend_on_threads() {
    let scene = small_scene(LAMP);
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| image(&scene, 0, 3))
    };
    let one = with_threads(1);
    assert!(one.mean().iter().any(|m| m[0] > 0.0));
    assert_eq!(one, with_threads(2));
    assert_eq!(one, with_threads(7));
}

#[test]
fn runs_go_on_where_they_were_interrupted() {
    let scene = small_scene(LAMP);
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let mut film = image(&scene, 0, 2);
    let mut state = RunState {
        passes: 1,
        samples: 2,
        seconds: 0.0,
    };
    render(
        &scene,
        &accel,
        &options(0, 5),
        &mut film,
        &mut state,
        &AtomicBool::new(false),
        &mut NoObserver,
    )
    .unwrap();
    assert_eq!(film, image(&scene, 0, 5));
}

#[test]
fn shares_of_an_image_merge_to_the_whole() {
    let scene = small_scene(LAMP);
    let mut film = image(&scene, 0, 2);
    film.merge(&image(&scene, 2, 3));
    let whole = image(&scene, 0, 5);
    for (a, b) in film.statistics().iter().zip(whole.statistics()) {
        assert_eq!(a.count, b.count);
        for c in 0..3 {
            assert!((a.mean[c] - b.mean[c]).abs() <= 1e-12 * b.mean[c].abs());
        }
    }
    // Groups are independent: no two are alike.
    assert_ne!(image(&scene, 0, 1).mean(), image(&scene, 1, 1).mean());
}

#[test]
fn darkness_gives_a_black_image() {
    let lamp = LAMP.replace("5, 4, 3", "0, 0, 0");
    let film = image(&small_scene(&lamp), 0, 2);
    assert!(film.mean().iter().all(|m| *m == [0.0; 3]));
    assert_eq!(film.total_rejected(), 0);
}

#[test]
fn mutations_per_pixel_become_groups() {
    let scene = small_scene(LAMP);
    let unit = MutationsPerPixel::of(&scene);
    assert_eq!(unit.0, 50);
    let groups = unit.groups(&options(100, 101)).unwrap();
    assert_eq!((groups.first_sample, groups.goal), (2, Goal::Samples(3)));
    let time = RenderOptions {
        goal: Goal::Time(Duration::from_secs(1)),
        ..options(0, 1)
    };
    assert_eq!(unit.groups(&time).unwrap().goal, time.goal);
    let error = unit.groups(&options(99, 1)).unwrap_err();
    assert!(error.contains("multiple of 50"), "{error}");
    // A million mutations at least, one per pixel at least.
    let own = ChainSettings::DEFAULT;
    assert_eq!(own.mutations_per_pixel(1 << 10), 1 << 10);
    assert_eq!(own.mutations_per_pixel(1 << 22), 1);
}
