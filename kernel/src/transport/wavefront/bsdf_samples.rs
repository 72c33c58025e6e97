//! Sampled directions, in lanes, and the paths that continue along them.

use super::bsdf_variant;
use super::microfacet_normals::NormalLanes;
use super::paths::{NextPathLanes, QueuedPaths};
use super::scattering::ScatteringInputs;
use super::surfaces::PointLanes;
use crate::bsdf::{BsdfSample, mixture};
use crate::path::PathRules;
use crate::sampler::LaneSampler;
use crate::simd::lanes::Vec3Lanes;
use crate::simd::multiversioned;
use crate::transport::path::step;
use bytemuck::Zeroable;
use glam::Vec3;

/// BSDF samples of up to `N` paths.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct SampleLanes<const N: usize> {
    pub(super) wo: Vec3Lanes<N>,
    weight: Vec3Lanes<N>,
    pdf: [f32; N],
    eta: [f32; N],
    event: [u32; N],
}

impl<const N: usize> SampleLanes<N> {
    /// The sample at slot `k < N`.
    #[inline(always)]
    pub(super) fn get(&self, k: usize) -> BsdfSample {
        BsdfSample {
            wo: self.wo.get(k),
            weight: self.weight.get(k),
            pdf: self.pdf[k],
            eta: self.eta[k],
            event: self.event[k],
        }
    }

    #[inline(always)]
    fn set(&mut self, k: usize, sample: &BsdfSample) {
        self.wo.set(k, sample.wo);
        self.weight.set(k, sample.weight);
        self.pdf[k] = sample.pdf;
        self.eta[k] = sample.eta;
        self.event[k] = sample.event;
    }
}

multiversioned! {
    /// Samples the lobes, rough ones at their microfacet normals.
    pub(super) fn sample<; const VARIANT: u32, const N: usize>(
        data: &[f32],
        scattering: &ScatteringInputs<'_, N>,
        normals: &NormalLanes<N>,
        samples: &mut SampleLanes<N>,
    ) {
        for k in scattering.segment.padded::<N>() {
            let lobe = scattering.lobes.get::<VARIANT>(k);
            let wi = scattering.points.wi.get(k);
            let (u1, u2) = (scattering.numbers.event[k], scattering.numbers.direction(k));
            let m = if bsdf_variant::is_rough(VARIANT) { normals.m.get(k) } else { Vec3::Z };
            let sample = mixture::plain::sample(&lobe, data, wi, u1, u2, m);
            samples.set(k, &sample);
        }
    }

    /// Continues the paths along their samples. `next` holds their samplers.
    pub(super) fn continue_along<S: LaneSampler; const N: usize>(
        rules: &PathRules,
        queued: &QueuedPaths<'_, N>,
        points: &PointLanes<N>,
        samples: &SampleLanes<N>,
        next: &mut NextPathLanes<N>,
    ) {
        // Paths under strict normals are in the fallback queue.
        let rules = PathRules {
            strict_normals: 0,
            ..*rules
        };
        for k in queued.segment.padded::<N>() {
            let mut path = queued.paths.gather(queued.entries[k]);
            let mut sampler = next.paths.sampler_at::<S>(k);
            let following = path.scatter(&rules, &mut sampler, &points.get(k), &samples.get(k));
            next.paths.set(k, &path);
            next.paths.set_sampler(k, sampler);
            next.continues[k] = (following != step::END) as u32;
        }
    }
}
