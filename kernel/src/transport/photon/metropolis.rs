//! Metropolis photon tracing: light walks that leave photons where camera walks look (Hachisuka and Jensen 2011, "Robust adaptive
//! photon tracing using photon path visibility").
//!
//! The primary samples u of a light walk have the target V(u), one if the walk leaves a photon that some camera walk of the pass would
//! gather, and zero if not. Two replicas are exchanged: one draws u anew in each step, so that the share
//!
//! ```text
//! b = integral of V du
//! ```
//!
//! of seen walks is the mean of what it finds; a walk of it that is seen becomes the state of the other. Otherwise that one makes a small step,
//! which it takes if the walk is seen. The state's photons count in every step, with the flux of V's support,
//!
//! ```text
//! Phi = b E_V[Phi(u)],
//! ```
//!
//! so that a pass of n steps is one of n / b light walks. The width of small steps adapts to an acceptance of 0.234
//! (Atchade and Rosenthal 2005), by the power 1/i of the step's number: it settles.
//!
//! The chains of a pass begin with their first seen walk, which has the density that they keep. Hosts only, as all chains.

use super::cache::{Photon, PhotonCache};
use super::estimate::{LEAST_COSINE, for_photons_within};
use super::tracing::{LightBounce, PhotonStore, PhotonTracer, is_found_by_photons_alone};
use crate::math::{float, vec3};
use crate::path::rules::step;
use crate::path::{ShadingPoint, Walk};
use crate::sampler::{FreshSamples, PrimarySamples, Sampler, mix};
use crate::scene::{SceneView, Traverse};
use glam::Vec3;

/// Acceptance to which steps adapt.
const ACCEPTANCE: f32 = 0.234;

/// Steps after which the gain of the adaptation falls below one.
const GAIN: f32 = 16.0;

/// Smallest and largest width of small steps, over that of Metropolis light transport.
const WIDTHS: [f32; 2] = [1.0 / 256.0, 16.0];

/// Distinguishes the replicas.
const UNIFORM: u32 = 0x2b99_2ddf;

/// The photons of walks.
pub trait PhotonPath: PhotonStore {
    /// Forgets all.
    fn clear(&mut self);

    /// Whether some photon is one that `is_seen`.
    fn any(&self, is_seen: impl FnMut(Vec3, &Photon) -> bool) -> bool;

    /// Adds all to another list, with `count` times their flux.
    fn append_to(&self, count: f32, other: &mut Self);
}

/// Where the camera walks of a pass gather photons: each is a photon whose normal is that of the surface, and which has been
/// made by [`gather_point`].
#[derive(Clone, Copy)]
pub struct GatherPoints<'a> {
    /// The points.
    pub points: PhotonCache<'a>,
    /// Radius within which photons are gathered.
    pub radius: f32,
}

/// The record of a point where a camera walk gathers, of those photons alone that nothing else finds if it is told so.
pub fn gather_point(normal: Vec3, only_unfound: bool) -> Photon {
    Photon {
        direction: [0.0; 3],
        throughput: [0.0; 3],
        normal: normal.to_array(),
        d_vcm: 0.0,
        d_vc: 0.0,
        depth: u32::from(only_unfound),
        record: 0,
    }
}

impl GatherPoints<'_> {
    /// Whether some point gathers a photon.
    fn is_gathered(&self, position: Vec3, photon: &Photon) -> bool {
        let mut is_seen = false;
        for_photons_within(&self.points, position, self.radius, |index, _| {
            let point = &self.points.photons[index as usize];
            let cosine = float::abs(vec3(point.normal).dot(vec3(photon.normal)));
            is_seen |=
                cosine >= LEAST_COSINE && (point.depth == 0 || is_found_by_photons_alone(photon));
        });
        is_seen
    }
}

/// What a pass needs.
pub struct VisiblePhotons<'a, T: Traverse> {
    /// The scene.
    pub view: &'a SceneView<'a, T>,
    /// What leaves photons.
    pub tracer: PhotonTracer<'a>,
    /// Who looks at them.
    pub seen_by: GatherPoints<'a>,
    /// Seed of the pass.
    pub seed: u32,
    /// Its index.
    pub pass: u32,
}

/// What a chain has found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ChainCounts {
    /// Walks drawn anew.
    pub uniform: u32,
    /// Those that were seen.
    pub uniform_seen: u32,
    /// Steps that count a state.
    pub states: u32,
    /// Small steps.
    pub proposed: u32,
    /// Small steps that were taken.
    pub accepted: u32,
}

impl ChainCounts {
    /// Adds those of another chain.
    pub fn merge(&mut self, other: &ChainCounts) {
        self.uniform += other.uniform;
        self.uniform_seen += other.uniform_seen;
        self.states += other.states;
        self.proposed += other.proposed;
        self.accepted += other.accepted;
    }

    /// The light walks for which the photons of all states stand: n / b.
    pub fn emitted(&self) -> f32 {
        let share = self.uniform_seen as f32 / self.uniform.max(1) as f32;
        if share > 0.0 {
            self.states as f32 / share
        } else {
            self.uniform.max(1) as f32
        }
    }
}

impl<T: Traverse> VisiblePhotons<'_, T> {
    /// `steps` of chain `number`: adds the photons of its states to `out`; `lists` is storage for two walks.
    pub fn run<P: PhotonPath>(
        &self,
        number: u32,
        steps: u32,
        lists: &mut [P; 2],
        out: &mut P,
    ) -> ChainCounts {
        let mut counts = ChainCounts::default();
        let seed = mix(self.seed).wrapping_add(self.pass);
        let fresh_seed = mix(self.seed ^ UNIFORM).wrapping_add(self.pass);
        let mut state: Option<PrimarySamples> = None;
        let mut site = ShadingPoint::NONE;
        let mut width = 1.0;
        // Steps for which the photons of the state have yet to count.
        let mut pending = 0.0;
        for i in 0..steps {
            let [current, proposed] = lists;
            let start = FreshSamples::new(fresh_seed, number, i);
            let mut fresh = start;
            counts.uniform += 1;
            let mut is_taken = self.trace(&mut fresh, &mut site, proposed);
            if is_taken {
                counts.uniform_seen += 1;
                // A chain is a new one wherever a replica joins it.
                state = Some(PrimarySamples::new(start, mix(seed ^ i), number));
            } else if let Some(samples) = &mut state {
                samples.set_width(width);
                samples.propose(false);
                counts.proposed += 1;
                is_taken = self.trace(samples, &mut site, proposed);
                if is_taken {
                    counts.accepted += 1;
                    samples.accept();
                }
                let reached = if is_taken { 1.0 } else { 0.0 };
                let gain = (GAIN / counts.proposed as f32).min(1.0);
                width = (width * float::exp(gain * (reached - ACCEPTANCE)))
                    .max(WIDTHS[0])
                    .min(WIDTHS[1]);
            }
            if is_taken {
                if pending > 0.0 {
                    current.append_to(pending, out);
                }
                lists.swap(0, 1);
                pending = 0.0;
            }
            if state.is_some() {
                pending += 1.0;
                counts.states += 1;
            }
        }
        if pending > 0.0 {
            lists[0].append_to(pending, out);
        }
        counts
    }

    /// Traces a light walk; returns whether it is seen.
    fn trace<S: Sampler, P: PhotonPath>(
        &self,
        sampler: &mut S,
        site: &mut ShadingPoint,
        list: &mut P,
    ) -> bool {
        list.clear();
        let start = self.tracer.emit(sampler);
        if !start.is_some() {
            return false;
        }
        let mut walk = Walk::from_emitter(&start);
        let mut next = step::TRACE;
        while next == step::TRACE {
            sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
            let hit = self.view.traverse.closest_hit(&walk.subpath.ray);
            next = self.tracer.light_bounce(&mut LightBounce {
                walk: &mut walk,
                sampler,
                hit: &hit,
                site,
                store: list,
            });
        }
        list.any(|position, photon| self.seen_by.is_gathered(position, photon))
    }
}
