//! Directions that many paths leave their surfaces in, side by side.

use super::bsdf_variant;
use super::lobes::LobeLanes;
use super::microfacet_normals::NormalLanes;
use super::paths::PathLanes;
use super::segment::Segment;
use super::surfaces::PointLanes;
use crate::bsdf::{BsdfSample, mixture};
use crate::sampler::LaneSampler;
use crate::simd::lanes::Vec3Lanes;
use crate::simd::multiversioned;
use crate::transport::IntegratorSettings;
use crate::transport::path::step;
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};

/// Samples of up to `N` lobes.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct SampleLanes<const N: usize> {
    wo: Vec3Lanes<N>,
    weight: Vec3Lanes<N>,
    pdf: [f32; N],
    eta: [f32; N],
    event: [u32; N],
}

impl<const N: usize> SampleLanes<N> {
    /// The sample at slot `k < N`.
    #[inline(always)]
    fn get(&self, k: usize) -> BsdfSample {
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
    /// Samples the lobes with the last three of the `numbers`, rough ones at their normals.
    pub(super) fn sample<; const VARIANT: u32, const N: usize>(
        data: &[f32],
        points: &PointLanes<N>,
        lobes: &LobeLanes<N>,
        normals: &NormalLanes<N>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
        samples: &mut SampleLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let lobe = lobes.get::<VARIANT>(k);
            let wi = points.wi.get(k);
            let u1 = numbers[3][k];
            let u2 = Vec2::new(numbers[4][k], numbers[5][k]);
            let m = if bsdf_variant::is_rough(VARIANT) { normals.m.get(k) } else { Vec3::Z };
            let sample = mixture::plain::sample(&lobe, data, wi, u1, u2, m);
            samples.set(k, &sample);
        }
    }

    /// The paths leave along what was sampled. `next` holds their samplers.
    pub(super) fn scatter_along<S: LaneSampler; const N: usize>(
        settings: &IntegratorSettings,
        paths: &PathLanes<N>,
        list: &[u32; N],
        points: &PointLanes<N>,
        samples: &SampleLanes<N>,
        segment: Segment,
        next: &mut PathLanes<N>,
        continues: &mut [u32; N],
    ) {
        let settings = IntegratorSettings {
            strict_normals: 0,
            ..*settings
        };
        for k in segment.slots::<N>() {
            let mut path = paths.gather(list[k]);
            let mut sampler = next.sampler_at::<S>(k);
            let following =
                path.scatter_along(&settings, &mut sampler, &points.get(k), &samples.get(k));
            let is_on = (following != step::END) & path.may_continue(&settings);
            next.set(k, &path);
            next.set_sampler(k, sampler);
            continues[k] = is_on as u32;
        }
    }
}
