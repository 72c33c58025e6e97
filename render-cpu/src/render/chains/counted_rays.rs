//! A ray tracer that counts its rays, so that a run can say what its mutations cost.
//!
//! Counts are those of a thread: what one task traces, which hands its work to no other thread, is the difference of
//! [`rays_of_thread`] after and before.

use halflight_kernel::math::Ray;
use halflight_kernel::scene::Hit;
use halflight_kernel::scene::batch::{HitBatch, RayBatch};
use halflight_kernel::scene::traverse::Traverse;
use std::cell::Cell;

thread_local! {
    static RAYS: Cell<u64> = const { Cell::new(0) };
}

/// Rays that this thread has traced through any [`CountedRays`].
pub fn rays_of_thread() -> u64 {
    RAYS.get()
}

/// Counts the rays of another ray tracer, those that look for the nearest hit and those that look for any.
#[derive(Clone, Copy)]
pub struct CountedRays<'a, T>(pub &'a T);

impl<T: Traverse> Traverse for CountedRays<'_, T> {
    #[inline]
    fn closest_hit(&self, ray: &Ray) -> Hit {
        RAYS.set(RAYS.get() + 1);
        self.0.closest_hit(ray)
    }

    #[inline]
    fn is_occluded(&self, ray: &Ray) -> bool {
        RAYS.set(RAYS.get() + 1);
        self.0.is_occluded(ray)
    }

    fn closest_hits<const N: usize>(
        &self,
        rays: &RayBatch<N>,
        count: usize,
        hits: &mut HitBatch<N>,
    ) {
        RAYS.set(RAYS.get() + count.min(N) as u64);
        self.0.closest_hits(rays, count, hits);
    }

    fn are_occluded<const N: usize>(
        &self,
        rays: &RayBatch<N>,
        count: usize,
        hits: &mut HitBatch<N>,
    ) {
        RAYS.set(RAYS.get() + count.min(N) as u64);
        self.0.are_occluded(rays, count, hits);
    }
}
