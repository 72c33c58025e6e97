//! Tables 8.1 and 8.2 of Kaplanyan 2017 on a scene: what walks of the half-vector mutation and of manifold exploration come to.
//!
//! Chains of the bidirectional mutation and one other, from the same starts: the half-vector mutation of full paths with projections
//! from the end that the method chooses, from the light and from the sensor; the one that breaks paths up; manifold exploration
//! in all directions, towards the sensor and towards the light. Walks are those of the forward direction; a walk is constructed when it
//! has found a path. Walks back are made from paths that would be accepted; where they lead elsewhere, there is no way back.

use super::steps::rendered;
use crate::scene::build::Scene;
use halflight_kernel::transport::markov::algorithm::MutationCounts;
use halflight_kernel::transport::settings::{ChainSettings, half_vector_flag, integrator_kind};
use std::fmt::Write;

/// Mutations and their name among the counts.
const VARIANTS: [(&str, &str, u32); 7] = [
    (
        "whole paths, chosen",
        HALF_VECTOR,
        half_vector_flag::ORIGINAL,
    ),
    (
        "whole paths, from the light",
        HALF_VECTOR,
        half_vector_flag::ORIGINAL | half_vector_flag::FROM_LIGHT,
    ),
    (
        "whole paths, from the sensor",
        HALF_VECTOR,
        half_vector_flag::ORIGINAL | half_vector_flag::FROM_SENSOR,
    ),
    ("broken up, chosen", HALF_VECTOR, 0),
    ("exploration", MANIFOLD, 0),
    (
        "exploration, from the light",
        MANIFOLD,
        half_vector_flag::FROM_LIGHT,
    ),
    (
        "exploration, from the sensor",
        MANIFOLD,
        half_vector_flag::FROM_SENSOR,
    ),
];

const HALF_VECTOR: &str = "half-vector";
const MANIFOLD: &str = "manifold";

/// Counts of a mutation by its name in the table.
pub type Row = (&'static str, MutationCounts);

/// Makes so many mutations per pixel, rounded up to whole groups, of each kind.
pub fn run(scene: &mut Scene, samples: u32) -> Vec<Row> {
    let chains = scene.settings.chains;
    scene.settings.kind = integrator_kind::VEACH_MLT;
    let mut rows = Vec::new();
    for (name, mutation, flags) in VARIANTS {
        scene.settings.chains = ChainSettings {
            lens_weight: 0.0,
            caustic_weight: 0.0,
            multi_chain_weight: 0.0,
            manifold_weight: if mutation == MANIFOLD { 1.0 } else { 0.0 },
            half_vector_weight: if mutation == HALF_VECTOR { 1.0 } else { 0.0 },
            half_vector_flags: flags,
            direct_samples: 1,
            ..chains
        };
        let mut counts = MutationCounts::default();
        if let Some(film) = rendered(scene, samples) {
            let of_kind = film.chain_counts().iter().filter(|(n, _)| *n == mutation);
            of_kind.for_each(|(_, more)| counts.merge(more));
        }
        rows.push((name, counts));
    }
    rows
}

/// The rows as text.
pub fn table(rows: &[Row]) -> String {
    let mut text = format!(
        "{:<30}{:>11}{:>9}{:>11}{:>12}{:>8}{:>12}{:>8}{:>10}\n",
        "mutation",
        "proposals",
        "accepted",
        "walks made",
        "iterations",
        "in all",
        "no way back",
        "jumps",
        "accepted"
    );
    let share = |n: u64, of: u64| 100.0 * n as f64 / of.max(1) as f64;
    for (name, counts) in rows {
        let w = &counts.walks;
        let _ = writeln!(
            text,
            "{name:<30}{:>11}{:>7.1} %{:>9.1} %{:>12.2}{:>8.2}{:>10.2} %{:>6.2} %{:>8.1} %",
            counts.proposed,
            share(counts.accepted, counts.proposed),
            share(w.found, w.walks),
            w.iterations_of_found as f64 / w.found.max(1) as f64,
            w.iterations as f64 / w.found.max(1) as f64,
            share(w.irreversible, w.tested),
            share(w.jumps, w.walks - w.found),
            share(w.accepted_jumps, w.jumps),
        );
    }
    text.push_str(
        "\niterations: of walks that found a path; in all: of all walks, per path that was found; jumps: of walks that failed\n",
    );
    text
}
