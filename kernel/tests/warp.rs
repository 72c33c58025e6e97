//! Maps from the square against their densities, and cumulative tables against theirs.
//!
//! Each map is binned in coordinates in which its density is uniform (an inverse written down independently), 16 x 16
//! cells, and tested by chi-square with fixed random numbers at a false-alarm rate of 1e-6 per map.

mod common;

use common::Random;
use glam::{Vec2, Vec3};
use halflight_kernel::math::distribution::{
    GUIDE_WORDS, ONE_MINUS_EPSILON, cdf_pmf, fill_cdf, fill_guide, sample_cdf, sample_cdf_guided,
};
use halflight_kernel::math::warp::*;
use proptest::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f32::consts::{PI, TAU};

/// Chi-square p-value of the images of random points under `to_square`, which should be uniform.
fn p_value(to_square: impl Fn(Vec2) -> Vec2) -> f64 {
    const N: u32 = 1 << 17;
    let mut random = Random(77);
    let mut counts = [0_u32; 256];
    for _ in 0..N {
        let q = to_square(random.next_2d());
        assert!(
            q.x > -1e-3 && q.x < 1.001 && q.y > -1e-3 && q.y < 1.001,
            "{q}"
        );
        let cell = |x: f32| ((x * 16.0) as i32).clamp(0, 15) as usize;
        counts[cell(q.x) * 16 + cell(q.y)] += 1;
    }
    let expected = f64::from(N) / 256.0;
    let chi2: f64 = counts
        .iter()
        .map(|c| (f64::from(*c) - expected).powi(2) / expected)
        .sum();
    1.0 - ChiSquared::new(255.0).unwrap().cdf(chi2)
}

fn azimuth(x: f32, y: f32) -> f32 {
    let a = y.atan2(x) / TAU;
    if a < 0.0 { a + 1.0 } else { a }
}

#[test]
fn maps_have_their_densities() {
    type Inverse = fn(Vec2) -> Vec2;
    let maps: [(&str, Inverse); 6] = [
        ("disk", |u| {
            let p = square_to_disk(u);
            Vec2::new(p.length_squared(), azimuth(p.x, p.y))
        }),
        ("cosine hemisphere", |u| {
            let w = square_to_cosine_hemisphere(u);
            Vec2::new(w.z * w.z, azimuth(w.x, w.y))
        }),
        ("sphere", |u| {
            let w = square_to_uniform_sphere(u);
            Vec2::new(0.5 + 0.5 * w.z, azimuth(w.x, w.y))
        }),
        ("hemisphere", |u| {
            let w = square_to_uniform_hemisphere(u);
            Vec2::new(w.z, azimuth(w.x, w.y))
        }),
        ("cone", |u| {
            let w = square_to_uniform_cone(u, 0.02);
            Vec2::new((1.0 - w.z) / 0.02, azimuth(w.x, w.y))
        }),
        ("triangle", |u| {
            let b = square_to_triangle(u);
            let s = b.x + b.y;
            Vec2::new(s * s, b.x / s.max(1e-30))
        }),
    ];
    for (name, map) in maps {
        let p = p_value(map);
        assert!(p > 1e-6, "{name}: p = {p}");
    }
}

#[test]
fn densities_integrate_to_one() {
    // Midpoint rule over cos theta; the constants over the whole solid angle.
    let n = 10_000;
    let cosine: f64 = (0..n)
        .map(|i| {
            f64::from(cosine_hemisphere_pdf(
                2.0 * (i as f32 + 0.5) / n as f32 - 1.0,
            ))
        })
        .sum::<f64>()
        * 2.0
        / f64::from(n)
        * std::f64::consts::TAU;
    assert!((cosine - 1.0).abs() < 1e-5, "{cosine}");
    assert!((UNIFORM_SPHERE_PDF * 4.0 * PI - 1.0).abs() < 1e-6);
    assert!((UNIFORM_HEMISPHERE_PDF * 2.0 * PI - 1.0).abs() < 1e-6);
    assert!((DISK_PDF_AREA * PI - 1.0).abs() < 1e-6);
    for k in [1e-9_f32, 1e-4, 0.5, 2.0] {
        assert!((uniform_cone_pdf(k) * TAU * k - 1.0).abs() < 1e-6);
    }
    assert_eq!(uniform_cone_pdf(0.0), 0.0);
}

#[test]
fn narrow_cones_keep_their_width() {
    // A cosine of this cone rounds to one; the sine of its edge must be sqrt(2 k) all the same.
    let k = 1e-10_f32;
    let w = square_to_uniform_cone(Vec2::new(ONE_MINUS_EPSILON, 0.125), k);
    let sine = w.truncate().length();
    assert!((sine / (2.0 * k).sqrt() - 1.0).abs() < 1e-5, "{sine}");
}

proptest! {
    #[test]
    fn maps_stay_in_their_domains(
        x in prop_oneof![Just(0.0), Just(0.5), Just(ONE_MINUS_EPSILON), 0.0_f32..1.0],
        y in prop_oneof![Just(0.0), Just(0.5), Just(ONE_MINUS_EPSILON), 0.0_f32..1.0],
        k in prop_oneof![Just(2.0_f32), Just(1e-30), 0.0_f32..2.0],
    ) {
        let u = Vec2::new(x, y);
        prop_assert!(square_to_disk(u).length() <= 1.0 + 1e-6);
        let unit = |w: Vec3| (w.length() - 1.0).abs() < 1e-6;
        let w = square_to_cosine_hemisphere(u);
        prop_assert!(unit(w) && w.z > 0.0);
        prop_assert!(unit(square_to_uniform_sphere(u)));
        let w = square_to_uniform_hemisphere(u);
        prop_assert!(unit(w) && w.z >= 0.0);
        let w = square_to_uniform_cone(u, k);
        prop_assert!(unit(w) && 1.0 - w.z <= k * (1.0 + 1e-6) + 1e-7);
        let b = square_to_triangle(u);
        prop_assert!(b.x >= 0.0 && b.y >= 0.0 && b.x + b.y <= 1.0);
    }

    #[test]
    fn tables_keep_every_positive_weight_and_no_other(
        weights in prop::collection::vec(
            prop_oneof![
                Just(0.0_f32), Just(1e-38), Just(1e-20), Just(1e38), Just(f32::NAN), Just(f32::INFINITY),
                Just(-1.0), 0.0_f32..1.0, 0.0_f32..1e6
            ],
            1..200,
        ),
        us in prop::collection::vec(prop_oneof![Just(0.0), Just(ONE_MINUS_EPSILON), 0.0_f32..1.0], 50),
    ) {
        let mut data = vec![5.0; 2];
        data.extend(&weights);
        let count = weights.len() as u32;
        let total = fill_cdf(&mut data[2..]);
        let is_valid = |w: f32| w > 0.0 && w.is_finite();
        prop_assert_eq!(total > 0.0, weights.iter().any(|w| is_valid(*w)));
        let mut sum = 0.0;
        for i in 0..count {
            let pmf = cdf_pmf(&data, 2, i);
            prop_assert!(pmf >= 0.0);
            if total > 0.0 {
                let w = weights[i as usize];
                prop_assert_eq!(pmf > 0.0, is_valid(w), "weight {} got {}", w, pmf);
                if is_valid(w) {
                    // Raised weights and rounding: below 2^-21 of the whole, 200 entries of it at most.
                    let exact = f64::from(w) / total;
                    prop_assert!((f64::from(pmf) - exact).abs() < 200.0 * 2.4e-7 * exact + 4e-7);
                }
            }
            sum += f64::from(pmf);
        }
        // Differences of neighbours round in the last place.
        prop_assert!((sum - 1.0).abs() < 1e-5);
        for u in us {
            let (i, stretched, pmf) = sample_cdf(&data, 2, count, u);
            prop_assert!(i < count && (0.0..1.0).contains(&stretched));
            prop_assert!(pmf > 0.0);
            prop_assert_eq!(pmf, cdf_pmf(&data, 2, i));
            let upper = data[2 + i as usize];
            prop_assert!(u < upper && u >= upper - pmf - 1e-7);
        }
    }
}

#[test]
fn the_stretched_number_is_uniform_again() {
    let mut data = [0.25, 0.0, 0.5, 0.25];
    fill_cdf(&mut data);
    let (i, t, pmf) = sample_cdf(&data, 0, 4, 0.5);
    assert_eq!((i, t, pmf), (2, 0.5, 0.5));
    let (i, t, pmf) = sample_cdf(&data, 0, 4, 0.25);
    assert_eq!((i, t, pmf), (2, 0.0, 0.5));
}

#[test]
fn guides_find_what_a_search_of_the_whole_table_finds() {
    for count in [1_u32, 3, 128, 1000] {
        // Weights over many magnitudes, with gaps.
        let weight = |i: u32| {
            if i % 5 == 1 {
                0.0
            } else {
                10.0_f32.powi((i * i % 7) as i32 - 3)
            }
        };
        let mut data: Vec<f32> = (0..count).map(weight).collect();
        fill_cdf(&mut data);
        let mut guide = vec![0.0; GUIDE_WORDS as usize];
        fill_guide(&data, &mut guide);
        data.extend(guide);
        for i in 0..100_000 {
            let u = i as f32 / 100_000.0;
            assert_eq!(
                sample_cdf_guided(&data, 0, count, u),
                sample_cdf(&data, 0, count, u)
            );
        }
        // Numbers next to the guide's cells and to the table's steps.
        let steps = (0..count as usize).map(|i| data[i]);
        for u in steps.chain((0..128).map(|i| i as f32 / 128.0)) {
            for u in [u.next_down().max(0.0), u.min(ONE_MINUS_EPSILON)] {
                assert_eq!(
                    sample_cdf_guided(&data, 0, count, u),
                    sample_cdf(&data, 0, count, u)
                );
            }
        }
    }
}
