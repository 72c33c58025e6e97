//! The images of all strategies, made in one pass.

use crate::scenes::{LAMP, PINHOLE, room, scene};
use halflight::accel::Accel;
use halflight::film::Film;
use halflight::film::aov::AovSet;
use halflight::plot::strategy_sheet::draw;
use halflight::render::{
    Backend, Goal, RenderOptions, Stop, StrategyBackend, StrategyPyramid, render_film,
};
use halflight::scene::build::Scene;
use halflight_kernel::transport::integrator_kind;

const OPTIONS: RenderOptions = RenderOptions {
    goal: Goal::Samples(16),
    seed: 5,
    first_sample: 0,
    adaptive: false,
};

fn lit_room(max_depth: u32) -> Scene {
    let material = r#"<bsdf type="diffuse"><rgb name="reflectance" value="0.6, 0.5, 0.4"/></bsdf>"#;
    let mut scene = scene(&format!("{PINHOLE}{}{LAMP}", room(material)), &[]);
    scene.settings.kind = integrator_kind::BIDIRECTIONAL;
    scene.settings.rules.max_depth = max_depth;
    scene
}

fn films(scene: &Scene, pyramid: StrategyPyramid) -> Film {
    let accel = Accel::build(scene.tables.view(), &scene.tables.groups);
    let mut film = pyramid.film(scene).unwrap();
    let mut backend = StrategyBackend {
        scene,
        accel: &accel,
        options: &OPTIONS,
        pyramid,
    };
    backend.pass(&mut film, 16, None, &Stop::NEVER).unwrap();
    film
}

#[test]
fn a_pyramid_holds_every_strategy_once() {
    for has_lens in [false, true] {
        let pyramid = StrategyPyramid {
            length: 5,
            has_lens,
        };
        let mut expected = 0;
        for k in 1..=5 {
            for s in 0..pyramid.columns(k) {
                assert_eq!(pyramid.index(s, k + 1 - s), Some(expected));
                expected += 1;
            }
        }
        assert_eq!(pyramid.count() as usize, expected);
        assert_eq!(pyramid.index(0, 0), None);
        assert_eq!(pyramid.index(0, 7), None);
        assert_eq!(pyramid.index(2, 0).is_some(), has_lens);
    }
}

#[test]
fn the_images_of_all_strategies_add_up_to_the_image() {
    let scene = lit_room(4);
    let film = films(&scene, StrategyPyramid::new(&scene, 4));
    let whole = render_film(&scene, &OPTIONS, AovSet::NONE).unwrap();
    let (sums, expected) = (film.mean(), whole.mean());
    assert!(expected.iter().any(|p| p[0] > 0.1));
    for (i, pixel) in expected.iter().enumerate() {
        for c in 0..3 {
            let sum: f64 = sums
                .iter()
                .skip(i)
                .step_by(expected.len())
                .map(|p| p[c])
                .sum();
            // The same samples, in sums of another order and rounded at other places.
            let tolerance = 1e-4 * pixel[c] + 1e-6;
            assert!(
                (sum - pixel[c]).abs() < tolerance,
                "{i}: {sum} {}",
                pixel[c]
            );
        }
    }
}

#[test]
fn a_strategy_has_the_image_that_it_has_alone() {
    let mut scene = lit_room(3);
    let pyramid = StrategyPyramid::new(&scene, 6);
    assert_eq!(pyramid.length, 3, "the scene's own limit");
    let film = films(&scene, pyramid);
    let mean = film.mean();
    for (s, t) in [(0, 3), (1, 2), (2, 2), (2, 1), (3, 1)] {
        scene.settings.bidirectional.only_s = s;
        scene.settings.bidirectional.only_t = t;
        let alone = render_film(&scene, &OPTIONS, AovSet::NONE).unwrap().mean();
        let at = pyramid.index(s, t).unwrap() * alone.len();
        for (i, pixel) in alone.iter().enumerate() {
            let (a, b) = (mean[at + i][1], pixel[1]);
            assert!((a - b).abs() < 1e-4 * b + 1e-6, "({s}, {t}) {i}: {a} {b}");
        }
        assert!(alone.iter().any(|p| p[1] > 0.0), "({s}, {t}) is black");
    }
}

#[test]
fn films_do_not_depend_on_threads() {
    let scene = lit_room(4);
    let pyramid = StrategyPyramid::new(&scene, 4);
    let of = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| films(&scene, pyramid))
    };
    assert_eq!(of(1), of(3));
}

#[test]
fn a_sheet_has_a_row_for_every_length() {
    let scene = lit_room(3);
    let pyramid = StrategyPyramid::new(&scene, 3);
    let film = films(&scene, pyramid);
    let canvas = draw(pyramid, &film, "room").unwrap();
    let [width, height] = canvas.size();
    // Cells of an 8 by 6 image are 72 by 54; the lamp's first row has two of them, the last four.
    assert_eq!([width, height], [96 + 4 * 78 + 6, 34 + 3 * 78 + 6]);
    let pixel = |x: u32, y: u32| {
        let at = 3 * (y * width + x) as usize;
        &canvas.rgb()[at..at + 3]
    };
    let corner = |k: u32, s: u32| (96 + s * 78, 34 + (k - 1) * 78);
    let is_picture = |k, s| {
        let (x, y) = corner(k, s);
        (0..72).any(|dx| (0..54).any(|dy| pixel(x + dx, y + dy) != [255; 3]))
    };
    assert!(is_picture(1, 1) && is_picture(3, 3));
    assert!(!is_picture(1, 2) && !is_picture(2, 3));
}
