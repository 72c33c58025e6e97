//! Random walks from the sensor and from emitters.
//!
//! A walk proceeds ray by ray: [`Walk::update_weights`] at the surface that its ray hits, then [`Walk::scatter`], which samples the
//! BSDF itself and updates the partial sums of the weights ([`super::weight`]). Camera walks transport radiance (refraction
//! divides it by eta^2), light walks flux. At a non-specular vertex, the throughput of a light walk is that of the function
//! which a camera walk would have evaluated (see [`super::evaluation`]). At a specular vertex it is the sampled weight times
//! eta^2, which undoes the scaling of radiance, and times the cosine ratio |wi.n| |wo.n_g| / (|wi.n_g| |wo.n|) with n the
//! lobe's own normal (Veach 1997, section 5.3.2).
//!
//! A frame of a normal or bump map is flipped towards the incident direction, and may differ for a walk from the other side
//! of a specular vertex. Such a vertex can be passed in one direction only: light walks end there, and for camera walks no
//! strategy with a longer light subpath exists.
//!
//! Densities at the ends: the first surface point of a camera walk has the density of one ray per pixel of the crop window,
//! uniform over its area whatever the filter; that of a light walk comes from [`crate::scene::emitter::emission`]. The
//! strategy s = 1 has a density of its own, that of next event estimation.

use super::evaluation::Interaction;
use super::rules::{PathRules, step};
use super::specular_chain::SpecularChain;
use super::subpath::Subpath;
use super::vertex::PathVertex;
use super::weight::{Heuristic, PartialWeights};
use crate::bsdf::{BsdfSample, event, lobe, mode};
use crate::math::{Ray, float};
use crate::sampler::Sampler;
use crate::scene::camera::CameraSample;
use crate::scene::emitter::emission::EmissionSample;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{Hit, NONE, SurfacePoint, Tables};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Where the number of an edit begins in [`Walk::event`].
pub const LABEL_SHIFT: u32 = 16;

/// The moving end of a subpath that may be connected, and what the weights of strategies need to know of it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Walk {
    /// Ray, throughput, depth.
    pub subpath: Subpath,
    /// Largest channel of the throughput at the start of a light walk; of a camera walk, [`crate::scene::camera::CameraSample::cosine`].
    pub initial: f32,
    /// One of [`mode`]: radiance from the sensor, importance from an emitter.
    pub mode: u32,
    /// Partial sums of the weights after the last scattering, before the current edge.
    pub weights: PartialWeights,
    /// The same at the surface that the current ray has hit.
    pub arrived: PartialWeights,
    /// Emitter at which it started, [`NONE`] for a walk from the sensor.
    pub emitter: u32,
    /// The point of an area light at which it started.
    pub start: Hit,
    /// What selective regularisation knows up to the last scattering.
    pub chain: SpecularChain,
    /// The same at the surface that the current ray has hit.
    pub arrived_chain: SpecularChain,
    /// What happened where it scattered last: bits of [`event`], and from [`LABEL_SHIFT`] on one more than the number of the edit
    /// that turned it, zero for none.
    pub event: u32,
}

impl Walk {
    /// The start of a camera walk along a ray of the sensor.
    #[inline]
    pub fn from_sensor(sample: &CameraSample) -> Walk {
        Walk {
            subpath: Subpath::new(&sample.ray, Vec3::ONE),
            initial: sample.cosine,
            mode: mode::RADIANCE,
            weights: PartialWeights::NONE,
            arrived: PartialWeights::NONE,
            emitter: NONE,
            start: Hit::MISS,
            chain: SpecularChain::default(),
            arrived_chain: SpecularChain::default(),
            event: 0,
        }
    }

    /// The start of a light walk along a sampled ray of an emitter.
    #[inline]
    pub fn from_emitter(sample: &EmissionSample) -> Walk {
        let point = &sample.point;
        Walk {
            subpath: Subpath {
                position: point.position,
                ..Subpath::new(&sample.ray, sample.weight)
            },
            initial: sample.weight.max_element(),
            mode: mode::IMPORTANCE,
            weights: PartialWeights::NONE,
            arrived: PartialWeights::NONE,
            emitter: sample.emitter,
            start: start_hit(point),
            chain: SpecularChain::default(),
            arrived_chain: SpecularChain::default(),
            event: 0,
        }
    }

    /// The point of the emitter on which a light walk started.
    #[inline]
    pub fn start_point(&self, tables: &Tables<'_>) -> SurfacePoint {
        if self.start.is_hit() {
            let ray = Ray::new(self.subpath.position, self.subpath.ray.direction);
            return surface_with::<{ detail::NORMALS }>(tables, &ray, &self.start);
        }
        SurfacePoint {
            position: self.subpath.position,
            ..SurfacePoint::ZERO
        }
    }

    /// The record of the surface that the ray has hit.
    #[inline]
    pub fn vertex(&self, hit: &Hit, at: &Interaction<'_>, previous: u32) -> PathVertex {
        PathVertex {
            position: at.point.position.to_array(),
            facing: at.facing().to_array(),
            origin: self.subpath.ray.origin.to_array(),
            direction: self.subpath.ray.direction.to_array(),
            hit: *hit,
            throughput: self.subpath.throughput.to_array(),
            d_vcm: self.arrived.d_vcm,
            d_vc: self.arrived.d_vc,
            depth: self.subpath.depth + 1,
            chain: self.arrived_chain,
            previous,
        }
    }

    /// Samples a direction of the BSDF and continues along it; returns the next [`step`].
    pub fn scatter<S: Sampler>(
        &mut self,
        tables: &Tables<'_>,
        rules: &PathRules,
        h: Heuristic,
        sampler: &mut S,
        at: &Interaction<'_>,
    ) -> u32 {
        let u1 = sampler.next_1d();
        let u2 = sampler.next_2d();
        let (sample, chosen) = at.bsdf.sample_lobe(tables.data, at.wi, u1, u2);
        let sample = at.bsdf.mix(tables.data, at.wi, sample, chosen);
        if sample.pdf <= 0.0 {
            return step::END;
        }
        let point = at.point;
        if sample.event & event::NULL != 0 {
            self.subpath.throughput *= sample.weight;
            return if self.subpath.throughput.max_element() > 0.0 {
                self.subpath.skip_surface(point)
            } else {
                step::END
            };
        }
        let sampled = point.frame.to_world(sample.wo).normalize();
        let turned = at.outgoing(tables, &sample, sampled, sampler);
        let direction = turned.direction;
        let cos_shading = if turned.label == 0 {
            sample.wo.z
        } else {
            point.frame.n.dot(direction)
        };
        if !rules.allows(point, direction, cos_shading) {
            return step::END;
        }
        let cosine = float::abs(point.geometric_normal.dot(direction));
        self.chain = self
            .arrived_chain
            .scattered(sample.event & event::DELTA != 0);
        let factor = if sample.event & event::DELTA != 0 {
            let is_reversible = at.bsdf.has_same_frame(tables, point, chosen, sample.wo);
            self.weights = if at.is_regularized() {
                self.regularized_weights(tables, h, at, &sample, cosine, is_reversible)
            } else if is_reversible {
                let cosine = cosine * (turned.pdf_reverse / turned.pdf);
                self.arrived.scatter_delta(h, cosine)
            } else {
                // No walk can come from the other end.
                PartialWeights::NONE
            };
            if self.mode == mode::IMPORTANCE && !is_reversible {
                return step::END;
            }
            sample.weight * self.delta_factor(tables, at, &sample, chosen, direction)
        } else {
            let is_light_walk = self.mode == mode::IMPORTANCE;
            let both = at
                .bsdf
                .eval_cosine_pdf_both(tables, point, at.wi, sample.wo, is_light_walk);
            self.weights = if at.is_regularized() {
                self.regularized_weights(tables, h, at, &sample, cosine, true)
            } else {
                let pdf_reverse = both.pdf_reverse * turned.pdf_reverse;
                self.arrived
                    .scatter(h, sample.pdf * turned.pdf, pdf_reverse, cosine)
            };
            if is_light_walk {
                both.value * (at.adjoint_ratio(direction) / sample.pdf)
            } else {
                sample.weight
            }
        };
        let factor = factor * (turned.value / turned.pdf);
        let subpath = &mut self.subpath;
        subpath.throughput *= factor;
        if !(subpath.throughput.max_element() > 0.0) || !subpath.throughput.is_finite() {
            return step::END;
        }
        subpath.eta *= sample.eta;
        self.event = sample.event | turned.label << LABEL_SHIFT;
        let survival = if self.mode == mode::RADIANCE {
            subpath.camera_survival()
        } else {
            subpath.light_survival(self.initial)
        };
        subpath.continue_along(rules, sampler, point, direction, survival)
    }

    /// The partial sums after scattering at a regularised vertex: with p_hat of the sampled direction instead of its density,
    /// which a discrete direction has then too. Without `is_reversible` no walk comes from the other end.
    fn regularized_weights(
        &self,
        tables: &Tables<'_>,
        h: Heuristic,
        at: &Interaction<'_>,
        sample: &BsdfSample,
        cosine: f32,
        is_reversible: bool,
    ) -> PartialWeights {
        let is_light_walk = self.mode == mode::IMPORTANCE;
        let hat = at.eval_cosine_pdf_both(tables, sample.wo, is_light_walk);
        if !(hat.value.max_element() > 0.0) || !(hat.pdf > 0.0) {
            return PartialWeights::NONE;
        }
        let weights = self.arrived.scatter(h, hat.pdf, hat.pdf_reverse, cosine);
        PartialWeights {
            d_vcm: weights.d_vcm,
            d_vc: if is_reversible { weights.d_vc } else { 0.0 },
        }
    }

    /// Factor on the weight of a specular sample: one for radiance, the adjoint correction and eta^2 for importance.
    #[inline]
    fn delta_factor(
        &self,
        tables: &Tables<'_>,
        at: &Interaction<'_>,
        sample: &BsdfSample,
        chosen: u32,
        direction: Vec3,
    ) -> f32 {
        if self.mode == mode::RADIANCE {
            return 1.0;
        }
        let lobe = at.bsdf.lobe(chosen);
        let ratio = lobe::exchange_ratio(&lobe, tables.data, at.wi, sample.wo);
        ratio * at.adjoint_ratio(direction) * sample.eta * sample.eta
    }
}

/// The hit record of a sampled point of an area light, from which it can be looked up again.
#[inline]
fn start_hit(point: &SurfacePoint) -> Hit {
    if point.emitter == NONE {
        return Hit::MISS;
    }
    Hit {
        t: 0.0,
        b1: point.barycentric.x,
        b2: point.barycentric.y,
        primitive: point.primitive,
        instance: point.instance,
    }
}
