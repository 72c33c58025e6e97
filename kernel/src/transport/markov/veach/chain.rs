//! A chain of full paths and its steps.

use super::ChainPath;
use super::bidirectional::{self, Change};
use super::caustic_perturbation::{light_chain, propose_from_light};
use super::group::{VeachChains, is_countable, mutation, stream};
use super::lens_perturbation::{propose_from_sensor, sensor_chain};
use crate::bsdf::Bsdf;
use crate::sampler::{FreshSamples, Sampler, mix};
use crate::scene::Traverse;
use crate::transport::markov::algorithm::{
    ChainAlgorithm, MutationCounts, Observation, StepRecord,
};
use crate::transport::markov::half_vector::path_chain::ChainPair;
use crate::transport::markov::half_vector::{half_vector_mutation, manifold_perturbation};
use crate::transport::markov::state::Splat;
use glam::Vec2;

/// A chain.
pub struct VeachChain {
    /// The current and the proposed one, in this order or the other.
    paths: [ChainPath; 2],
    /// Which is the current one.
    current: usize,
    /// Steps that the current path has yet to count for.
    pending: f32,
    /// W of [`crate::transport::markov::annealing`].
    weight: f32,
    number: u32,
    step: u32,
    last: StepRecord,
    half_vectors: ChainPair,
    counts: [MutationCounts; mutation::COUNT],
}

impl VeachChain {
    fn current(&self) -> &ChainPath {
        &self.paths[self.current]
    }
}

impl<T: Traverse + Sync> VeachChains<'_, T> {
    /// Weights of the mutations that a path allows.
    fn allowed(&self, x: &ChainPath) -> [f32; mutation::COUNT] {
        let mut weights = self.weights;
        let has_turns = sensor_chain(x).turns > 0;
        if has_turns {
            weights[mutation::LENS] = 0.0;
        } else {
            weights[mutation::MULTI_CHAIN] = 0.0;
        }
        if light_chain(&self.tracer, x).is_none() {
            weights[mutation::CAUSTIC] = 0.0;
        }
        // Half vectors of a vertex that is blurred, or whose directions edits turn, are no coordinates of it.
        if x.edges() < 2 || x.is_blurred() || x.is_turned() {
            weights[mutation::MANIFOLD] = 0.0;
            weights[mutation::HALF_VECTOR] = 0.0;
        }
        weights
    }

    /// Proposes a mutation of `kind` and returns the probability of its acceptance; where that takes a walk back, one or zero as the
    /// number `u_accept` has decided. Second whether it carries light.
    fn propose(
        &self,
        kind: usize,
        allowed: &[f32; mutation::COUNT],
        chain: &mut VeachChain,
        u_accept: f32,
        sampler: &mut FreshSamples,
        bsdf: &mut Bsdf,
    ) -> (f32, bool) {
        let [first, second] = &mut chain.paths;
        let (x, y) = if chain.current == 0 {
            (&*first, second)
        } else {
            (&*second, first)
        };
        let walks = &mut chain.counts[kind].walks;
        let chains = &mut chain.half_vectors;
        chains.forget_proposed();
        let tracer = &self.tracer;
        let probability = |y: &ChainPath, ratio: f32| self.acceptance(x, y, kind, allowed, ratio);
        let accepts = |y: &ChainPath, ratio: f32| u_accept < probability(y, ratio);
        let ratio = match kind {
            mutation::BIDIRECTIONAL => {
                let change = Change::choose(x.edges(), self.limits, sampler);
                if !bidirectional::propose(tracer, x, &change, y, bsdf, sampler) {
                    return (0.0, false);
                }
                let back = change.reverse();
                let density = change.density(tracer, y, x.edges(), self.limits);
                if !(density > 0.0) {
                    return (0.0, false);
                }
                back.density(tracer, x, y.edges(), self.limits) / density
            }
            mutation::CAUSTIC => match light_chain(tracer, x) {
                Some(moved) => propose_from_light(tracer, x, moved, y, bsdf, sampler),
                None => 0.0,
            },
            mutation::MANIFOLD | mutation::HALF_VECTOR => {
                let settings = &self.half_vectors;
                let verdict = if kind == mutation::MANIFOLD {
                    manifold_perturbation::propose(
                        tracer, x, y, settings, chains, bsdf, sampler, walks, accepts,
                    )
                } else {
                    half_vector_mutation::propose(
                        tracer, x, y, settings, chains, bsdf, sampler, walks, accepts,
                    )
                };
                let accepted = if verdict.is_accepted { 1.0 } else { 0.0 };
                return (accepted, verdict.is_lit);
            }
            _ => propose_from_sensor(tracer, x, y, bsdf, sampler),
        };
        let acceptance = probability(y, ratio);
        (acceptance, acceptance > 0.0)
    }

    /// Probability of accepting `y` after `x` for a ratio of their contributions and of the densities of a mutation of `kind`.
    fn acceptance(
        &self,
        x: &ChainPath,
        y: &ChainPath,
        kind: usize,
        allowed: &[f32; mutation::COUNT],
        ratio: f32,
    ) -> f32 {
        if !(ratio > 0.0 && is_countable(y) && self.is_own(y)) {
            return 0.0;
        }
        let ratio = ratio * self.importance.at(y.film) / self.importance.at(x.film);
        let of_y = self.allowed(y);
        let share = |weights: &[f32]| weights[kind] / weights.iter().sum::<f32>();
        let acceptance = ratio * share(&of_y) / share(allowed);
        // Also where densities are too small for a float.
        if acceptance > 0.0 {
            acceptance.min(1.0)
        } else {
            0.0
        }
    }

    /// Goes on with a smaller radius.
    fn sharpen(&self, chain: &mut VeachChain, b: f32, add: &mut impl FnMut(Splat)) {
        self.finish(chain, b, add);
        let blurring = self.blurring(chain.step);
        for path in &mut chain.paths {
            path.blurring = blurring;
        }
        let path = &mut chain.paths[chain.current];
        if path.is_blurred() && chain.weight > 0.0 {
            let before = path.luminance();
            let mut bsdf = Bsdf::BLACK;
            let is_lit = self.tracer.evaluate(path, &mut bsdf) && is_countable(path);
            chain.weight *= if is_lit {
                path.luminance() / before
            } else {
                0.0
            };
        }
    }
}

impl<T: Traverse + Sync> ChainAlgorithm for VeachChains<'_, T> {
    type Chain = VeachChain;

    fn candidate_weights(&self, candidate: u32, add: &mut impl FnMut(f32)) {
        self.candidate(candidate, |_, weight| add(weight));
    }

    fn candidate_luminances(&self, candidate: u32, add: &mut impl FnMut(Vec2, f32)) {
        self.candidate(candidate, |path, weight| {
            if weight > 0.0 {
                add(path.film, weight / self.importance.at(path.film));
            }
        });
    }

    fn start(&self, candidate: u32, member: u32, number: u32) -> VeachChain {
        let mut chain = VeachChain {
            paths: [ChainPath::empty(), ChainPath::empty()],
            current: 0,
            pending: 0.0,
            weight: 1.0,
            number,
            step: 0,
            last: StepRecord::default(),
            half_vectors: ChainPair::EMPTY,
            counts: Default::default(),
        };
        let mut index = 0;
        self.candidate(candidate, |path, _| {
            if index == member {
                chain.paths[0].clone_from(path);
            }
            index += 1;
        });
        chain.paths[1].blurring = chain.paths[0].blurring;
        chain
    }

    fn step(&self, chain: &mut VeachChain, b: f32, add: &mut impl FnMut(Splat)) {
        if self.annealing.changes_at(chain.step) {
            self.sharpen(chain, b, add);
        }
        chain.step += 1;
        if !(chain.weight > 0.0) {
            chain.last = StepRecord {
                film: chain.current().film,
                ..StepRecord::default()
            };
            return;
        }
        let seed = mix(self.seed ^ stream::CHAIN).wrapping_add(self.group);
        let mut sampler = FreshSamples::new(seed, chain.number, chain.step);
        let mut bsdf = Bsdf::BLACK;
        let allowed = self.allowed(chain.current());
        let (u, u_accept) = (sampler.next_1d(), sampler.next_1d());
        let mut left = u * allowed.iter().sum::<f32>();
        let mut kind = 0;
        while kind + 1 < mutation::COUNT && (left >= allowed[kind] || allowed[kind] == 0.0) {
            left -= allowed[kind];
            kind += 1;
        }
        if !(allowed[kind] > 0.0) {
            // No mutation is allowed here, or rounding left none.
            chain.last = StepRecord {
                film: chain.current().film,
                ..StepRecord::default()
            };
            chain.pending += chain.weight;
            return;
        }
        let before = chain.counts[kind].walks;
        chain.last.film = chain.current().film;
        let (acceptance, is_lit) =
            self.propose(kind, &allowed, chain, u_accept, &mut sampler, &mut bsdf);
        let walks = &mut chain.counts[kind].walks;
        let is_jump = walks.jumps > before.jumps;
        chain.last = StepRecord {
            acceptance,
            walks: (walks.walks - before.walks) as u32,
            iterations: (walks.iterations - before.iterations) as u32,
            is_jump,
            ..chain.last
        };
        walks.accepted_jumps += u64::from(is_jump && u_accept < acceptance);
        chain.pending += (1.0 - acceptance) * chain.weight;
        let of_proposed = acceptance * chain.weight;
        let counts = &mut chain.counts[kind];
        counts.proposed += 1;
        counts.lit += u64::from(is_lit);
        if u_accept < acceptance {
            counts.accepted += 1;
            self.finish(chain, b, add);
            chain.current = 1 - chain.current;
            chain.half_vectors.accept();
            chain.pending = of_proposed;
        } else if acceptance > 0.0 {
            self.add_path(&chain.paths[1 - chain.current], of_proposed * b, add);
        }
    }

    fn finish(&self, chain: &mut VeachChain, b: f32, add: &mut impl FnMut(Splat)) {
        if chain.pending > 0.0 {
            self.add_path(chain.current(), chain.pending * b, add);
            chain.pending = 0.0;
        }
    }

    fn mutations(&self) -> &'static [&'static str] {
        &[
            "bidirectional",
            "lens",
            "caustic",
            "multi-chain",
            "manifold",
            "half-vector",
        ]
    }

    fn observe(chain: &VeachChain) -> Option<Observation> {
        let path = chain.current();
        Some(Observation {
            edges: path.edges() as u32,
            emitter: path.emitter,
            film: path.film,
            luminance: path.luminance(),
        })
    }

    fn last_step(chain: &VeachChain) -> Option<StepRecord> {
        Some(chain.last)
    }

    fn counts(chain: &VeachChain) -> &[MutationCounts] {
        &chain.counts
    }
}
