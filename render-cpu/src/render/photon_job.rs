//! The parts of a pass of photon mapping that one thread does: some light walks, and the camera walks of a tile.
//!
//! Photons depend on the seed, the pass and the light walk's number; pixels on the seed, the pass and the photons.

use super::bidirectional_job::{Shadows, TileSample, TileSamples};
use super::lockstep_walks::{LockstepWalks, RAYS};
use super::photon_cache::PhotonList;
use glam::Vec3;
use halflight_kernel::path::retarget_states::{EditStates, Edits};
use halflight_kernel::path::{
    Contribution, Interaction, PathExpressions, PathStates, ShadingPoint, Walk,
};
use halflight_kernel::regularize::settings::Regularization;
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::scene::{NONE, SceneView};
use halflight_kernel::transport::bidirectional::adaptive::photon_bounce;
use halflight_kernel::transport::photon::adaptive::{self, AdaptiveRadii};
use halflight_kernel::transport::photon::divided::divided_light_bounce;
use halflight_kernel::transport::photon::merging::PassPhotons;
use halflight_kernel::transport::photon::metropolis::gather_point;
use halflight_kernel::transport::photon::progressive::Progressive;
use halflight_kernel::transport::photon::statistics::PhotonPass;
use halflight_kernel::transport::photon::tracing::{LightBounce, PhotonStore, PhotonTracer};
use halflight_kernel::transport::{IntegratorSettings, camera_ray, retargeted};

/// Light walks that are traced together.
pub(super) const WALKS: u32 = RAYS as u32;

/// What a gather does with the vertex at which the walk of the sample with an index has arrived.
pub(super) type Find<'a> = dyn FnMut(usize, &Interaction<'_>) + 'a;

/// Radii within which the samples of a tile gather.
pub(super) enum Radii<'a> {
    /// One for all, that of the photons.
    Shared,
    /// One for each sample.
    Own(Vec<f32>),
    /// Those of each sample, whose statistics learn from the photons.
    Adaptive(Vec<AdaptiveRadii>),
    /// Nothing is gathered, but looked at where it would be.
    Found(&'a mut Find<'a>),
}

/// What a thread needs for its share of a pass.
pub(super) struct PhotonWorkspace {
    walks: LockstepWalks,
    weights: Vec<f32>,
    shadows: Shadows,
    site: Box<ShadingPoint>,
}

impl PhotonWorkspace {
    /// Room that grows with the first tiles.
    pub fn new() -> PhotonWorkspace {
        PhotonWorkspace {
            walks: LockstepWalks::new(),
            weights: Vec::new(),
            shadows: Shadows::new(),
            site: Box::new(ShadingPoint::NONE),
        }
    }

    /// The photons of light walks with the numbers of `samplers`, at most [`WALKS`].
    pub fn trace_photons<T: Traverse, S: LaneSampler>(
        &mut self,
        view: &SceneView<'_, T>,
        tracer: &PhotonTracer<'_>,
        expressions: Option<&PathExpressions<'_>>,
        edits: Option<&Edits<'_>>,
        samplers: &mut [S],
    ) -> PhotonList {
        let emitters = self.emit(tracer, samplers);
        let of = |emitter: &u32| expressions.map(|e| PathStates::at_emitter(e, *emitter));
        let mut states: Vec<_> = emitters.iter().filter_map(of).collect();
        let of = |emitter: &u32| edits.map(|e| EditStates::at_emitter(e, *emitter));
        let mut edited: Vec<_> = emitters.iter().filter_map(of).collect();
        self.follow(view, samplers, |i, bounce| match (expressions, edits) {
            (_, Some(edits)) => {
                retargeted::bounce::light_bounce(tracer, edits, &mut edited[i], bounce)
            }
            (None, None) => tracer.light_bounce(bounce),
            (Some(expressions), None) => {
                divided_light_bounce(tracer, expressions, &mut states[i], bounce)
            }
        })
    }

    /// The same with the vertices of their walks, for a regularisation that depends on full paths.
    pub fn trace_nodes<T: Traverse, S: LaneSampler>(
        &mut self,
        view: &SceneView<'_, T>,
        tracer: &PhotonTracer<'_>,
        regularization: &Regularization,
        samplers: &mut [S],
    ) -> PhotonList {
        let mut last = vec![NONE; samplers.len()];
        self.emit(tracer, samplers);
        self.follow(view, samplers, |i, bounce| {
            photon_bounce(tracer, regularization, &mut last[i], bounce)
        })
    }

    /// Begins a light walk with the numbers of each of `samplers`; returns their emitters.
    fn emit<S: LaneSampler>(&mut self, tracer: &PhotonTracer<'_>, samplers: &mut [S]) -> Vec<u32> {
        self.walks.clear();
        let start = |sampler: &mut S| {
            let start = tracer.emit(sampler);
            self.walks.push(Walk::from_emitter(&start), start.is_some());
            start.emitter
        };
        samplers.iter_mut().map(start).collect()
    }

    /// Follows the walks to their ends; returns the photons that their bounces leave.
    fn follow<T: Traverse, S: LaneSampler>(
        &mut self,
        view: &SceneView<'_, T>,
        samplers: &mut [S],
        mut bounce: impl FnMut(usize, &mut LightBounce<'_, S, PhotonList>) -> u32,
    ) -> PhotonList {
        let mut list = PhotonList::default();
        while !self.walks.is_done() {
            let site = &mut *self.site;
            self.walks.bounce(view, |i, walk, hit| {
                let mut own = LightBounce {
                    walk,
                    sampler: &mut samplers[i],
                    hit,
                    site: &mut *site,
                    store: &mut list,
                };
                bounce(i, &mut own)
            });
        }
        list
    }

    /// The points where camera walks of a tile's samples, at most [`RAYS`], gather photons.
    pub fn gather_points<T: Traverse, S: LaneSampler>(
        &mut self,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        algorithm: &Progressive<'_>,
        samples: &mut [TileSample<S>],
    ) -> PhotonList {
        let mut points = PhotonList::default();
        self.walks.clear();
        for sample in samples.iter_mut() {
            let seen = camera_ray(&view.tables, &mut sample.camera, sample.pixel);
            self.walks
                .push(Walk::from_sensor(&seen), settings.rules.max_depth > 0);
        }
        while !self.walks.is_done() {
            let site = &mut *self.site;
            self.walks.bounce(view, |i, walk, hit| {
                let sampler = &mut samples[i].camera;
                let gather = |_: &Walk, at: &Interaction<'_>, only_unfound: bool| {
                    let point = gather_point(at.point.geometric_normal, only_unfound);
                    points.push(at.point.position, &point);
                    Vec3::ZERO
                };
                let found = algorithm.camera_bounce(
                    walk,
                    sampler,
                    hit,
                    site,
                    1,
                    gather,
                    |_: Contribution| {},
                );
                found.1
            });
        }
        points
    }

    /// Takes the samples of a tile, at most [`RAYS`]; what they give replaces what `out` held. Returns what the statistics of
    /// adaptive radii learn.
    pub fn gather<T: Traverse, S: LaneSampler>(
        &mut self,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        algorithm: &Progressive<'_>,
        photons: &PassPhotons<'_>,
        mut radii: Radii<'_>,
        samples: &mut [TileSample<S>],
        out: &mut TileSamples,
    ) -> Vec<PhotonPass> {
        out.radiance.clear();
        out.radiance.resize(samples.len(), Vec3::ZERO);
        out.splats.clear();
        self.walks.clear();
        self.weights.clear();
        let learning = match &radii {
            Radii::Adaptive(radii) => radii.len(),
            _ => 0,
        };
        let mut sums = vec![PhotonPass::default(); learning];
        for sample in samples.iter_mut() {
            let seen = camera_ray(&view.tables, &mut sample.camera, sample.pixel);
            self.walks
                .push(Walk::from_sensor(&seen), settings.rules.max_depth > 0);
            self.weights.push(seen.weight);
        }
        while !self.walks.is_done() {
            let (shadows, site) = (&mut self.shadows, &mut *self.site);
            self.walks.bounce(view, |i, walk, hit| {
                let (found, next) = algorithm.camera_bounce(
                    walk,
                    &mut samples[i].camera,
                    hit,
                    site,
                    photons.emitted,
                    |walk, at, only_unfound| match &mut radii {
                        Radii::Adaptive(radii) => adaptive::gather(
                            &algorithm.connector,
                            walk,
                            at,
                            &photons.cache,
                            radii[i],
                            only_unfound,
                            &mut sums[i],
                        ),
                        Radii::Shared => {
                            algorithm.gather(walk, at, &photons.cache, photons.radius, only_unfound)
                        }
                        Radii::Own(radii) => {
                            algorithm.gather(walk, at, &photons.cache, radii[i], only_unfound)
                        }
                        Radii::Found(find) => {
                            find(i, at);
                            Vec3::ZERO
                        }
                    },
                    |contribution| shadows.push(view, settings, i as u32, &contribution, out),
                );
                out.radiance[i] += found;
                next
            });
            self.shadows.trace(view, out);
        }
        for (radiance, weight) in out.radiance.iter_mut().zip(&self.weights) {
            *radiance *= *weight;
        }
        sums
    }
}
