//! What path tracing keeps of a path and what it leaves to chains are all of it.

use halflight_kernel::path::remainder::{LEAST_EDGES, MOST_EDGES, Remainder};
use halflight_kernel::transport::markov::veach::balance::{CandidatePath, balance};
use proptest::prelude::*;

/// The power heuristic's weights in f64.
fn weights([a, b]: [f64; 2]) -> [f64; 2] {
    let sum = a * a + b * b;
    [a * a / sum, b * b / sum]
}

proptest! {
    #[test]
    fn kept_and_left_are_all(
        exponents in prop::array::uniform4(-6.0f32..6.0),
        which in 0..4u32,
        edges in LEAST_EDGES..=MOST_EDGES,
    ) {
        let [luminance, scale, p0, p1] = exponents.map(|x| 10f32.powf(x));
        let pdf = [if which == 1 { 0.0 } else { p0 }, if which == 2 { 0.0 } else { p1 }];
        let remainder = Remainder { scale };
        let share = weights(pdf.map(f64::from));
        let kept: f64 = (0..2)
            .filter(|&i| pdf[i] > 0.0)
            .map(|i| {
                // What path tracing adds to the image, and how often it does.
                let found = share[i] * f64::from(luminance) / f64::from(pdf[i]);
                share[i] * f64::from(remainder.kept(found as f32, edges))
            })
            .sum();
        let left = f64::from(remainder.chain_share(luminance, pdf, edges));
        prop_assert!((kept + left - 1.0).abs() < 1e-5, "{} and {}", kept, left);
    }

    /// m of the balance is n b s, however the light is spread.
    #[test]
    fn the_balance_is_that_of_the_heuristic(
        lights in prop::collection::vec((-2.0f32..1.0, -2.0f32..2.0), 300..400),
        mutations in 0.1f32..10.0,
    ) {
        let probes: Vec<CandidatePath> = lights
            .iter()
            .map(|(weight, pdf)| CandidatePath {
                weight: 10f32.powf(*weight),
                luminance: 1.0,
                pdf: [10f32.powf(*pdf), 0.0],
                edges: 4,
            })
            .collect();
        let candidates = 500;
        let found = balance(&probes, candidates, mutations);
        let left: f32 = probes
            .iter()
            .map(|p| p.weight * found.remainder.chain_share(p.luminance, p.pdf, p.edges))
            .sum();
        let total: f32 = probes.iter().map(|p| p.weight).sum();
        let states = found.remainder.scale * left / candidates as f32;
        // An eighth of the mutations count.
        prop_assert!((states / (mutations / 8.0) - 1.0).abs() < 0.1, "{} of {}", states, mutations);
        prop_assert!((found.left - left / total).abs() < 0.05);
    }
}

#[test]
fn ends_of_the_range() {
    let remainder = Remainder { scale: 2.0 };
    assert_eq!(remainder.kept(1e30, LEAST_EDGES - 1), 1.0);
    assert_eq!(remainder.chain_share(1.0, [0.0, 0.0], 4), 1.0);
    assert_eq!(remainder.chain_share(1.0, [1.0, 1.0], MOST_EDGES + 1), 1.0);
    assert_eq!(remainder.chain_share(f32::MAX, [1e-30, 0.0], 4), 1.0);
    assert_eq!(Remainder { scale: 0.0 }.kept(f32::MAX, 5), 1.0);
    assert_eq!(
        Remainder { scale: 0.0 }.chain_share(1.0, [1.0, 0.0], 5),
        0.0
    );
    let nothing = balance(&[], 100, 1.0);
    assert_eq!((nothing.remainder.scale, nothing.left), (0.0, 0.0));
}
