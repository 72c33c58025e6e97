//! The regularised connection of a path to an emitter ([`super::regularized_path`]).

use super::connection::{SampleCounts, ShadowRay, weighted_contribution};
use super::path::step;
use super::regularized_path::RegularizedPath;
use super::regularized_share::RegularizedShare;
use crate::bsdf::{BsdfSample, event, mode};
use crate::math::Rgb;
use crate::path::Interaction;
use crate::path::mollified::{Blur, mollified};
use crate::path::spread::emitter_quality;
use crate::regularize::bandwidth::TAU_MAX;
use crate::regularize::regularized_bsdf::mixture_bound;
use crate::regularize::settings::flag;
use crate::regularize::virtual_merge::virtual_merge;
use crate::sampler::Sampler;
use crate::scene::Traverse;
use crate::scene::emitter::DirectSample;
use glam::Vec3;

impl<T: Traverse, S: Sampler, F: FnMut(&ShadowRay, RegularizedShare)> RegularizedPath<'_, T, S, F> {
    pub(super) fn interaction(&self) -> Interaction<'_> {
        let mut at = self.single.interaction();
        at.tau = self.tau;
        at.variant = self.regularization.flags;
        at
    }

    /// Whether the surface is connected to emitters.
    pub(super) fn is_lit(&self) -> bool {
        if self.single.next != step::SCATTER {
            return false;
        }
        let is_mollified = self.regularization.radius > 0.0 && self.single.bsdf.has_delta();
        is_mollified || self.interaction().is_connectable()
    }

    /// Passes on what a chosen light adds.
    pub(super) fn connect(&mut self, light: &DirectSample) {
        let is_regularized = self.interaction().is_regularized();
        let mut sample = BsdfSample::NONE;
        if self.has(flag::VIRTUAL_MERGE) && is_regularized && light.is_some() {
            let u1 = self.single.sampler.next_1d();
            let u2 = self.single.sampler.next_2d();
            let at = self.interaction();
            sample = at.bsdf.sample(self.single.view.tables.data, at.wi, u1, u2);
        }
        let (mut ray, share) = self.contribution(light, &sample);
        ray.radiance = self.single.path.subpath.throughput * ray.radiance;
        if ray.is_some() {
            (self.shadows)(&ray, share);
        }
    }

    fn contribution(
        &self,
        light: &DirectSample,
        sample: &BsdfSample,
    ) -> (ShadowRay, RegularizedShare) {
        let none = (ShadowRay::NONE, RegularizedShare::NONE);
        if !light.is_some() {
            return none;
        }
        let tables = &self.single.view.tables;
        let at = self.interaction();
        let wo = at.point.frame.to_local(light.direction);
        if !self.single.rules.allows(at.point, light.direction, wo.z) {
            return none;
        }
        if !at.is_regularized() || !self.has(flag::QUALITY) {
            return self.weighted(light, &at, wo, sample);
        }
        let rho = mixture_bound(at.bsdf, at.wi.z * wo.z < 0.0);
        let length = self.arrived.length;
        let q = emitter_quality(tables, light.emitter, rho, length, light.distance);
        let share = self.regularization.share(q);
        let mut sum = Rgb::ZERO;
        let mut part = Rgb::ZERO;
        let mut ray = ShadowRay::NONE;
        for (of, tau) in [(share, self.tau), (1.0 - share, TAU_MAX)] {
            if of > 0.0 {
                ray = self
                    .weighted(light, &Interaction { tau, ..at }, wo, sample)
                    .0;
                sum += ray.radiance * of;
                if tau < TAU_MAX {
                    part = sum;
                }
            }
        }
        ray.radiance = sum;
        (ray, RegularizedShare::new(part, sum, self.tau))
    }

    /// The light of a sample, weighted against the walk. A virtual merge accepts it by the `sample` of the BSDF.
    fn weighted(
        &self,
        light: &DirectSample,
        at: &Interaction<'_>,
        wo: Vec3,
        sample: &BsdfSample,
    ) -> (ShadowRay, RegularizedShare) {
        let tables = &self.single.view.tables;
        let is_merged = self.has(flag::VIRTUAL_MERGE) && at.is_regularized();
        let (mut value, pdf) = if !is_merged {
            at.eval_cosine_pdf(tables, wo)
        } else if sample.wo.z * wo.z > 0.0 && sample.event & event::NULL == 0 {
            let merged = virtual_merge(sample, wo, at.tau);
            (merged.value, merged.pdf)
        } else {
            (Rgb::ZERO, 0.0)
        };
        let mut share = RegularizedShare {
            share: if at.is_regularized() { 1.0 } else { 0.0 },
            blur: at.blur(),
        };
        let regularization = &self.regularization;
        if regularization.radius > 0.0 && light.is_delta != 0 {
            let distance = if light.distance < f32::MAX {
                light.distance
            } else {
                tables.info.radius
            };
            let blur = Blur::new(regularization.kernel, regularization.radius, distance);
            let rules = &self.single.rules;
            let blurred = mollified(at, tables, rules, mode::RADIANCE, light.direction, blur);
            value += blurred;
            share = RegularizedShare::new(blurred, value, regularization.radius);
        }
        let ray = weighted_contribution(light, at.point, SampleCounts::ONE, value, pdf);
        (ray, share)
    }
}
