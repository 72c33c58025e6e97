//! A chain of whole paths, and the group that it belongs to.

use super::balance::Probe;
use super::bidirectional::{self, Change};
use super::candidate;
use super::perturbation::{caustic_start, propose_from_light, propose_from_sensor, sensor_chain};
use super::{ChainPath, MAX_VERTICES};
use crate::bsdf::Bsdf;
use crate::path::PathExpressions;
use crate::path::remainder::Remainder;
use crate::path::tracer::Tracer;
use crate::sampler::{FreshSamples, Sampler, mix};
use crate::scene::{SceneView, Traverse};
use crate::transport::markov::algorithm::{
    ChainAlgorithm, MutationCounts, Observation, StepRecord,
};
use crate::transport::markov::half_vector::path_chain::ChainPair;
use crate::transport::markov::half_vector::{
    HalfVectorSettings, half_vector_mutation, manifold_perturbation,
};
use crate::transport::markov::state::Splat;
use crate::transport::settings::IntegratorSettings;

/// Streams of a group, told apart by what its seed is mixed with.
mod stream {
    pub const CANDIDATE_SENSOR: u32 = 0x428a_2f98;
    pub const CANDIDATE_LIGHT: u32 = 0x7137_4491;
    pub const CHAIN: u32 = 0xb5c0_fbcf;
}

/// Kinds of mutations.
mod mutation {
    pub const BIDIRECTIONAL: usize = 0;
    pub const LENS: usize = 1;
    pub const CAUSTIC: usize = 2;
    pub const MULTI_CHAIN: usize = 3;
    pub const MANIFOLD: usize = 4;
    pub const HALF_VECTOR: usize = 5;
    pub const COUNT: usize = 6;
}

/// The chains of a group.
pub struct VeachChains<'a, T: Traverse> {
    tracer: Tracer<'a, T>,
    /// Fewest and most edges of a path.
    limits: [usize; 2],
    /// Weights in the choice of a mutation.
    weights: [f32; mutation::COUNT],
    half_vectors: HalfVectorSettings,
    seed: u32,
    group: u32,
    /// What the image is divided by.
    expressions: Option<PathExpressions<'a>>,
}

/// A chain.
pub struct VeachChain {
    /// The current and the proposed one, in this order or the other.
    paths: [ChainPath; 2],
    /// Which is the current one.
    current: usize,
    /// Steps that the current path has yet to count for.
    pending: f32,
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

impl<'a, T: Traverse + Sync> VeachChains<'a, T> {
    /// Those of `group`, over paths of at least `min_edges` edges.
    pub fn new(
        view: &'a SceneView<'a, T>,
        settings: &IntegratorSettings,
        min_edges: u32,
        seed: u32,
        group: u32,
    ) -> Self {
        let rules = settings.rules;
        let own = &settings.chains;
        let hidden = if rules.hide_emitters != 0 { 2 } else { 1 };
        VeachChains {
            tracer: Tracer {
                view,
                rules,
                beside: None,
            },
            limits: [
                min_edges.max(hidden) as usize,
                (rules.max_depth as usize).min(MAX_VERTICES - 1),
            ],
            weights: [
                own.bidirectional_weight,
                own.lens_weight,
                own.caustic_weight,
                own.multi_chain_weight,
                own.manifold_weight,
                own.half_vector_weight,
            ],
            half_vectors: HalfVectorSettings::new(own),
            seed,
            group,
            expressions: None,
        }
    }

    /// Beside path tracing, which keeps part of what it finds.
    #[must_use]
    pub fn beside(mut self, remainder: Option<Remainder>) -> Self {
        self.tracer.beside = remainder;
        self
    }

    /// Hands on what the choice of a remainder needs to know of the paths of a candidate.
    pub fn probe(&self, candidate: u32, mut add: impl FnMut(Probe)) {
        let tables = &self.tracer.view.tables;
        self.candidate(candidate, |path, weight| {
            if weight > 0.0 && weight < f32::MAX {
                add(Probe {
                    weight,
                    luminance: path.luminance(),
                    pdf: [0, 1].map(|s| path.strategy_pdf(tables, s, false)),
                    edges: path.edges() as u32,
                });
            }
        });
    }

    /// With an image for each path expression beside the whole. Where nothing counts but the paths of the first, those are the
    /// image, and the others follow.
    #[must_use]
    pub fn divided(mut self, expressions: Option<PathExpressions<'a>>) -> Self {
        self.expressions = expressions;
        self
    }

    /// Adds F / I of a path times `factor` to the image and to its parts.
    fn add_path(&self, path: &ChainPath, factor: f32, add: &mut impl FnMut(Splat)) {
        let value = path.value * (factor / path.luminance());
        let whole = Splat {
            film: path.film,
            value,
            image: 0,
        };
        let Some(expressions) = &self.expressions else {
            add(whole);
            return;
        };
        let tables = &self.tracer.view.tables;
        let mut bsdf = Bsdf::BLACK;
        let shares = path.shares(tables, expressions, &mut bsdf);
        if expressions.only == 0 {
            add(whole);
        }
        if shares.is_none() {
            return;
        }
        for part in 0..expressions.count {
            let value = value * shares.of(part as usize);
            if value.max_element() > 0.0 {
                let image = part + 1 - expressions.only;
                add(Splat {
                    value,
                    image,
                    ..whole
                });
            }
        }
    }

    /// All paths of a candidate that are long enough, with their weights.
    fn candidate(&self, candidate: u32, mut add: impl FnMut(&ChainPath, f32)) {
        let stream = |which: u32| FreshSamples::new(mix(self.seed ^ which), self.group, candidate);
        let mut sensor = stream(stream::CANDIDATE_SENSOR);
        let mut light = stream(stream::CANDIDATE_LIGHT);
        candidate::paths(&self.tracer, &mut sensor, &mut light, |path, weight| {
            let is_long = path.edges() >= self.limits[0];
            add(path, if is_long { weight } else { 0.0 });
        });
    }

    /// Weights of the mutations that a path allows.
    fn allowed(&self, x: &ChainPath) -> [f32; mutation::COUNT] {
        let mut weights = self.weights;
        let has_turns = sensor_chain(x).turns > 0;
        if has_turns {
            weights[mutation::LENS] = 0.0;
        } else {
            weights[mutation::MULTI_CHAIN] = 0.0;
        }
        if caustic_start(&self.tracer, x).is_none() {
            weights[mutation::CAUSTIC] = 0.0;
        }
        if x.edges() < 2 {
            weights[mutation::MANIFOLD] = 0.0;
            weights[mutation::HALF_VECTOR] = 0.0;
        }
        weights
    }

    /// Proposes a mutation of `kind` and returns the probability of its acceptance.
    fn propose(
        &self,
        kind: usize,
        allowed: &[f32; mutation::COUNT],
        chain: &mut VeachChain,
        sampler: &mut FreshSamples,
        bsdf: &mut Bsdf,
    ) -> f32 {
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
        let ratio = match kind {
            mutation::BIDIRECTIONAL => {
                let change = Change::choose(x.edges(), self.limits, sampler);
                if !bidirectional::propose(tracer, x, &change, y, bsdf, sampler) {
                    return 0.0;
                }
                let back = change.reverse();
                let density = change.density(tracer, y, x.edges(), self.limits);
                if !(density > 0.0) {
                    return 0.0;
                }
                back.density(tracer, x, y.edges(), self.limits) / density
            }
            mutation::CAUSTIC => match caustic_start(tracer, x) {
                Some(start) => propose_from_light(tracer, x, start, y, bsdf, sampler),
                None => 0.0,
            },
            mutation::MANIFOLD => {
                let settings = &self.half_vectors;
                manifold_perturbation::propose(tracer, x, y, settings, chains, bsdf, sampler, walks)
            }
            mutation::HALF_VECTOR => {
                let settings = &self.half_vectors;
                half_vector_mutation::propose(tracer, x, y, settings, chains, bsdf, sampler, walks)
            }
            _ => propose_from_sensor(tracer, x, y, bsdf, sampler),
        };
        // A path whose light is too small or too large for a float has no reciprocal to count by.
        let light = y.luminance();
        if !(ratio > 0.0 && light >= f32::MIN_POSITIVE && light < f32::INFINITY) {
            return 0.0;
        }
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
}

impl<T: Traverse + Sync> ChainAlgorithm for VeachChains<'_, T> {
    type Chain = VeachChain;

    fn weigh(&self, candidate: u32, add: &mut impl FnMut(f32)) {
        self.candidate(candidate, |_, weight| add(weight));
    }

    fn start(&self, candidate: u32, member: u32, number: u32) -> VeachChain {
        let mut chain = VeachChain {
            paths: [ChainPath::empty(), ChainPath::empty()],
            current: 0,
            pending: 0.0,
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
        chain
    }

    fn step(&self, chain: &mut VeachChain, b: f32, add: &mut impl FnMut(Splat)) {
        chain.step += 1;
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
            chain.pending += 1.0;
            return;
        }
        let before = chain.counts[kind].walks;
        chain.last.film = chain.current().film;
        let acceptance = self.propose(kind, &allowed, chain, &mut sampler, &mut bsdf);
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
        chain.pending += 1.0 - acceptance;
        let counts = &mut chain.counts[kind];
        counts.proposed += 1;
        counts.lit += u64::from(acceptance > 0.0);
        if u_accept < acceptance {
            counts.accepted += 1;
            self.finish(chain, b, add);
            chain.current = 1 - chain.current;
            chain.half_vectors.accept();
            chain.pending = acceptance;
        } else if acceptance > 0.0 {
            self.add_path(&chain.paths[1 - chain.current], acceptance * b, add);
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
        })
    }

    fn last_step(chain: &VeachChain) -> Option<StepRecord> {
        Some(chain.last)
    }

    fn counts(chain: &VeachChain) -> &[MutationCounts] {
        &chain.counts
    }
}
