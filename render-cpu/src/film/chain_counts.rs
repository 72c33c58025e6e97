//! What became of the mutations of the chains that a film holds.
//!
//! They say how a run went and are no part of the image: films with other counts are equal. Checkpoints keep them, so that a run which
//! goes on later tells of all its mutations.

use halflight_kernel::transport::markov::algorithm::{MutationCounts, WalkCounts};
use serde::{Deserialize, Serialize};

/// Counts of mutations by name.
#[derive(Clone, Debug, Default)]
pub struct ChainCounts {
    mutations: Vec<(String, MutationCounts)>,
    /// Rays of all mutations.
    rays: u64,
}

/// Counts in a checkpoint.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KeptCounts {
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    mutations: Vec<CheckpointCounts>,
    /// Rays of those mutations.
    #[serde(default)]
    mutation_rays: u64,
}

/// The counts of a mutation in a checkpoint.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct CheckpointCounts {
    name: String,
    /// Proposed, lit, accepted; walks, found, irreversible, iterations, iterations of found, jumps, accepted jumps, tested.
    numbers: [u64; 11],
}

impl PartialEq for ChainCounts {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl ChainCounts {
    /// Adds those of a mutation; ones that were never proposed are left out.
    pub fn add(&mut self, name: &str, counts: &MutationCounts) {
        if counts.proposed == 0 {
            return;
        }
        match self.mutations.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => sum.merge(counts),
            None => self.mutations.push((name.to_owned(), *counts)),
        }
    }

    /// Adds those of another film.
    pub fn merge(&mut self, other: &ChainCounts) {
        for (name, counts) in &other.mutations {
            self.add(name, counts);
        }
        self.add_rays(other.rays);
    }

    /// Adds rays of mutations.
    pub fn add_rays(&mut self, rays: u64) {
        self.rays += rays;
    }

    /// Rays for each proposal, nothing without chains.
    pub fn rays_per_mutation(&self) -> Option<f64> {
        let proposed: u64 = self.iter().map(|(_, counts)| counts.proposed).sum();
        (proposed > 0).then(|| self.rays as f64 / proposed as f64)
    }

    /// Those of each mutation.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &MutationCounts)> {
        self.mutations
            .iter()
            .map(|(name, counts)| (name.as_str(), counts))
    }

    /// For a checkpoint.
    pub fn kept(&self) -> KeptCounts {
        let kept = |(name, c): (&str, &MutationCounts)| {
            let w = &c.walks;
            CheckpointCounts {
                name: name.to_owned(),
                numbers: [
                    c.proposed,
                    c.lit,
                    c.accepted,
                    w.walks,
                    w.found,
                    w.irreversible,
                    w.iterations,
                    w.iterations_of_found,
                    w.jumps,
                    w.accepted_jumps,
                    w.tested,
                ],
            }
        };
        KeptCounts {
            mutations: self.iter().map(kept).collect(),
            mutation_rays: self.rays,
        }
    }

    /// From a checkpoint.
    pub fn of_kept(kept: &KeptCounts) -> ChainCounts {
        let mut counts = ChainCounts {
            rays: kept.mutation_rays,
            ..ChainCounts::default()
        };
        for CheckpointCounts { name, numbers } in &kept.mutations {
            let [proposed, lit, accepted, walks @ ..] = *numbers;
            let [
                walks,
                found,
                irreversible,
                iterations,
                of_found,
                jumps,
                accepted_jumps,
                tested,
            ] = walks;
            let walks = WalkCounts {
                walks,
                found,
                tested,
                irreversible,
                iterations,
                iterations_of_found: of_found,
                jumps,
                accepted_jumps,
            };
            let of_mutation = MutationCounts {
                proposed,
                lit,
                accepted,
                walks,
            };
            counts.add(name, &of_mutation);
        }
        counts
    }

    /// As JSON, or nothing without chains.
    pub fn json(&self) -> Option<serde_json::Value> {
        let entries = self.mutations.iter().map(|(name, counts)| {
            let walks = &counts.walks;
            let mut entry = serde_json::json!({
                "proposed": counts.proposed,
                "lit": counts.lit,
                "accepted": counts.accepted,
            });
            if walks.walks > 0 {
                entry["walks"] = serde_json::json!({
                    "made": walks.walks,
                    "found": walks.found,
                    "tested": walks.tested,
                    "irreversible": walks.irreversible,
                    "iterations": walks.iterations,
                    "iterations_of_found": walks.iterations_of_found,
                    "jumps": walks.jumps,
                    "accepted_jumps": walks.accepted_jumps,
                });
            }
            (name.clone(), entry)
        });
        (!self.mutations.is_empty()).then(|| serde_json::Value::Object(entries.collect()))
    }
}

/// One line on a mutation.
pub fn describe(name: &str, counts: &MutationCounts) -> String {
    let percent = |n: u64, of: u64| n as f64 / of.max(1) as f64 * 100.0;
    let mut line = format!(
        "{name}: {} proposals, {:.1} % with light, {:.1} % accepted",
        counts.proposed,
        percent(counts.lit, counts.proposed),
        percent(counts.accepted, counts.proposed)
    );
    let walks = &counts.walks;
    if walks.walks > 0 {
        line += &format!(
            "; {} walks, {:.1} % found in {:.2} iterations ({:.2} in all), {:.2} % not reversible",
            walks.walks,
            percent(walks.found, walks.walks),
            walks.iterations_of_found as f64 / walks.found.max(1) as f64,
            walks.iterations as f64 / walks.walks as f64,
            percent(walks.irreversible, walks.tested)
        );
    }
    if walks.jumps > 0 {
        line += &format!(
            "; {} jumps, {:.1} % accepted",
            walks.jumps,
            percent(walks.accepted_jumps, walks.jumps)
        );
    }
    line
}
