//! What a ray tracer must answer.

#[cfg(not(target_arch = "spirv"))]
use super::batch::{HitBatch, RayBatch};
use crate::math::Ray;
use bytemuck::{Pod, Zeroable};

/// The nearest intersection along a ray.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Hit {
    /// Ray parameter; [`f32::MAX`] when nothing was hit.
    pub t: f32,
    /// Barycentric weight of a triangle's second vertex; unused for quadrics.
    pub b1: f32,
    /// Barycentric weight of a triangle's third vertex; unused for quadrics.
    pub b2: f32,
    /// Index of a triangle, or the number of triangles plus the index of a quadric.
    pub primitive: u32,
    /// Index of the instance, 0 for the world.
    pub instance: u32,
}

impl Hit {
    /// No intersection.
    pub const MISS: Hit = Hit {
        t: f32::MAX,
        b1: 0.0,
        b2: 0.0,
        primitive: u32::MAX,
        instance: 0,
    };

    /// Whether something was hit.
    #[inline]
    pub fn is_hit(&self) -> bool {
        self.t < f32::MAX
    }

    /// Whether an intersection comes before this one in the order of [`Traverse::closest_hit`]; one at [`f32::MAX`], which
    /// is a miss, comes before none.
    #[inline]
    pub fn is_behind(&self, t: f32, primitive: u32, instance: u32) -> bool {
        let is_lower =
            primitive < self.primitive || (primitive == self.primitive && instance < self.instance);
        t < self.t || (t == self.t && self.is_hit() && is_lower)
    }
}

/// How far beyond its nearest hit a traverser looks, as a factor: boxes at the same distance are visited still, though
/// their distances were rounded otherwise, because an intersection in them may come first in the order.
pub const REACH: f32 = 1.0 + 1e-6;

/// A ray tracer over the scene's primitives.
pub trait Traverse {
    /// The nearest intersection with `t_min < t < t_max`. Of several at the very same `t` it is the one with the lowest
    /// primitive, and of those the one in the lowest instance: where surfaces coincide, what is hit depends neither on
    /// the tree nor on the order in which it is walked.
    fn closest_hit(&self, ray: &Ray) -> Hit;
    /// Whether anything lies in `t_min < t < t_max`.
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

    /// [`Traverse::is_occluded`] of the first `count` rays: [`HitBatch::is_hit`] tells which are. Nothing else of the hits is
    /// meant to be read.
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
