//! Vectors of primary samples: uniform whatever was accepted, symmetric small steps, nothing left of what was rejected.
//!
//! Seeds are fixed; thresholds are false-alarm rates of 1e-6.

use halflight_kernel::sampler::primary::{BLOCK, CAPACITY, perturbed};
use halflight_kernel::sampler::{FreshSamples, PrimarySamples, Sampler};
use statrs::distribution::{ChiSquared, ContinuousCDF};

const FALSE_ALARM: f64 = 1e-6;

fn p_value(counts: &[f64], expected: &[f64]) -> f64 {
    let chi2: f64 = counts
        .iter()
        .zip(expected)
        .map(|(c, e)| (c - e).powi(2) / e)
        .sum();
    1.0 - ChiSquared::new(counts.len() as f64 - 1.0)
        .unwrap()
        .cdf(chi2)
}

fn chain(number: u32) -> PrimarySamples {
    PrimarySamples::new(FreshSamples::new(1, number, 0), 2, number)
}

#[test]
fn numbers_stay_uniform_whatever_steps_are_accepted() {
    let chains = 20_000;
    let bins = 64;
    let mut counts = vec![vec![0.0; bins]; 3];
    for number in 0..chains {
        let mut samples = chain(number);
        let choice = FreshSamples::new(3, number, 0);
        for step in 0..12 {
            // Large ones, small ones and rejected ones in any order; the second number is often left out.
            samples.propose(choice.number(3 * step) < 0.2);
            samples.next_1d();
            if choice.number(3 * step + 1) < 0.3 {
                samples.next_1d();
            }
            if choice.number(3 * step + 2) < 0.7 {
                samples.accept();
            }
        }
        for (counts, dimension) in counts.iter_mut().zip([0, 1, 9]) {
            let u = samples.current(dimension);
            assert!((0.0..1.0).contains(&u));
            counts[(u * bins as f32) as usize] += 1.0;
        }
    }
    let expected = vec![f64::from(chains) / bins as f64; bins];
    for counts in counts {
        let p = p_value(&counts, &expected);
        assert!(p > FALSE_ALARM, "p = {p}");
    }
}

#[test]
fn small_steps_are_as_long_forward_as_back_and_even_over_the_logarithm_of_their_length() {
    let n = 1 << 16;
    let bins = 16;
    let mut counts = vec![0.0; 2 * bins];
    for i in 0..n {
        let u = (i as f32 + 0.5) / n as f32;
        let mut change = perturbed(0.4, u, 1.0) - 0.4;
        assert!((perturbed(0.999, u, 1.0) - 0.4).abs() <= 0.6 + 1e-6);
        let is_up = change > 0.0;
        change = change.abs();
        let log = (change * 1024.0).ln() / 16_f32.ln();
        assert!((-1e-3..1.0 + 1e-3).contains(&log), "{change}");
        let bin = ((log * bins as f32) as usize).min(bins - 1);
        counts[bin + if is_up { bins } else { 0 }] += 1.0;
    }
    for (i, count) in counts.iter().enumerate() {
        let expected = f64::from(n) / (2 * bins) as f64;
        // A grid of u, not random numbers: only the rounding of lengths is left.
        assert!((count - expected).abs() < 0.01 * expected, "{i}: {count}");
    }
}

#[test]
fn small_steps_go_around_the_ends() {
    assert!(perturbed(0.001, 0.5, 1.0) > 0.98);
    assert!(perturbed(0.999, 0.0, 1.0) < 0.02);
    for i in 0..10_000 {
        let u = i as f32 / 10_000.0;
        for value in [0.0, 1e-9, 0.5, 1.0 - f32::EPSILON / 2.0] {
            assert!((0.0..1.0).contains(&perturbed(value, u, 1.0)));
        }
    }
}

#[test]
fn rejected_steps_leave_no_trace() {
    let mut samples = chain(7);
    samples.propose(false);
    let first: Vec<f32> = (0..20).map(|_| samples.next_1d()).collect();
    samples.accept();
    for is_large in [true, false, true, false] {
        samples.propose(is_large);
        let proposed: Vec<f32> = (0..20).map(|_| samples.next_1d()).collect();
        assert_ne!(proposed, first);
    }
    let now: Vec<f32> = (0..20).map(|d| samples.current(d)).collect();
    assert_eq!(now, first);
}

#[test]
fn a_number_is_the_same_whenever_it_is_asked_for() {
    let (mut often, mut seldom) = (chain(5), chain(5));
    for step in 0..40 {
        for samples in [&mut often, &mut seldom] {
            samples.propose(step % 11 == 10);
            samples.next_1d();
            if step % 3 != 0 {
                samples.accept();
            }
        }
        often.current(6);
    }
    assert_eq!(often.current(6), seldom.current(6));
    assert_eq!(often.current(0), seldom.current(0));
}

#[test]
fn bounces_keep_their_numbers() {
    let mut few = FreshSamples::new(1, 2, 3);
    let mut many = few;
    few.start_bounce(4);
    many.next_2d();
    many.start_bounce(2);
    many.next_1d();
    many.start_bounce(4);
    assert_eq!(few.next_1d(), many.next_1d());
    // More than a block: no number comes twice.
    let mut long = FreshSamples::new(1, 2, 3);
    let mut seen: Vec<u32> = (0..2 * BLOCK).map(|_| long.next_1d().to_bits()).collect();
    long.start_bounce(0);
    seen.push(long.next_1d().to_bits());
    let count = seen.len();
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), count);
}

#[test]
fn numbers_beyond_the_capacity_change_with_large_steps_only() {
    let far = CAPACITY as u32 + 3;
    let mut samples = chain(1);
    let start = samples.current(far);
    samples.propose(false);
    assert_eq!(samples.number(far), start);
    samples.accept();
    samples.propose(true);
    let fresh = samples.number(far);
    assert_ne!(fresh, start);
    assert_eq!(samples.current(far), start);
    samples.accept();
    assert_eq!(samples.current(far), fresh);
}
