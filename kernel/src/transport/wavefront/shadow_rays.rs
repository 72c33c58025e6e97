//! Light that may reach many paths, side by side, and that what does.

use super::super::path::ShadowRay;
use super::segment::Segment;
use crate::math::{Ray, Rgb};
use crate::scene::{HitBatch, RayBatch};
use crate::simd::lanes::{Vec3Lanes, gather, round_up_to_vector};
use crate::simd::multiversioned;
use bytemuck::Zeroable;

/// Up to `N` segments to emitters.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct ShadowRayLanes<const N: usize> {
    /// The segments.
    pub rays: RayBatch<N>,
    /// What arrives where nothing is in the way.
    pub radiance: Vec3Lanes<N>,
    /// Where it is gathered.
    pub place: [u32; N],
}

impl<const N: usize> ShadowRayLanes<N> {
    /// Sets slot `k < N` but for its place.
    #[inline(always)]
    pub fn set(&mut self, k: usize, arrival: &ShadowRay) {
        self.rays.set(k, &arrival.connection.ray);
        self.radiance
            .set(k, arrival.throughput * arrival.connection.radiance);
    }

    /// Whether there is light at slot `k < N`.
    #[inline(always)]
    pub fn is_lit(&self, k: usize) -> bool {
        self.radiance.get(k).max_element() > 0.0
    }

    /// The slots of a segment where there is light, appended to the first `count` of `list`; returns how many there are
    /// then.
    #[inline(always)]
    pub fn list_lit(&self, segment: Segment, list: &mut [u32; N], count: usize) -> usize {
        let mut count = count;
        for k in segment.taken::<N>() {
            if count < N {
                list[count] = k as u32;
            }
            count += usize::from(self.is_lit(k));
        }
        count.min(N)
    }

    /// Gathers the light of the first `count` where nothing is in the way.
    #[inline(always)]
    pub fn accumulate(&self, obstacles: &HitBatch<N>, count: usize, radiance: &mut [Rgb; N]) {
        for j in 0..count.min(N) {
            if !obstacles.is_hit(j) {
                let place = (self.place[j] as usize).min(N - 1);
                radiance[place] += self.radiance.get(j);
            }
        }
    }
}

multiversioned! {
    /// Makes `to` the first `count` of `list`.
    pub(super) fn take<; const N: usize>(
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
            to.place[j] = gather(&from.place, k);
        }
    }
}
