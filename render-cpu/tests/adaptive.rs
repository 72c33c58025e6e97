//! Where adaptive sampling sends its samples.

use glam::Vec3;
use halflight::film::Film;
use halflight::film::adaptive::{UNIFORM_SAMPLES, block_errors, next_sample_counts};
use halflight::film::aov::AovSet;
use halflight_kernel::math::statistics::relative_squared_error;
use proptest::prelude::*;

/// A film whose pixels have alternating samples of mean 1 and the amplitude that `amplitude` says.
fn film(width: u32, height: u32, samples: u32, amplitude: impl Fn(u32, u32) -> f32) -> Film {
    let mut film = Film::new(width, height, [0, 0], AovSet::NONE).unwrap();
    for y in 0..height {
        for x in 0..width {
            for i in 0..samples {
                let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
                film.pixel_mut(x, y)
                    .add_sample(Vec3::splat(1.0 + sign * amplitude(x, y)));
            }
        }
    }
    film
}

fn total(counts: &[u32]) -> u64 {
    counts.iter().map(|&c| u64::from(c)).sum()
}

#[test]
fn first_passes_are_uniform() {
    let early = film(9, 7, UNIFORM_SAMPLES - 1, |x, _| x as f32);
    assert_eq!(next_sample_counts(&early, 3), vec![3; 63]);
    let late = film(9, 7, UNIFORM_SAMPLES, |x, _| x as f32);
    assert_ne!(next_sample_counts(&late, 3), vec![3; 63]);
}

#[test]
fn a_film_without_noise_is_sampled_uniformly() {
    assert_eq!(
        next_sample_counts(&film(9, 7, 20, |_, _| 0.0), 3),
        vec![3; 63]
    );
}

#[test]
fn texture_is_not_noise() {
    let mut checkers = Film::new(16, 16, [0, 0], AovSet::NONE).unwrap();
    for y in 0..16 {
        for x in 0..16 {
            for _ in 0..16 {
                checkers
                    .pixel_mut(x, y)
                    .add_sample(Vec3::splat(if (x + y) % 2 == 0 { 1.0 } else { 0.0 }));
            }
        }
    }
    assert!(block_errors(&checkers).iter().all(|&e| e == 0.0));
}

#[test]
fn noise_and_the_eight_blocks_around_it_get_the_samples() {
    // One noisy block in the middle of a large, slightly noisy film: 32 x 32 blocks, so the clamp is the slight noise
    // unless at least 5 % of the blocks are as noisy. Make an 8 x 8 patch of blocks (6 %) noisy.
    let noisy = |x: u32, y: u32| (48..80).contains(&x) && (48..80).contains(&y);
    let film = film(128, 128, 16, |x, y| if noisy(x, y) { 0.5 } else { 0.05 });
    let counts = next_sample_counts(&film, 8);
    assert_eq!(total(&counts), 8 * 128 * 128);
    let at = |x: usize, y: usize| counts[y * 128 + x];
    // Errors are as the squares of the amplitudes, 100 : 1. With 64 blocks dilated to 100 of 1024 the noisy pixels get
    // 1 + 7 * 1024 * 100 / (100 * 100 + 924 * 1) = 66.6 samples, the others 1.66.
    for (x, y) in [(64, 64), (44, 44), (83, 83), (44, 83), (83, 44)] {
        assert!((66..=67).contains(&at(x, y)), "{x} {y}: {}", at(x, y));
    }
    for (x, y) in [(43, 64), (84, 64), (0, 0), (127, 127)] {
        assert!((1..=2).contains(&at(x, y)), "{x} {y}: {}", at(x, y));
    }
}

#[test]
fn one_firefly_does_not_eat_the_budget() {
    let mut film = film(64, 64, 16, |_, _| 0.1);
    film.pixel_mut(31, 31).add_sample(Vec3::splat(1e6));
    let counts = next_sample_counts(&film, 4);
    assert_eq!(total(&counts), 4 * 64 * 64);
    assert!(counts.iter().all(|&c| c <= 5), "{:?}", counts.iter().max());
}

#[test]
fn decisions_depend_on_the_film_alone() {
    let film = film(33, 17, 17, |x, y| (x * y % 7) as f32 * 0.1);
    assert_eq!(
        next_sample_counts(&film, 5),
        next_sample_counts(&film.clone(), 5)
    );
}

#[test]
fn the_error_is_that_of_the_formula() {
    assert_eq!(relative_squared_error(2.0, 8.0, 4.0), 0.5);
    assert_eq!(relative_squared_error(0.0, 1e-3, 2.0), 0.5);
    assert_eq!(relative_squared_error(1.0, 0.0, 2.0), 0.0);
    assert_eq!(relative_squared_error(1.0, 1.0, 0.0), 0.0);
    assert_eq!(relative_squared_error(0.0, f32::MAX, 1.0), f32::MAX);
    // The block error of a film: amplitude a, n samples per pixel, 16 pixels: n a^2 / (n - 1) / (16 n).
    let errors = block_errors(&film(4, 4, 20, |_, _| 0.5));
    let expected = 20.0 * 0.25 / 19.0 / (16.0 * 20.0);
    assert!(
        (errors[0] / expected - 1.0).abs() < 1e-5,
        "{errors:?} {expected}"
    );
}

proptest! {
    #[test]
    fn the_budget_is_met_exactly(
        width in 1_u32..40,
        height in 1_u32..40,
        spp in 1_u32..200,
        seed in 0_u32..1000,
    ) {
        let amplitude = |x: u32, y: u32| ((x * 7919 + y * 104_729 + seed * 31) % 101) as f32 * 0.02;
        let counts = next_sample_counts(&film(width, height, 16, amplitude), spp);
        prop_assert_eq!(total(&counts), u64::from(spp) * u64::from(width * height));
        prop_assert!(counts.iter().all(|&c| c >= 1));
    }
}
