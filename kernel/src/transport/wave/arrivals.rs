//! Light that may reach many paths, side by side, and that what does.

use super::super::path::Arrival;
use super::segment::Segment;
use crate::math::lanes::{Vec3Lanes, pick, whole};
use crate::math::vectors::over_lanes;
use crate::math::{Ray, Rgb};
use crate::scene::{HitBatch, RayBatch};
use bytemuck::Zeroable;

/// Up to `N` segments to emitters.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct ArrivalLanes<const N: usize> {
    /// The segments.
    pub rays: RayBatch<N>,
    /// What arrives where nothing is in the way.
    pub radiance: Vec3Lanes<N>,
    /// Where it is gathered.
    pub place: [u32; N],
}

impl<const N: usize> ArrivalLanes<N> {
    /// Sets slot `k < N` but for its place.
    #[inline(always)]
    pub fn set(&mut self, k: usize, arrival: &Arrival) {
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
    pub fn gather(&self, obstacles: &HitBatch<N>, count: usize, radiance: &mut [Rgb; N]) {
        for j in 0..count.min(N) {
            if !obstacles.is_hit(j) {
                let place = (self.place[j] as usize).min(N - 1);
                radiance[place] += self.radiance.get(j);
            }
        }
    }
}

over_lanes! {
    /// Makes `to` the first `count` of `list`.
    pub(super) fn take<; const N: usize>(
        from: &ArrivalLanes<N>,
        list: &[u32; N],
        count: usize,
        to: &mut ArrivalLanes<N>,
    ) {
        for j in 0..whole::<N>(count) {
            let k = list[j];
            let ray = Ray {
                origin: from.rays.origin.pick(k),
                direction: from.rays.direction.pick(k),
                t_min: pick(&from.rays.t_min, k),
                t_max: pick(&from.rays.t_max, k),
            };
            to.rays.set(j, &ray);
            to.radiance.set(j, from.radiance.pick(k));
            to.place[j] = pick(&from.place, k);
        }
    }
}
