//! The choice of bidirectional mutations: as often as their probability says, and every one has its way back.

use halflight_kernel::sampler::IndependentSampler;
use halflight_kernel::transport::markov::veach::bidirectional::Change;
use std::collections::BTreeMap;

#[test]
fn changes_are_chosen_with_their_probability() {
    let n = 400_000;
    for (k, limits) in [(1, [1, 5]), (3, [1, 6]), (6, [2, 6]), (2, [2, 31])] {
        let mut counts: BTreeMap<(usize, usize, usize), f64> = BTreeMap::new();
        for i in 0..n {
            let mut sampler = IndependentSampler::new(k as u32, 1, i);
            let change = Change::choose(k, limits, &mut sampler);
            *counts
                .entry((change.light, change.deleted, change.added))
                .or_default() += 1.0;
        }
        let mut sum = 0.0;
        for (&(light, deleted, added), &count) in &counts {
            let change = Change {
                light,
                deleted,
                added,
            };
            // The probability holds the choice of the split, one of as many as edges are added.
            let p = f64::from(change.probability(k, limits)) * added as f64;
            sum += p;
            let expected = p * f64::from(n);
            let deviation = (count - expected).abs() / expected.sqrt().max(1.0);
            assert!(deviation < 6.0, "{change:?} of {k}: {count}, {expected}");
            // What is kept lies within the path, and the way back exists.
            assert!(light + deleted <= k + 1);
            let new = k + added - deleted;
            assert!((limits[0]..=limits[1]).contains(&new), "{change:?}");
            assert!(change.reverse().probability(new, limits) > 0.0);
            assert_eq!(change.reverse().reverse(), change);
        }
        assert!((sum - 1.0).abs() < 1e-3, "{k}: {sum}");
    }
}

#[test]
fn no_change_leaves_the_path_as_it_is() {
    for k in 1..8 {
        for i in 0..5000 {
            let mut sampler = IndependentSampler::new(3, k as u32, i);
            let change = Change::choose(k, [1, 12], &mut sampler);
            assert!(change.deleted != 1 || change.added != 1, "{change:?}");
        }
    }
}
