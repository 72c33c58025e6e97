//! What a driver of chains needs to know of an algorithm.

use super::state::Splat;
use glam::Vec2;

/// Counts of what became of walks on manifolds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WalkCounts {
    /// Walks, those back not counted.
    pub walks: u64,
    /// Walks that found a path.
    pub found: u64,
    /// Of those, the ones whose way back was looked at: of paths that would be accepted.
    pub tested: u64,
    /// Of those, the ones whose way back leads elsewhere.
    pub irreversible: u64,
    /// Iterations of all walks.
    pub iterations: u64,
    /// Iterations of the walks that found a path.
    pub iterations_of_found: u64,
    /// Jumps between sub-manifolds that led to a path.
    pub jumps: u64,
    /// Those that became the state.
    pub accepted_jumps: u64,
}

impl WalkCounts {
    fn merge(&mut self, other: &WalkCounts) {
        self.walks += other.walks;
        self.found += other.found;
        self.tested += other.tested;
        self.irreversible += other.irreversible;
        self.iterations += other.iterations;
        self.iterations_of_found += other.iterations_of_found;
        self.jumps += other.jumps;
        self.accepted_jumps += other.accepted_jumps;
    }
}

/// What became of one mutation, for maps of the image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepRecord {
    /// Film position of the state before, in pixels of the whole film.
    pub film: Vec2,
    /// Probability of its acceptance.
    pub acceptance: f32,
    /// Walks on manifolds.
    pub walks: u32,
    /// Their iterations.
    pub iterations: u32,
    /// Whether a jump led to a path.
    pub is_jump: bool,
}

/// What a state is, for tests of the distribution of states.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Edges of the path, or positions on the film.
    pub edges: u32,
    /// Its emitter.
    pub emitter: u32,
    /// Film position, in pixels of the whole film; of several the brightest.
    pub film: Vec2,
    /// Luminance of F.
    pub luminance: f32,
}

/// Counts of what became of proposals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MutationCounts {
    /// Proposals.
    pub proposed: u64,
    /// Proposals that carried any light.
    pub lit: u64,
    /// Proposals that became the state.
    pub accepted: u64,
    /// Walks on manifolds that they made.
    pub walks: WalkCounts,
}

impl MutationCounts {
    /// Adds those of another chain.
    pub fn merge(&mut self, other: &MutationCounts) {
        self.proposed += other.proposed;
        self.lit += other.lit;
        self.accepted += other.accepted;
        self.walks.merge(&other.walks);
    }
}

/// An algorithm of chains in one group: seed and group are part of it, so that everything is a function of the numbers given.
pub trait ChainAlgorithm: Sync {
    /// A chain's state.
    type Chain: Send + Sync;

    /// Passes on the weights I / p of the paths of a candidate, as many and in the same order each time.
    fn candidate_weights(&self, candidate: u32, add: &mut impl FnMut(f32));

    /// Passes on the film positions of the paths of a candidate, and the luminance of their weights F / p.
    fn candidate_luminances(&self, candidate: u32, add: &mut impl FnMut(Vec2, f32));

    /// Chain `number`, at path `member` of a candidate.
    fn start(&self, candidate: u32, member: u32, number: u32) -> Self::Chain;

    /// One mutation, for an integral `b` of I; `add` takes what it adds to the sum over all mutations.
    fn step(&self, chain: &mut Self::Chain, b: f32, add: &mut impl FnMut(Splat));

    /// What the state that the chain ends with has not added yet.
    fn finish(&self, chain: &mut Self::Chain, b: f32, add: &mut impl FnMut(Splat));

    /// Names of the mutations.
    fn mutations(&self) -> &'static [&'static str];

    /// Where the last mutation started, and what became of it; nothing if states have no single film position.
    fn last_step(_chain: &Self::Chain) -> Option<StepRecord> {
        None
    }

    /// What the current state is.
    fn observe(_chain: &Self::Chain) -> Option<Observation> {
        None
    }

    /// What became of each.
    fn counts(chain: &Self::Chain) -> &[MutationCounts];
}
