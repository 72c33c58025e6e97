//! Shadow rays, in lanes: emitter samples whose visibility is unknown, and the accumulation of those that are visible.

use super::segment::Segment;
use crate::math::{Ray, Rgb};
use crate::scene::{HitBatch, RayBatch};
use crate::simd::lanes::{Vec3Lanes, gather, round_up_to_vector};
use crate::simd::multiversioned;
use crate::transport::connection::ShadowRay;
use bytemuck::Zeroable;

/// Up to `N` shadow rays.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct ShadowRayLanes<const N: usize> {
    /// The segments to the emitters.
    pub rays: RayBatch<N>,
    /// What they contribute if nothing occludes them.
    pub radiance: Vec3Lanes<N>,
    /// The paths that they contribute to.
    pub index: [u32; N],
}

impl<const N: usize> ShadowRayLanes<N> {
    /// Sets slot `k < N`, except for its index.
    #[inline(always)]
    pub fn set(&mut self, k: usize, shadow_ray: &ShadowRay) {
        self.rays.set(k, &shadow_ray.ray);
        self.radiance.set(k, shadow_ray.radiance);
    }

    /// Shadow rays without a contribution in the slots of a segment.
    pub fn clear(&mut self, segment: Segment) {
        for k in segment.padded::<N>() {
            self.radiance.set(k, Rgb::ZERO);
        }
    }

    /// Whether slot `k < N` has anything to contribute.
    #[inline(always)]
    pub fn is_lit(&self, k: usize) -> bool {
        self.radiance.get(k).max_element() > 0.0
    }

    /// Appends the slots of a segment that have something to contribute to the first `count` of `list`; returns the new
    /// count.
    #[inline(always)]
    pub fn list_lit(&self, segment: Segment, list: &mut [u32; N], count: usize) -> usize {
        let mut count = count;
        for k in segment.occupied::<N>() {
            if count < N {
                list[count] = k as u32;
            }
            count += usize::from(self.is_lit(k));
        }
        count.min(N)
    }

    /// Adds the contributions of the first `count` where nothing occludes.
    #[inline(always)]
    pub fn accumulate(&self, occluders: &HitBatch<N>, count: usize, radiance: &mut [Rgb; N]) {
        for j in 0..count.min(N) {
            if !occluders.is_hit(j) {
                let i = (self.index[j] as usize).min(N - 1);
                radiance[i] += self.radiance.get(j);
            }
        }
    }
}

multiversioned! {
    /// Copies the shadow rays at the first `count` entries of `list` to the front of `to`.
    pub(super) fn compact<; const N: usize>(
        from: &ShadowRayLanes<N>,
        list: &[u32; N],
        count: usize,
        to: &mut ShadowRayLanes<N>,
    ) {
        for j in 0..round_up_to_vector::<N>(count) {
            let k = list[j];
            let ray = Ray {
                origin: from.rays.origin.gather(k),
                direction: from.rays.direction.gather(k),
                t_min: gather(&from.rays.t_min, k),
                t_max: gather(&from.rays.t_max, k),
            };
            to.rays.set(j, &ray);
            to.radiance.set(j, from.radiance.gather(k));
            to.index[j] = gather(&from.index, k);
        }
    }
}
