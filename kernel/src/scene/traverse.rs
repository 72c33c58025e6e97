//! The interface of ray tracers.

#[cfg(not(target_arch = "spirv"))]
use super::batch::{HitBatch, RayBatch};
use super::hit::Hit;
use crate::math::Ray;

/// The factor by which a traverser searches beyond its nearest hit. Boxes at the same distance, which may round differently,
/// are thereby still visited: of hits at equal distances the one of the lowest index counts.
pub const REACH: f32 = 1.0 + 1e-6;

/// A ray tracer over the scene's primitives.
pub trait Traverse {
    /// The nearest intersection with `t_min < t < t_max`. Of several at the very same `t` it is the one with the lowest
    /// primitive, and of those the one in the lowest instance: where surfaces coincide, what is hit depends neither on
    /// the tree nor on the order in which it is walked.
    fn closest_hit(&self, ray: &Ray) -> Hit;
    /// Whether there is an intersection in `t_min < t < t_max`.
    fn is_occluded(&self, ray: &Ray) -> bool;

    /// [`Traverse::closest_hit`] of the first `count` rays.
    #[cfg(not(target_arch = "spirv"))]
    fn closest_hits<const N: usize>(
        &self,
        rays: &RayBatch<N>,
        count: usize,
        hits: &mut HitBatch<N>,
    ) {
        closest_hits_in_turn(self, rays, count, hits);
    }

    /// [`Traverse::is_occluded`] of the first `count` rays: [`HitBatch::is_hit`] is true for occluded rays; the
    /// other fields of the hits are undefined.
    #[cfg(not(target_arch = "spirv"))]
    fn are_occluded<const N: usize>(
        &self,
        rays: &RayBatch<N>,
        count: usize,
        hits: &mut HitBatch<N>,
    ) {
        are_occluded_in_turn(self, rays, count, hits);
    }
}

/// [`Traverse::closest_hits`] by single rays.
#[cfg(not(target_arch = "spirv"))]
#[inline]
pub fn closest_hits_in_turn<T: Traverse + ?Sized, const N: usize>(
    traverse: &T,
    rays: &RayBatch<N>,
    count: usize,
    hits: &mut HitBatch<N>,
) {
    for i in 0..count.min(N) {
        hits.set(i, &traverse.closest_hit(&rays.get(i)));
    }
}

/// [`Traverse::are_occluded`] by single rays.
#[cfg(not(target_arch = "spirv"))]
#[inline]
pub fn are_occluded_in_turn<T: Traverse + ?Sized, const N: usize>(
    traverse: &T,
    rays: &RayBatch<N>,
    count: usize,
    hits: &mut HitBatch<N>,
) {
    for i in 0..count.min(N) {
        let is_occluded = traverse.is_occluded(&rays.get(i));
        hits.t[i] = if is_occluded { 0.0 } else { f32::MAX };
    }
}
