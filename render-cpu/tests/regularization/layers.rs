//! The layer of regularisation: how much of a pixel's light regularised connections found, and by how much they were blurred.

use crate::known_answers::{floor_by_a_mirror, floor_share_of_mirror, mirror_on_axis};
use crate::scenes::{
    ALGORITHMS, DIFFUSE, MIRROR, add, ball, bits, film_with, mollified, regularized, render_film,
    room, scene,
};
use halflight::film::Film;
use halflight::film::aov::{Aov, AovSet};
use halflight::scene::build::Scene;

fn layer() -> AovSet {
    AovSet::NONE.with(Aov::Regularization)
}

fn with_layer(scene: &Scene, samples: u32) -> Film {
    let mut film = film_with(scene, layer());
    add(scene, &mut film, 0, samples);
    film
}

/// Share of the light of the whole image, and the least and the largest scale of its pixels that have one.
fn of_image(film: &Film) -> (f64, [f64; 2]) {
    let (mut part, mut whole) = (0.0, 0.0);
    let mut scales = [f64::MAX, 0.0];
    for (i, mean) in film.mean().iter().enumerate() {
        let light = halflight::film::luminance(*mean);
        let [share, scale] = [0, 1].map(|c| film.aov_mean(Aov::Regularization, c, i));
        assert!((0.0..=1.0).contains(&share), "a share of {share}");
        assert!((share > 0.0) == (scale > 0.0), "{share} of scale {scale}");
        part += share * light;
        whole += light;
        if scale > 0.0 {
            scales = [scales[0].min(scale), scales[1].max(scale)];
        }
    }
    (part / whole, scales)
}

#[test]
fn the_image_does_not_know_of_the_layer() {
    for name in ALGORITHMS {
        let plain = scene(name, &room(DIFFUSE, &ball(MIRROR)));
        for scene in [
            regularized(plain.clone(), "tau=20"),
            regularized(plain.clone(), "tau=20,fade=0.2,diffusion"),
            mollified(plain.clone(), "r0=5%"),
        ] {
            let expected = render_film(&scene, 3);
            assert!(
                bits(&with_layer(&scene, 3)) == bits(&expected),
                "{name} is another image"
            );
        }
    }
}

#[test]
fn light_that_nothing_else_finds_is_all_regularised() {
    // A point light in a mirror, seen by a pinhole.
    for name in ALGORITHMS {
        let content = mirror_on_axis();
        let scene = mollified(scene(name, &content), "r0=0.3,constant");
        let (share, scales) = of_image(&with_layer(&scene, 16));
        println!("{name}: {share:.4}, radii {scales:?}");
        assert!(share > 0.999, "{name}: {share}");
        assert!(scales.iter().all(|r| (r - 0.3).abs() < 1e-4), "{scales:?}");
    }
}

#[test]
fn rough_surfaces_have_no_share() {
    for name in ALGORITHMS {
        let scene = regularized(scene(name, &room(DIFFUSE, "")), "tau=20");
        let film = with_layer(&scene, 2);
        let (share, scales) = of_image(&film);
        assert!(share == 0.0 && scales[1] == 0.0, "{name}: {share}");
    }
}

#[test]
fn the_share_of_a_mirror_is_that_of_its_light() {
    // Path tracing finds the image of the light by regularised connections alone, and its direct light without them.
    let content = floor_by_a_mirror();
    let mut plain = scene("path", content);
    plain.settings.rules.max_depth = 3;
    let truth = floor_share_of_mirror();
    let film = with_layer(&regularized(plain.clone(), "tau=300,constant"), 4096);
    let (share, scales) = of_image(&film);
    println!("{share:.4} of {truth:.4}, tau {scales:?}");
    assert!((share / truth - 1.0).abs() < 0.1, "{share} of {truth}");
    assert!(scales.iter().all(|t| (t / 300.0 - 1.0).abs() < 1e-4));
    // tau grows with the samples, and the mean lies between the first and the last.
    let (_, scales) = of_image(&with_layer(&regularized(plain, "tau=30"), 64));
    let last = halflight_kernel::regularize::bandwidth::tau_schedule(30.0, 64);
    assert!(
        scales[0] > 30.0 && scales[1] < f64::from(last),
        "{scales:?}"
    );
}

#[test]
fn shares_of_a_run_add_up() {
    for name in ALGORITHMS {
        let scene = regularized(scene(name, &room(DIFFUSE, &ball(MIRROR))), "tau=20");
        let whole = with_layer(&scene, 6);
        let mut resumed = film_with(&scene, layer());
        add(&scene, &mut resumed, 0, 2);
        add(&scene, &mut resumed, 0, 6);
        assert!(resumed.aov_sums() == whole.aov_sums(), "{name}");
        let (share, _) = of_image(&whole);
        println!("{name}: {share:.4}");
        assert!(share > 0.001, "{name}: {share}");
        let mut shares = Vec::new();
        for first in [0, 3] {
            let mut part = film_with(&scene, layer());
            add(&scene, &mut part, first, 3);
            shares.push(part);
        }
        let (a, b) = shares.split_at_mut(1);
        a[0].merge(&b[0]);
        let (merged, _) = of_image(&a[0]);
        assert!(
            (merged / share - 1.0).abs() < 1e-6,
            "{name}: {merged} {share}"
        );
    }
}
