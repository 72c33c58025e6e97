//! Chains of primary samples (Kelemen et al. 2002; `pssmlt`, and `mmlt` after Hachisuka, Kaplanyan and Dachsbacher 2014).
//!
//! The density of primary samples is one, so I and F are those of the path over its density, T is symmetric for small steps,
//! and T(x -> y) = 1 for large ones. With the probability p of a large step, its proposals are independent samples of the image
//! too. Kelemen combines both by the balance heuristic, with chain states counting as samples of density I / b; here
//! the weights use a constant c near b that is the same in all groups and known before any of them,
//!
//! ```text
//! state:             b F / I  *  I / (I + p c)    =  b F / (I + p c)
//! large proposal:      F / p  *  p c / (I + p c)  =  c F / (I + p c)
//! ```
//!
//! because then both parts are unbiased for each group, with its own estimate of b in the first. With c = b it is the method of
//! the paper. Where a pixel is dark compared with b, its light comes from large steps and not from rare visits.
//!
//! States of a target that is mollified less and less count with the weight W of [`super::annealing`] besides.

use super::algorithm::{ChainAlgorithm, MutationCounts, Observation};
use super::annealing::Annealing;
use super::primary_space::PrimarySpace;
use super::state::{Splat, State};
use crate::math::luminance;
use crate::sampler::{FreshSamples, PrimarySamples, mix};
use crate::scene::Traverse;
use glam::Vec2;

/// Streams of a group, distinguished by what its seed is mixed with.
mod stream {
    pub const CANDIDATE_LIGHT: u32 = 0x510e_527f;
    pub const CANDIDATE_CAMERA: u32 = 0x9b05_688c;
    pub const LIGHT: u32 = 0x1f83_d9ab;
    pub const CAMERA: u32 = 0x5be0_cd19;
    pub const CHOICE: u32 = 0xcbbb_9d5d;
}

/// Group number of the candidates from which the constant of the weights is estimated: no group of an image has it.
const PILOT: u32 = u32::MAX;

/// Candidates of that estimate.
const PILOT_CANDIDATES: u32 = 4096;

const SMALL: usize = 0;
const LARGE: usize = 1;

/// The chains of a group.
pub struct PrimaryChains<'a, T: Traverse> {
    space: PrimarySpace<'a, T>,
    /// Probability of a large step.
    p_large: f32,
    /// c of the header.
    constant: f32,
    annealing: Annealing,
    seed: u32,
    group: u32,
}

/// A chain.
pub struct PrimaryChain {
    light: PrimarySamples,
    camera: PrimarySamples,
    current: State,
    proposed: State,
    /// What the current state has yet to add, in units of b F / (I + p c).
    pending: f32,
    /// W of [`super::annealing`].
    weight: f32,
    number: u32,
    step: u32,
    counts: [MutationCounts; 2],
}

impl<'a, T: Traverse + Sync> PrimaryChains<'a, T> {
    /// Those of `group`, of a target that is not regularised.
    pub fn new(space: PrimarySpace<'a, T>, p_large: f32, seed: u32, group: u32) -> Self {
        PrimaryChains::with_constant(space, p_large, Annealing::NONE, seed).of_group(group)
    }

    /// With the constant of the weights that the target of `annealing` has; only those [`PrimaryChains::of_group`] are to run.
    pub fn with_constant(
        space: PrimarySpace<'a, T>,
        p_large: f32,
        annealing: Annealing,
        seed: u32,
    ) -> Self {
        let pilot = PrimaryChains {
            space,
            p_large,
            constant: 0.0,
            annealing,
            seed,
            group: PILOT,
        };
        let mut sum = 0.0;
        for candidate in 0..PILOT_CANDIDATES {
            pilot.candidate_weights(candidate, &mut |weight| sum += f64::from(weight));
        }
        PrimaryChains {
            constant: (sum / f64::from(PILOT_CANDIDATES)) as f32,
            ..pilot
        }
    }

    /// The same with the numbers of another group.
    pub fn of_group(&self, group: u32) -> Self {
        PrimaryChains {
            space: self.space,
            p_large: self.p_large,
            constant: self.constant,
            annealing: self.annealing,
            seed: self.seed,
            group,
        }
    }

    /// The same with another target.
    #[must_use]
    pub fn annealed(mut self, annealing: Annealing) -> Self {
        self.annealing = annealing;
        self
    }

    #[inline]
    fn stream(&self, which: u32) -> u32 {
        mix(self.seed ^ which).wrapping_add(self.group)
    }

    fn candidate(&self, candidate: u32) -> [FreshSamples; 2] {
        [stream::CANDIDATE_LIGHT, stream::CANDIDATE_CAMERA]
            .map(|which| FreshSamples::new(mix(self.seed ^ which), self.group, candidate))
    }

    #[inline]
    fn factor(&self, state: &State) -> f32 {
        1.0 / (state.target() + self.p_large * self.constant)
    }
}

impl<T: Traverse + Sync> PrimaryChains<'_, T> {
    /// Goes on with a smaller radius.
    fn sharpen(&self, chain: &mut PrimaryChain, b: f32, add: &mut impl FnMut(Splat)) {
        self.finish(chain, b, add);
        chain.light.repeat();
        chain.camera.repeat();
        let before = chain.current.target();
        let regularization = self.annealing.at(chain.step);
        self.space.evaluate(
            &mut chain.light,
            &mut chain.camera,
            &regularization,
            &mut chain.current,
        );
        let ratio = chain.current.target() / before;
        chain.weight *= if ratio > 0.0 { ratio } else { 0.0 };
    }
}

impl<T: Traverse + Sync> ChainAlgorithm for PrimaryChains<'_, T> {
    type Chain = PrimaryChain;

    fn candidate_weights(&self, candidate: u32, add: &mut impl FnMut(f32)) {
        let [mut light, mut camera] = self.candidate(candidate);
        let mut state = State::default();
        let regularization = self.annealing.at(0);
        self.space
            .evaluate(&mut light, &mut camera, &regularization, &mut state);
        add(state.target());
    }

    fn candidate_luminances(&self, candidate: u32, add: &mut impl FnMut(Vec2, f32)) {
        let [mut light, mut camera] = self.candidate(candidate);
        let mut state = State::default();
        let regularization = self.annealing.at(0);
        self.space
            .evaluate(&mut light, &mut camera, &regularization, &mut state);
        for splat in state.splats().iter().filter(|splat| splat.image == 0) {
            add(splat.film, luminance(splat.value));
        }
    }

    fn start(&self, candidate: u32, _member: u32, number: u32) -> PrimaryChain {
        let [light, camera] = self.candidate(candidate);
        let mut chain = PrimaryChain {
            light: PrimarySamples::new(light, self.stream(stream::LIGHT), number),
            camera: PrimarySamples::new(camera, self.stream(stream::CAMERA), number),
            current: State::default(),
            proposed: State::default(),
            pending: 0.0,
            weight: 1.0,
            number,
            step: 0,
            counts: Default::default(),
        };
        let [mut light, mut camera] = [light, camera];
        let regularization = self.annealing.at(0);
        self.space
            .evaluate(&mut light, &mut camera, &regularization, &mut chain.current);
        chain
    }

    fn step(&self, chain: &mut PrimaryChain, b: f32, add: &mut impl FnMut(Splat)) {
        if self.annealing.changes_at(chain.step) {
            self.sharpen(chain, b, add);
        }
        let regularization = self.annealing.at(chain.step);
        chain.step += 1;
        let choice = FreshSamples::new(self.stream(stream::CHOICE), chain.number, chain.step);
        let is_large = choice.number(0) < self.p_large;
        chain.light.propose(is_large);
        chain.camera.propose(is_large);
        self.space.evaluate(
            &mut chain.light,
            &mut chain.camera,
            &regularization,
            &mut chain.proposed,
        );
        let (i_x, i_y) = (chain.current.target(), chain.proposed.target());
        // A chain starts where there is light, and goes nowhere else until its state loses all of it.
        let acceptance = if i_y < i_x { i_y / i_x } else { 1.0 };
        let step_weight = b * chain.weight;
        let mut of_proposed = acceptance * step_weight;
        if is_large {
            of_proposed += self.constant;
        }
        chain.pending += (1.0 - acceptance) * step_weight;
        let counts = &mut chain.counts[if is_large { LARGE } else { SMALL }];
        counts.proposed += 1;
        counts.lit += u64::from(i_y > 0.0);
        if choice.number(1) < acceptance {
            counts.accepted += 1;
            self.finish(chain, b, add);
            chain.pending = of_proposed;
            core::mem::swap(&mut chain.current, &mut chain.proposed);
            chain.light.accept();
            chain.camera.accept();
        } else if of_proposed > 0.0 && i_y > 0.0 {
            chain
                .proposed
                .emit(of_proposed * self.factor(&chain.proposed), add);
        }
    }

    fn finish(&self, chain: &mut PrimaryChain, _b: f32, add: &mut impl FnMut(Splat)) {
        if chain.pending > 0.0 {
            chain
                .current
                .emit(chain.pending * self.factor(&chain.current), add);
            chain.pending = 0.0;
        }
    }

    fn mutations(&self) -> &'static [&'static str] {
        &["small step", "large step"]
    }

    fn observe(chain: &PrimaryChain) -> Option<Observation> {
        let splats = chain.current.splats();
        let brightest = splats.iter().max_by(|a, b| {
            let [a, b] = [a, b].map(|splat| luminance(splat.value));
            a.total_cmp(&b)
        })?;
        Some(Observation {
            edges: splats.len() as u32,
            film: brightest.film,
            luminance: splats.iter().map(|splat| luminance(splat.value)).sum(),
            ..Observation::default()
        })
    }

    fn counts(chain: &PrimaryChain) -> &[MutationCounts] {
        &chain.counts
    }
}
