//! Reconstruction filters: their values, and sampling from the part that a film's border leaves.

mod common;

use common::light_scene::{CAMERA, Scene, numbers};
use halflight_kernel::math::filter;
use halflight_kernel::scene::{Camera, filter_kind};
use proptest::prelude::*;

/// Every kind with parameters that make it interesting.
const FILTERS: [(u32, [f32; 3]); 9] = [
    (filter_kind::BOX, [0.5, 0.0, 0.0]),
    (filter_kind::BOX, [1.7, 0.0, 0.0]),
    (filter_kind::TENT, [1.0, 0.0, 0.0]),
    (filter_kind::GAUSSIAN, [2.0, 0.5, 0.0]),
    (filter_kind::GAUSSIAN, [1.2, 0.3, 0.0]),
    (filter_kind::MITCHELL, [2.0, 1.0 / 3.0, 1.0 / 3.0]),
    (filter_kind::MITCHELL, [2.0, 0.2, 0.7]),
    (filter_kind::CATMULL_ROM, [2.0, 0.0, 0.0]),
    (filter_kind::LANCZOS, [3.0, 0.0, 0.0]),
];

fn with_filter(kind: u32, parameters: [f32; 3]) -> (Camera, Vec<f32>) {
    let size = filter::TABLE_SIZE;
    // Not at the start of `data`, so that the offset counts.
    let mut data = vec![9.0; 3];
    data.resize(3 + filter::table_words(size) as usize, 0.0);
    filter::fill_table(kind, parameters, &mut data[3..]);
    let camera = Camera {
        filter: kind,
        filter_parameters: parameters,
        filter_table: 3,
        filter_table_size: size,
        ..CAMERA
    };
    (camera, data)
}

#[test]
fn values_are_those_of_another_renderer() {
    for row in numbers(include_str!("oracle/filters.csv")) {
        let value = filter::eval(row[0] as u32, [row[1], row[2], row[3]], row[4]);
        // Both sides round intermediate terms of size up to four. The other renderer has a polynomial for gaussians,
        // which is off by up to 4e-4 from the definition that both state.
        let is_polynomial = row[0] as u32 == filter_kind::GAUSSIAN;
        let tolerance = if is_polynomial { 5e-4 } else { 2e-6 };
        assert!((value - row[5]).abs() < tolerance, "{row:?}: {value}");
    }
}

#[test]
fn filters_are_even_and_end_at_their_radius() {
    for (kind, parameters) in FILTERS {
        let r = filter::radius(kind, parameters);
        for i in 0..64 {
            let x = (i as f32 + 0.5) / 32.0 * r;
            let value = filter::eval(kind, parameters, x);
            assert_eq!(value, filter::eval(kind, parameters, -x));
            assert!(value == 0.0 || x <= r);
        }
        assert!(filter::eval(kind, parameters, 0.0) > 0.0);
        assert_eq!(filter::eval(kind, parameters, f32::NAN), 0.0);
    }
}

/// Integrals of f and f g over [lo, hi] by the midpoint rule in f64.
fn integrals(
    kind: u32,
    parameters: [f32; 3],
    lo: f32,
    hi: f32,
    g: impl Fn(f64) -> f64,
) -> (f64, f64) {
    const N: u32 = 20_000;
    let (lo, hi) = (f64::from(lo), f64::from(hi));
    let (mut plain, mut weighted) = (0.0, 0.0);
    for i in 0..N {
        let x = lo + (hi - lo) * (f64::from(i) + 0.5) / f64::from(N);
        let f = f64::from(filter::eval(kind, parameters, x as f32)) * (hi - lo) / f64::from(N);
        plain += f;
        weighted += f * g(x);
    }
    (plain, weighted)
}

#[test]
fn samples_reproduce_the_filtered_mean_on_cut_intervals() {
    let g = |x: f64| (1.3 * x).sin() + 0.5 * x * x + 1.0;
    for (kind, parameters) in FILTERS {
        let (camera, data) = with_filter(kind, parameters);
        let r = filter::radius(kind, parameters);
        // The border may come as close as half a pixel.
        for (lo, hi) in [(-r, r), (-0.5, r), (-r, 0.5), (-0.5, 0.5), (-1.5, 0.5)] {
            let (lo, hi) = (lo.max(-r), hi.min(r));
            const N: u32 = 1 << 16;
            let mut mean = 0.0;
            let mut mean_weight = 0.0;
            for i in 0..N {
                let u = (i as f32 + 0.5) / N as f32;
                let (x, weight) = filter::sample(&camera.reconstruction_filter(), &data, lo, hi, u);
                assert!(x >= lo && x <= hi);
                mean += f64::from(weight) * g(f64::from(x)) / f64::from(N);
                mean_weight += f64::from(weight) / f64::from(N);
            }
            let (plain, weighted) = integrals(kind, parameters, lo, hi, g);
            // The step table's error, and that of 2^16 points on a weight that changes sign.
            let tolerance = 2e-4;
            assert!(
                (mean - weighted / plain).abs() < tolerance,
                "{kind} {parameters:?} [{lo}, {hi}]: {mean} against {}",
                weighted / plain
            );
            assert!((mean_weight - 1.0).abs() < tolerance, "{mean_weight}");
        }
    }
}

proptest! {
    #[test]
    fn positive_filters_weigh_every_sample_the_same(
        which in 0_usize..5, u in 0.0_f32..1.0, lo in -2.0_f32..-0.4, hi in 0.4_f32..2.0,
    ) {
        let (kind, parameters) = FILTERS[which];
        let (camera, data) = with_filter(kind, parameters);
        let r = filter::radius(kind, parameters);
        let (_, weight) = filter::sample(&camera.reconstruction_filter(), &data, lo.max(-r), hi.min(r), u);
        prop_assert_eq!(weight, 1.0);
    }

    #[test]
    fn samples_are_total(which in 0_usize..9, u in 0.0_f32..1.0, lo: f32, hi: f32) {
        let (kind, parameters) = FILTERS[which];
        let (camera, data) = with_filter(kind, parameters);
        let r = filter::radius(kind, parameters);
        let (lo, hi) = (lo.clamp(-r, r), hi.clamp(-r, r));
        let (x, weight) = filter::sample(&camera.reconstruction_filter(), &data, lo.min(hi), hi.max(lo), u);
        prop_assert!(x.is_finite() && weight.is_finite());
    }
}

#[test]
fn without_a_table_a_filter_is_even() {
    let scene = Scene::new();
    let (x, weight) = filter::sample(
        &scene.camera.reconstruction_filter(),
        &scene.data,
        -0.5,
        0.5,
        0.25,
    );
    assert_eq!((x, weight), (-0.25, 1.0));
}
