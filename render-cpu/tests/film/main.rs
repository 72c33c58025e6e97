//! The film, and the image files that are written of it ([`files`]).

mod files;

use glam::Vec3;
use halflight::film::aov::{Aov, AovSample, AovSet};
use halflight::film::{Film, FilmError, PixelStatistics};
use proptest::prelude::*;

/// A number in [0, 1) from two counters (a linear congruential step and a bit mix; quality does not matter here).
fn noise(a: u32, b: u32) -> f32 {
    let mut h = a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    (h ^ (h >> 15)) as f32 / 4_294_967_808.0
}

fn sample(x: u32, y: u32, i: u32) -> (Vec3, AovSample) {
    let u = |k| noise(y * 1000 + x, i * 16 + k);
    let sample = AovSample {
        albedo: [u(3), u(4), u(5)],
        normal: [u(6), u(7), u(8)],
        depth: u(9),
        position: [u(10), u(11), u(12)],
        uv: [u(13), u(14)],
    };
    (Vec3::new(u(0), u(1) * 10.0, u(2) - 0.25), sample)
}

fn fill(film: &mut Film, tile: u32, samples: std::ops::Range<u32>) {
    for mut tile in film.tiles_mut(tile) {
        for y in tile.y()..tile.y() + tile.height() {
            for x in tile.x()..tile.x() + tile.width() {
                for i in samples.clone() {
                    let (radiance, features) = sample(x, y, i);
                    let mut pixel = tile.pixel_mut(x, y);
                    pixel.add_sample(radiance);
                    pixel.add_aovs(&features);
                }
            }
        }
    }
}

fn all() -> AovSet {
    // The state of photon mapping is no layer of samples.
    let layers = AovSet::ALL.iter();
    layers.collect()
}

#[test]
fn statistics_are_those_of_two_passes() {
    let values: Vec<Vec3> = (0..1000)
        .map(|i| sample(1, 2, i).0 + Vec3::splat(100.0))
        .collect();
    let mut pixel = PixelStatistics::default();
    values.iter().for_each(|&v| pixel.add(v));
    let n = values.len() as f64;
    for c in 0..3 {
        let mean = values.iter().map(|v| f64::from(v[c])).sum::<f64>() / n;
        let m2 = values
            .iter()
            .map(|v| (f64::from(v[c]) - mean).powi(2))
            .sum::<f64>();
        assert!((pixel.mean[c] - mean).abs() < 1e-11 * mean.abs());
        assert!((pixel.variance_of_mean()[c] - m2 / (n * (n - 1.0))).abs() < 1e-11 * m2);
    }
    let mean = halflight::film::luminance(pixel.mean);
    let m2: f64 = values
        .iter()
        .map(|v| (halflight::film::luminance(v.to_array().map(f64::from)) - mean).powi(2))
        .sum();
    assert!((pixel.luminance_variance_of_mean() - m2 / (n * (n - 1.0))).abs() < 1e-11 * m2);
}

#[test]
fn samples_that_are_not_finite_count_as_black() {
    let mut pixel = PixelStatistics::default();
    pixel.add(Vec3::new(f32::NAN, 1.0, 1.0));
    pixel.add(Vec3::new(1.0, f32::INFINITY, 1.0));
    pixel.add(Vec3::splat(3.0));
    assert_eq!((pixel.count, pixel.rejected), (3, 2));
    assert_eq!(pixel.mean, [1.0; 3]);
    assert!(pixel.variance_of_mean().iter().all(|v| v.is_finite()));
}

#[test]
fn tiles_cover_every_pixel_once_and_do_not_change_the_film() {
    let mut one = Film::new(21, 13, [0, 0], all()).unwrap();
    fill(&mut one, 64, 0..5);
    for size in [1, 4, 5, 13, 16, 21] {
        let mut other = Film::new(21, 13, [0, 0], all()).unwrap();
        fill(&mut other, size, 0..2);
        fill(&mut other, size.max(3), 2..5);
        assert_eq!(one, other, "tiles of {size}");
    }
    let mut single = Film::new(21, 13, [0, 0], all()).unwrap();
    for i in 0..5 {
        let (radiance, features) = sample(20, 12, i);
        single.pixel_mut(20, 12).add_sample(radiance);
        single.pixel_mut(20, 12).add_aovs(&features);
    }
    assert_eq!(one.pixel(20, 12), single.pixel(20, 12));
    assert_eq!(
        one.aov_sums()[one.aov_sums().len() - 12..],
        single.aov_sums()[one.aov_sums().len() - 12..]
    );
    assert_eq!(one.total_samples(), 21 * 13 * 5);
}

proptest! {
    #[test]
    fn merged_runs_are_the_whole_run(split in 0_u32..40, total in 1_u32..40) {
        let split = split.min(total);
        let mut whole = Film::new(3, 2, [0, 0], all()).unwrap();
        fill(&mut whole, 8, 0..total);
        let mut merged = Film::new(3, 2, [0, 0], all()).unwrap();
        fill(&mut merged, 8, 0..split);
        let mut rest = Film::new(3, 2, [0, 0], all()).unwrap();
        fill(&mut rest, 8, split..total);
        merged.merge(&rest);
        for (a, b) in whole.statistics().iter().zip(merged.statistics()) {
            prop_assert_eq!(a.count, b.count);
            for c in 0..3 {
                prop_assert!((a.mean[c] - b.mean[c]).abs() <= 1e-14 * 10.0);
                prop_assert!((a.m2[c] - b.m2[c]).abs() <= 1e-13 * (1.0 + a.m2[c]));
            }
            prop_assert!((a.luminance_m2 - b.luminance_m2).abs() <= 1e-13 * (1.0 + a.luminance_m2));
        }
        for (a, b) in whole.aov_sums().iter().zip(merged.aov_sums()) {
            prop_assert!((a - b).abs() <= 1e-12);
        }
    }
}

#[test]
fn noise_falls_with_the_root_of_the_samples() {
    let noise_of = |n| {
        let mut film = Film::new(16, 16, [0, 0], AovSet::NONE).unwrap();
        fill(&mut film, 16, 0..n);
        film.relative_noise()
    };
    assert_eq!(noise_of(1), 1.0);
    let ratio = noise_of(64) / noise_of(1024);
    assert!((ratio - 4.0).abs() < 0.1, "ratio {ratio}");
}

#[test]
fn absurd_sizes_are_errors() {
    assert_eq!(
        Film::new(0, 5, [0, 0], AovSet::NONE).unwrap_err(),
        FilmError::Empty(0, 5)
    );
    let error = Film::new(u32::MAX, u32::MAX, [0, 0], all()).unwrap_err();
    assert_eq!(error, FilmError::TooLarge(u32::MAX, u32::MAX));
}

#[test]
fn output_variables_have_names() {
    for aov in Aov::ALL {
        assert_eq!(aov.name().parse(), Ok(aov));
    }
    assert!("Normal".parse::<Aov>().is_err());
    let set: AovSet = [Aov::Uv, Aov::Albedo].into_iter().collect();
    assert_eq!(set.to_string(), "albedo,uv");
    assert_eq!(
        (
            set.accumulators(),
            set.offset(Aov::Uv),
            all().accumulators()
        ),
        (5, 3, 13)
    );
    assert!(!AovSet::NONE.with(Aov::Variance).needs_surface());
}
