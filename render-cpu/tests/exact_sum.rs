//! Exact sums against big integers, and in any order.

use halflight::film::exact_sum::{ExactMoments, ExactSquareSum, ExactSum, LIMIT};
use num_bigint::BigInt;
use proptest::collection::vec;
use proptest::prelude::*;

/// Bits behind the binary point of the reference: the square of the least float is 2^-298.
const REFERENCE_FRACTION: usize = 298;

/// A float as a multiple of 2^-149.
fn integer(x: f32) -> BigInt {
    let bits = x.to_bits();
    let exponent = bits >> 23 & 0xff;
    let fraction = i64::from(bits & 0x007f_ffff);
    let magnitude = match exponent {
        0 => BigInt::from(fraction),
        _ => BigInt::from(fraction | 1 << 23) << (exponent - 1),
    };
    if x.is_sign_negative() {
        -magnitude
    } else {
        magnitude
    }
}

/// Two's complement of 192 bits without a sign.
fn unsigned(words: [u64; 3]) -> BigInt {
    words
        .into_iter()
        .rev()
        .fold(BigInt::from(0), |sum, word| (sum << 64) + word)
}

/// Floats of every magnitude, and often of one that renderers meet.
fn term() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<u32>().prop_map(|bits| f32::from_bits(bits).clamp(-LIMIT, LIMIT)),
        -10.0f32..10.0,
        1e-12f32..1e-6,
        1e3f32..1e9,
        Just(0.0),
    ]
    .prop_filter("a number", |x| x.is_finite())
}

fn moments(terms: &[f32]) -> ExactMoments {
    let mut moments = ExactMoments::ZERO;
    for &x in terms {
        moments.add(x);
    }
    moments
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn no_order_and_no_division_changes_a_bit(
        terms in vec(term(), 1..200),
        order in any::<u64>(),
        cuts in vec(0usize..200, 0..6),
    ) {
        let whole = moments(&terms);
        let mut permuted = terms.clone();
        let mut state = order | 1;
        for i in (1..permuted.len()).rev() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            permuted.swap(i, (state >> 33) as usize % (i + 1));
        }
        prop_assert_eq!(moments(&permuted), whole);

        let mut cuts: Vec<usize> = cuts.into_iter().map(|cut| cut.min(permuted.len())).collect();
        cuts.extend([0, permuted.len()]);
        cuts.sort_unstable();
        let parts: Vec<ExactMoments> = cuts.windows(2).map(|w| moments(&permuted[w[0]..w[1]])).collect();
        let mut forwards = ExactMoments::ZERO;
        for part in &parts {
            forwards.merge(part);
        }
        let mut backwards = ExactMoments::ZERO;
        for part in parts.iter().rev() {
            backwards.merge(part);
        }
        prop_assert_eq!(forwards, whole);
        prop_assert_eq!(backwards, whole);
    }

    #[test]
    fn errors_stay_below_half_a_unit_per_term(terms in vec(term(), 1..100)) {
        let found = moments(&terms);
        let sum: BigInt = terms.iter().map(|&x| integer(x)).sum();
        let error: BigInt = (BigInt::from(found.sum.fixed()) << (149 - 56)) - sum;
        let rounded = terms.iter().filter(|x| x.abs() < 1.2e-10 && **x != 0.0).count();
        let bound: BigInt = BigInt::from(rounded) << (149 - 57);
        prop_assert!(error.magnitude() <= bound.magnitude());

        let squares: BigInt = terms.iter().map(|&x| integer(x) * integer(x)).sum();
        let fixed = unsigned(found.squares.fixed()) << (REFERENCE_FRACTION - 80);
        let error: BigInt = fixed - squares;
        let rounded = terms.iter().filter(|x| x.abs() < 7.7e-6 && **x != 0.0).count();
        let bound: BigInt = BigInt::from(rounded) << (REFERENCE_FRACTION - 81);
        prop_assert!(error.magnitude() <= bound.magnitude());
    }

    #[test]
    fn a_value_is_the_nearest_double(terms in vec(term(), 1..50)) {
        let found = moments(&terms);
        for (fixed, unit, value) in [
            (BigInt::from(found.sum.fixed()), 56, found.sum.value()),
            (unsigned(found.squares.fixed()), 80, found.squares.value()),
        ] {
            // |fixed - value / unit| is at most half the spacing of doubles there.
            let scaled = value * 2f64.powi(unit);
            let twice: BigInt = (BigInt::from(scaled as i128) - fixed) * 2;
            if scaled.abs() < 1e38 {
                let spacing = (scaled.abs() * f64::EPSILON) as i128;
                prop_assert!(twice.magnitude() <= BigInt::from(spacing + 1).magnitude());
            }
        }
    }

    #[test]
    fn variances_are_those_of_two_passes(
        center in prop_oneof![Just(0.0f32), 1e-3f32..1e6],
        deviations in vec(-1e-3f32..1e-3, 2..100),
        zeros in 0u64..1000,
    ) {
        // Deviations as small beside the mean as floats can hold.
        let terms: Vec<f32> = deviations.iter().map(|d| center * (1.0 + d) + d).collect();
        let n = terms.len() as u64 + zeros;
        let found = moments(&terms);
        let mean = terms.iter().map(|&x| f64::from(x)).sum::<f64>() / n as f64;
        let squares = terms.iter().map(|&x| (f64::from(x) - mean).powi(2)).sum::<f64>();
        let variance = (squares + zeros as f64 * mean * mean) / (n as f64 * (n - 1) as f64);
        prop_assert!((found.mean(n) - mean).abs() <= 1e-13 * mean.abs() + 1e-17);
        let tolerance = 1e-9 * variance + 1e-12 * mean * mean / n as f64 * f64::EPSILON + 1e-24;
        prop_assert!((found.variance_of_mean(n) - variance).abs() <= tolerance, "{} {variance}", found.variance_of_mean(n));
    }
}

#[test]
fn what_is_no_number_adds_nothing_and_what_is_too_large_the_limit() {
    let mut found = moments(&[
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        -f32::NAN,
        0.0,
        -0.0,
    ]);
    assert_eq!(found, ExactMoments::ZERO);
    found.add(f32::MAX);
    found.add(-2.0 * LIMIT);
    found.add(-LIMIT);
    assert_eq!(found.sum.value(), -f64::from(LIMIT));
    assert_eq!(found.squares.value(), 3.0 * f64::from(LIMIT).powi(2));
}

#[test]
fn the_promised_number_of_terms_fits() {
    // 2^30 terms at the limit by doubling, and three quarters as many of the other sign.
    let (mut up, mut down) = (moments(&[LIMIT]), moments(&[-LIMIT]));
    for _ in 0..30 {
        let (a, b) = (up, down);
        up.merge(&a);
        down.merge(&b);
    }
    let whole = 2f64.powi(70);
    assert_eq!(up.sum.value(), whole);
    assert_eq!(down.sum.value(), -whole);
    assert_eq!(up.squares.value(), 2f64.powi(110));
    let mut both = up;
    both.merge(&down);
    assert_eq!(both.sum, ExactSum::ZERO);
    assert_eq!(both.squares.value(), 2f64.powi(111));
    assert_eq!(up.mean(1 << 30), f64::from(LIMIT));
    assert_eq!(up.variance_of_mean(1 << 30), 0.0);
}

#[test]
fn small_terms_are_rounded_to_the_nearest_unit() {
    let unit = 2f32.powi(-56);
    for (x, units) in [(0.49, 0), (0.5, 1), (1.49, 1), (1.5, 2), (2.5, 3)] {
        for sign in [1.0, -1.0] {
            let mut sum = ExactSum::ZERO;
            sum.add(sign * x * unit);
            assert_eq!(sum.fixed(), units * sign as i128, "{x}");
        }
    }
    let root = 2f32.powi(-40);
    for (x, units) in [
        (0.5, 0),
        (0.7, 0),
        (0.71, 1),
        (1.0, 1),
        (1.25, 2),
        (1e-20, 0),
    ] {
        let mut sum = ExactSquareSum::ZERO;
        sum.add(x * root);
        assert_eq!(sum.fixed(), [units, 0, 0], "{x}");
    }
}

#[test]
fn records_are_as_small_as_they_say() {
    assert_eq!(size_of::<ExactSum>(), 16);
    assert_eq!(size_of::<ExactSquareSum>(), 24);
    assert_eq!(size_of::<ExactMoments>(), 40);
    let found = moments(&[0.1, 2.5e7, -3.0]);
    assert_eq!(
        bytemuck::pod_read_unaligned::<ExactMoments>(bytemuck::bytes_of(&found)),
        found
    );
}
