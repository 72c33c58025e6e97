//! What paths whose connections are regularised keep beside their lanes, and the loops over it.
//!
//! A shiny lobe is evaluated below the tau of its sample, specular ones too, and the density of a sampled direction that later
//! weights compare with is p_hat ([`crate::transport::regularized_path`]). Where nothing is shiny the loops of path tracing
//! run as they are. Path space regularisation has no loops: shiny surfaces are then shaded one by one.

use super::bsdf_samples::SampleLanes;
use super::bsdf_variant;
use super::lobes::LobeLanes;
use super::paths::{PathLanes, QueuedPaths};
use super::scattering::ScatteringInputs;
use super::segment::Segment;
use crate::math::{Rgb, float, luminance};
use crate::regularize::both_ways::is_lobe_raised;
use crate::regularize::plain_lobe;
use crate::regularize::settings::Regularization;
use crate::simd::lanes::gather;
use crate::simd::multiversioned;
use crate::transport::regularized_share::RegularizedShare;
use bytemuck::Zeroable;

/// How far the lobes in up to `N` slots are regularised.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct ThresholdLanes<const N: usize> {
    /// tau of the path.
    pub tau: [f32; N],
    /// 1 where the lobe has larger values, 0 elsewhere.
    pub is_raised: [u32; N],
}

/// Of up to `N` paths.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct RegularizedLanes<const N: usize> {
    /// The regularisation of each path, by its number in the wavefront.
    pub of_path: [Regularization; N],
    pub thresholds: ThresholdLanes<N>,
    /// The variant of a slot's lobe plus one where p_hat of the direction sampled there is not that of the lobe itself.
    pub pending: [u32; N],
    /// Paths whose next light is weighted by a density that is pending, and how many.
    waiting: [u32; N],
    waiting_count: u32,
    /// Of one variant at a time: its paths among them, their slots in the last bounce, and p_hat.
    of_variant: [u32; N],
    pub slots: [u32; N],
    pub p_hat: [f32; N],
    /// Share of a slot's shadow ray that is regularised, and by which tau or radius.
    share: [f32; N],
    blur: [f32; N],
    /// Regularised luminance of each path, and that times the logarithm of tau or of the radius.
    sums: [[f32; 2]; N],
}

impl<const N: usize> RegularizedLanes<N> {
    /// A path that has not left the sensor.
    pub fn begin(&mut self, path: usize, regularization: Regularization) {
        self.of_path[path] = regularization;
        self.sums[path] = [0.0; 2];
    }

    /// Regularised luminance of the first `count` paths, see [`RegularizedLanes::sums`], times the weights of their samples.
    pub fn finish(&mut self, count: usize, weight: &[f32; N]) -> &[[f32; 2]] {
        for (sum, weight) in self.sums[..count].iter_mut().zip(weight) {
            *sum = [sum[0] * weight, sum[1] * weight];
        }
        &self.sums[..count]
    }

    /// Nothing is regularised in the slots of a segment.
    pub fn clear(&mut self, segment: Segment) {
        for k in segment.padded::<N>() {
            self.share[k] = 0.0;
            self.pending[k] = 0;
        }
    }

    /// Collects the paths whose density is pending and about to be read; `slots` are those of the paths in the last bounce.
    pub fn find_waiting(&mut self, slots: &[u32], reads: impl Fn(usize) -> bool) {
        let mut count = 0;
        for (i, &slot) in slots.iter().enumerate() {
            if count < N {
                self.waiting[count] = i as u32;
            }
            count += usize::from(gather(&self.pending, slot) != 0 && reads(i));
        }
        self.waiting_count = count.min(N) as u32;
    }

    /// Lists those of a variant among them; returns how many.
    pub fn list_waiting(&mut self, variant: u32, slots: &[u32; N]) -> usize {
        let mut count = 0;
        for &i in &self.waiting[..self.waiting_count as usize] {
            let slot = gather(slots, i);
            if count < N && gather(&self.pending, slot) == variant + 1 {
                self.of_variant[count] = i;
                self.slots[count] = slot;
                count += 1;
            }
        }
        count
    }

    /// Gives the first `count` of the variant their densities.
    pub fn set_densities(&self, count: usize, paths: &mut PathLanes<N>) {
        for (&i, &p_hat) in self.of_variant.iter().zip(&self.p_hat).take(count) {
            if p_hat > 0.0 {
                paths.last_pdf[i as usize] = p_hat;
                paths.light_samples[i as usize] = 1.0;
            }
        }
    }

    /// What is regularised of the shadow ray in slot `k < N`, whose path has its density.
    pub fn set_share(&mut self, k: usize, share: RegularizedShare) {
        self.share[k] = share.share;
        self.blur[k] = share.blur;
        self.pending[k] = 0;
    }

    /// What is regularised of the shadow rays in the slots of a segment: all of those at raised lobes.
    pub fn set_shares(&mut self, segment: Segment) {
        for k in segment.padded::<N>() {
            self.share[k] = self.thresholds.is_raised[k] as f32;
            self.blur[k] = self.thresholds.tau[k];
        }
    }

    /// Adds the regularised share of the light of slot `k` to path `i`, both below `N`.
    pub fn add_share(&mut self, k: usize, i: usize, light: Rgb) {
        if self.share[k] > 0.0 {
            let part = self.share[k] * luminance(light);
            self.sums[i][0] += part;
            self.sums[i][1] += part * float::ln(self.blur[k]);
        }
    }
}

multiversioned! {
    /// Finds how far the lobes are regularised.
    pub(super) fn find_thresholds<; const VARIANT: u32, const N: usize>(
        queued: &QueuedPaths<'_, N>,
        lobes: &LobeLanes<N>,
        of_path: &[Regularization; N],
        thresholds: &mut ThresholdLanes<N>,
    ) {
        for k in queued.segment.padded::<N>() {
            let tau = gather(of_path, queued.index(k) as u32).tau;
            let is_raised = is_lobe_raised(&lobes.get::<VARIANT>(k), tau);
            thresholds.tau[k] = tau;
            thresholds.is_raised[k] = u32::from(is_raised);
        }
    }

    /// Notes where p_hat of the sampled directions is not their density.
    pub(super) fn set_pending<; const VARIANT: u32, const N: usize>(
        segment: Segment,
        samples: &SampleLanes<N>,
        thresholds: &ThresholdLanes<N>,
        pending: &mut [u32; N],
    ) {
        for k in segment.padded::<N>() {
            let is_event = (thresholds.is_raised[k] != 0) & (samples.get(k).pdf > 0.0);
            pending[k] = if is_event { VARIANT + 1 } else { 0 };
        }
    }

    /// p_hat of the directions sampled in the first of `slots`, as many as the segment counts.
    pub(super) fn find_densities<; const VARIANT: u32, const N: usize>(
        data: &[f32],
        scattering: &ScatteringInputs<'_, N>,
        samples: &SampleLanes<N>,
        tau: &[f32; N],
        slots: &[u32; N],
        p_hat: &mut [f32; N],
    ) {
        for j in scattering.segment.padded::<N>() {
            let k = (slots[j] as usize).min(N - 1);
            let lobe = scattering.lobes.get::<VARIANT>(k);
            let (wi, wo) = (scattering.points.wi.get(k), samples.get(k).wo);
            p_hat[j] = plain_lobe::eval_cosine_pdf(&lobe, data, wi, wo, tau[k]).1;
        }
    }
}

/// Whether lobes of the variant may be regularised.
#[inline(always)]
pub(super) const fn may_be_raised(variant: u32) -> bool {
    variant >= bsdf_variant::CONDUCTOR
}
