//! How much path tracing keeps of what it finds beside chains ([`crate::path::remainder`]).
//!
//! The scale s = m / (n b) of the balance heuristic needs b, the integral of what is left to chains, which depends on s: s b(s)
//! grows with s, and s is where it is m / n. b(s) is estimated from candidates of its own, so that s is the same for all groups.
//! States of a chain depend on each other: m counts those that are worth an independent one.

use crate::math::float::sqrt;
use crate::path::remainder::Remainder;

/// Mutations that are worth an independent path: a guess, neighbours were not compared.
const MUTATIONS_PER_PATH: f32 = 8.0;

/// Largest share of the sum that a candidate counts for: rarer paths say nothing about the rest.
const LARGEST_SHARE: f32 = 0.02;

/// A path of a candidate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CandidatePath {
    /// Its weight I / p as a candidate.
    pub weight: f32,
    /// I.
    pub luminance: f32,
    /// Densities with which path tracing finds it, by hitting the light and by sampling it.
    pub pdf: [f32; 2],
    /// Its edges.
    pub edges: u32,
}

/// b(s): the mean of what is left over `candidates` candidates whose paths are `probes`.
fn left(probes: &[CandidatePath], largest: f32, candidates: u32, scale: f32) -> f64 {
    let remainder = Remainder { scale };
    let sum: f64 = probes
        .iter()
        .map(|probe| {
            let left = remainder.chain_share(probe.luminance, probe.pdf, probe.edges);
            f64::from(probe.weight.min(largest) * left)
        })
        .sum();
    sum / f64::from(candidates)
}

/// How path tracing and chains share the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// What path tracing leaves.
    pub remainder: Remainder,
    /// Its share of the light that chains look for.
    pub left: f32,
}

/// The balance for `mutations` mutations per sample of path tracing. Path tracing keeps all that it finds if there are no probes.
pub fn balance(probes: &[CandidatePath], candidates: u32, mutations: f32) -> Balance {
    let total: f32 = probes.iter().map(|probe| probe.weight).sum();
    if !(total > 0.0 && total < f32::MAX) || candidates == 0 {
        return Balance {
            remainder: Remainder { scale: 0.0 },
            left: 0.0,
        };
    }
    let largest = LARGEST_SHARE * total;
    let ratio = f64::from(mutations / MUTATIONS_PER_PATH);
    let start = candidates as f32 / total;
    let (mut low, mut high) = (1e-6 * start, 1e6 * start);
    for _ in 0..48 {
        // The mean of the exponents: the range spans many orders.
        let middle = sqrt(low) * sqrt(high);
        if f64::from(middle) * left(probes, largest, candidates, middle) < ratio {
            low = middle;
        } else {
            high = middle;
        }
    }
    let all: f32 = probes.iter().map(|probe| probe.weight.min(largest)).sum();
    let left = left(probes, largest, candidates, low) * f64::from(candidates);
    Balance {
        remainder: Remainder { scale: low },
        left: left as f32 / all,
    }
}
