//! A group of chains of full paths: what it looks for, and where its chains start.

use super::balance::CandidatePath;
use super::candidate;
use super::{ChainPath, MAX_VERTICES};
use crate::bsdf::Bsdf;
use crate::path::PathExpressions;
use crate::path::full_path::Blurring;
use crate::path::remainder::Remainder;
use crate::path::retarget_states::Edits;
use crate::path::tracer::Tracer;
use crate::sampler::{FreshSamples, mix};
use crate::scene::{SceneView, Traverse};
use crate::transport::markov::annealing::Annealing;
use crate::transport::markov::half_vector::HalfVectorSettings;
use crate::transport::markov::importance::Importance;
use crate::transport::markov::state::Splat;
use crate::transport::settings::IntegratorSettings;

/// Streams of a group, distinguished by what its seed is mixed with.
pub(super) mod stream {
    pub const CANDIDATE_SENSOR: u32 = 0x428a_2f98;
    pub const CANDIDATE_LIGHT: u32 = 0x7137_4491;
    pub const CHAIN: u32 = 0xb5c0_fbcf;
}

/// Kinds of mutations.
pub(super) mod mutation {
    pub const BIDIRECTIONAL: usize = 0;
    pub const LENS: usize = 1;
    pub const CAUSTIC: usize = 2;
    pub const MULTI_CHAIN: usize = 3;
    pub const MANIFOLD: usize = 4;
    pub const HALF_VECTOR: usize = 5;
    pub const COUNT: usize = 6;
}

/// Fewest edges of a path with a blurred vertex.
const LEAST_BLURRED_EDGES: usize = 2;

/// The chains of a group.
pub struct VeachChains<'a, T: Traverse> {
    pub(super) tracer: Tracer<'a, T>,
    /// Fewest edges of a path of which no vertex is blurred.
    min_edges: usize,
    /// Fewest and most edges of a path.
    pub(super) limits: [usize; 2],
    /// Weights in the choice of a mutation.
    pub(super) weights: [f32; mutation::COUNT],
    pub(super) half_vectors: HalfVectorSettings,
    pub(super) annealing: Annealing,
    pub(super) importance: Importance<'a>,
    pub(super) seed: u32,
    pub(super) group: u32,
    /// What the image is divided by.
    expressions: Option<PathExpressions<'a>>,
}

/// Whether the light of a path is not too small or too large for a float to have a reciprocal to count by.
pub(super) fn is_countable(path: &ChainPath) -> bool {
    let light = path.luminance();
    light >= f32::MIN_POSITIVE && light < f32::INFINITY
}

impl<'a, T: Traverse + Sync> VeachChains<'a, T> {
    /// Those of `group`, over paths of at least `min_edges` edges, and shorter ones that are mollified.
    pub fn new(
        view: &'a SceneView<'a, T>,
        settings: &IntegratorSettings,
        min_edges: u32,
        seed: u32,
        group: u32,
    ) -> Self {
        let rules = settings.rules;
        let parameters = &settings.chains;
        let hidden = if rules.hide_emitters != 0 { 2 } else { 1 };
        let min_edges = min_edges.max(hidden) as usize;
        VeachChains {
            tracer: Tracer {
                view,
                rules,
                remainder: None,
                edits: None,
            },
            min_edges,
            limits: [min_edges, (rules.max_depth as usize).min(MAX_VERTICES - 1)],
            weights: [
                parameters.bidirectional_weight,
                parameters.lens_weight,
                parameters.caustic_weight,
                parameters.multi_chain_weight,
                parameters.manifold_weight,
                parameters.half_vector_weight,
            ],
            half_vectors: HalfVectorSettings::new(parameters),
            annealing: Annealing::NONE,
            importance: Importance::EVEN,
            seed,
            group,
            expressions: None,
        }
    }

    /// Together with path tracing, which keeps part of what it finds.
    #[must_use]
    pub fn with_path_tracing(mut self, remainder: Option<Remainder>) -> Self {
        self.tracer.remainder = remainder;
        self
    }

    /// With edits of light transport. Neither is the target mollified then nor is path tracing beside it.
    #[must_use]
    pub fn edited(mut self, edits: Option<&'a Edits<'a>>) -> Self {
        self.tracer.edits = edits;
        self
    }

    /// With parts of the image that count more than others.
    #[must_use]
    pub fn with_importance(mut self, importance: Importance<'a>) -> Self {
        self.importance = importance;
        self
    }

    /// With a target that is mollified.
    #[must_use]
    pub fn annealed(mut self, annealing: Annealing) -> Self {
        self.annealing = annealing;
        if annealing.mollifies() {
            self.limits[0] = self.min_edges.min(LEAST_BLURRED_EDGES);
        }
        self
    }

    /// How the paths of a chain are blurred after so many steps.
    pub(super) fn blurring(&self, step: u32) -> Blurring {
        let regularization = self.annealing.at(step);
        Blurring {
            radius: regularization.radius,
            kernel: regularization.kernel,
        }
    }

    /// Whether a path is not left to others.
    pub(super) fn is_own(&self, path: &ChainPath) -> bool {
        path.edges() >= self.min_edges || path.is_blurred()
    }

    /// Passes on what the choice of a remainder needs to know of the paths of a candidate.
    pub fn probe(&self, candidate: u32, mut add: impl FnMut(CandidatePath)) {
        let tables = &self.tracer.view.tables;
        self.candidate(candidate, |path, weight| {
            if weight > 0.0 && weight < f32::MAX {
                add(CandidatePath {
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
    pub(super) fn add_path(&self, path: &ChainPath, factor: f32, add: &mut impl FnMut(Splat)) {
        // In this order a path of as little light as a float holds gives a finite value.
        let value = path.value / path.luminance() * (factor / self.importance.at(path.film));
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
        let shares = path.shares(tables, expressions, self.tracer.edits, &mut bsdf);
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
    pub(super) fn candidate(&self, candidate: u32, mut add: impl FnMut(&ChainPath, f32)) {
        let stream = |which: u32| FreshSamples::new(mix(self.seed ^ which), self.group, candidate);
        let mut sensor = stream(stream::CANDIDATE_SENSOR);
        let mut light = stream(stream::CANDIDATE_LIGHT);
        let (tracer, blurring) = (&self.tracer, self.blurring(0));
        candidate::paths(tracer, blurring, &mut sensor, &mut light, |path, weight| {
            let counts = self.is_own(path) && is_countable(path);
            let weight = if counts { weight } else { 0.0 };
            add(path, weight * self.importance.at(path.film));
        });
    }
}
