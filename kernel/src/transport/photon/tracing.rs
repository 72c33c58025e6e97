//! Light walks that leave photons.
//!
//! Walks start and scatter as those of bidirectional path tracing; a photon is kept where a camera walk may gather it.

use super::cache::Photon;
use crate::path::rules::step;
use crate::path::{Connector, Interaction, ShadingPoint, Walk};
use crate::sampler::Sampler;
use crate::scene::Hit;
use crate::scene::emitter::emission::{self, EmissionSample};
use glam::Vec3;

/// Where photons are kept.
pub trait PhotonStore {
    /// Keeps a photon.
    fn push(&mut self, position: Vec3, photon: &Photon);
}

/// What leaves photons.
#[derive(Clone, Copy)]
pub struct PhotonTracer<'a> {
    /// Rules and weights.
    pub connector: Connector<'a>,
    /// Roughness from which surfaces keep photons.
    pub least_roughness: f32,
    /// Whether photons are kept that come straight from an emitter.
    pub keeps_direct: bool,
}

/// What a bounce of a light walk works on.
pub struct LightBounce<'a, S, P> {
    /// The walk.
    pub walk: &'a mut Walk,
    /// Its random numbers.
    pub sampler: &'a mut S,
    /// What its ray has met.
    pub hit: &'a Hit,
    /// Storage for the surface there.
    pub site: &'a mut ShadingPoint,
    /// Where its photons are kept.
    pub store: &'a mut P,
}

impl<S, P> LightBounce<'_, S, P> {
    /// Looks up where the walk has arrived; returns what is next, one of [`step`].
    #[inline]
    pub fn arrive(&mut self, connector: &Connector<'_>) -> u32 {
        connector.arrive(self.walk, self.hit, self.site).1
    }
}

impl PhotonTracer<'_> {
    /// The ray with which a light walk begins.
    #[inline]
    pub fn emit<S: Sampler>(&self, sampler: &mut S) -> EmissionSample {
        let u_select = sampler.next_1d();
        let u_position = sampler.next_2d();
        let u_direction = sampler.next_2d();
        emission::sample(self.connector.tables, u_select, u_position, u_direction)
    }

    /// One bounce of a light walk, from what its ray meets to its next ray; keeps the photon where
    /// a camera walk may gather it. Returns what is next, [`step::TRACE`] or [`step::END`].
    pub fn light_bounce<S: Sampler, P: PhotonStore>(
        &self,
        bounce: &mut LightBounce<'_, S, P>,
    ) -> u32 {
        let connector = &self.connector;
        let next = bounce.arrive(connector);
        if next != step::SCATTER {
            return next;
        }
        let at = bounce
            .site
            .interaction(bounce.walk.subpath.ray.direction)
            .regularized(connector.regularization.tau, connector.regularization.flags);
        self.deposit(bounce.walk, &at, bounce.store);
        connector.scatter(bounce.walk, &at, bounce.sampler)
    }

    /// Keeps the photon of a walk where it has arrived, if a camera walk may gather it.
    #[inline]
    pub fn deposit<P: PhotonStore>(&self, walk: &Walk, at: &Interaction<'_>, store: &mut P) {
        let (point, direction) = (at.point, walk.subpath.ray.direction);
        let photon = Photon {
            direction: direction.to_array(),
            throughput: walk.subpath.throughput.to_array(),
            normal: point.geometric_normal.to_array(),
            d_vcm: walk.arrived.d_vcm,
            d_vc: walk.arrived.d_vc,
            depth: walk.subpath.depth + 1,
            record: 0,
        };
        if (walk.subpath.depth > 0 || self.keeps_direct) && self.may_gather(at, &photon) {
            store.push(point.position, &photon);
        }
    }

    /// Whether a camera walk gathers photons at a surface: at rough ones all, at others those whose paths nothing else finds.
    #[inline]
    fn may_gather(&self, at: &Interaction<'_>, photon: &Photon) -> bool {
        at.is_connectable()
            && (at.bsdf.roughness() >= self.least_roughness || is_found_by_photons_alone(photon))
    }
}

/// Whether no camera walk meets the emitter of the photon's path and no emitter point can be connected: its walk went through
/// discrete events alone from an emitter that no ray meets, so that its weights have nothing to sum.
#[inline]
pub fn is_found_by_photons_alone(photon: &Photon) -> bool {
    photon.depth > 1 && photon.d_vcm == 0.0 && photon.d_vc == 0.0
}
