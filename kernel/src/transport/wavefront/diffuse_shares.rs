//! The diffuse share of what rough plastics scatter, in lanes: what path expressions divide their light by
//! ([`crate::bsdf::diffuse_share`]).

use super::emitter_samples::EmitterSampleLanes;
use super::lobes::LobeLanes;
use super::segment::Segment;
use super::surfaces::PointLanes;
use crate::bsdf::diffuse_share;
use crate::simd::lanes::Vec3Lanes;
use crate::simd::{SimdLevel, multiversioned};
use bytemuck::Zeroable;

/// Shares of diffuse scattering of up to `N` vertices that do both.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct DiffuseShareLanes<const N: usize> {
    /// Of what comes from the emitter sample.
    pub lit: Vec3Lanes<N>,
    /// In the direction in which the path goes on.
    pub scattered: Vec3Lanes<N>,
}

impl<const N: usize> DiffuseShareLanes<N> {
    /// How the rough plastics of a segment divide what they scatter from emitter samples, and in the local directions `wo`.
    pub fn divide<const VARIANT: u32>(
        &mut self,
        simd: SimdLevel,
        data: &[f32],
        segment: Segment,
        points: &PointLanes<N>,
        lobes: &LobeLanes<N>,
        lights: &EmitterSampleLanes<N>,
        wo: &Vec3Lanes<N>,
    ) {
        let lit = &mut self.lit;
        shares_of_light::<VARIANT, N>(simd, data, segment, points, lobes, lights, lit);
        let scattered = &mut self.scattered;
        shares_of_samples::<VARIANT, N>(simd, data, segment, points, lobes, wo, scattered);
    }
}

multiversioned! {
    /// The diffuse share of what comes from emitter samples.
    fn shares_of_light<; const VARIANT: u32, const N: usize>(
        data: &[f32],
        segment: Segment,
        points: &PointLanes<N>,
        lobes: &LobeLanes<N>,
        lights: &EmitterSampleLanes<N>,
        shares: &mut Vec3Lanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let lobe = lobes.get::<VARIANT>(k);
            let wo = points.get(k).frame.to_local(lights.get(k).direction);
            let share = diffuse_share::of_rough_plastic(&lobe, data, points.wi.get(k), wo);
            shares.set(k, share);
        }
    }

    /// The diffuse share in local directions.
    fn shares_of_samples<; const VARIANT: u32, const N: usize>(
        data: &[f32],
        segment: Segment,
        points: &PointLanes<N>,
        lobes: &LobeLanes<N>,
        wo: &Vec3Lanes<N>,
        shares: &mut Vec3Lanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let lobe = lobes.get::<VARIANT>(k);
            let share = diffuse_share::of_rough_plastic(&lobe, data, points.wi.get(k), wo.get(k));
            shares.set(k, share);
        }
    }
}
