//! Batches of rays for a ray tracer, and of their hits, as structures of arrays.
//!
//! Hosts only: a shader traces single rays.

use super::hit::Hit;
use crate::math::Ray;
use crate::simd::lanes::Vec3Lanes;
use bytemuck::Zeroable;

/// Up to `N` rays side by side.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Zeroable)]
pub struct RayBatch<const N: usize> {
    /// Starts.
    pub origin: Vec3Lanes<N>,
    /// Directions.
    pub direction: Vec3Lanes<N>,
    /// Lower ends of the intervals.
    pub t_min: [f32; N],
    /// Upper ends of the intervals.
    pub t_max: [f32; N],
}

impl<const N: usize> RayBatch<N> {
    /// Ray `i < N`.
    #[inline(always)]
    pub fn get(&self, i: usize) -> Ray {
        Ray {
            origin: self.origin.get(i),
            direction: self.direction.get(i),
            t_min: self.t_min[i],
            t_max: self.t_max[i],
        }
    }

    /// Sets ray `i < N`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, ray: &Ray) {
        self.origin.set(i, ray.origin);
        self.direction.set(i, ray.direction);
        self.t_min[i] = ray.t_min;
        self.t_max[i] = ray.t_max;
    }
}

/// What rays hit, each at the index of its ray.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Zeroable)]
pub struct HitBatch<const N: usize> {
    /// See [`Hit::t`].
    pub t: [f32; N],
    /// See [`Hit::b1`].
    pub b1: [f32; N],
    /// See [`Hit::b2`].
    pub b2: [f32; N],
    /// See [`Hit::primitive`].
    pub primitive: [u32; N],
    /// See [`Hit::instance`].
    pub instance: [u32; N],
}

impl<const N: usize> HitBatch<N> {
    /// Hit `i < N`.
    #[inline(always)]
    pub fn get(&self, i: usize) -> Hit {
        Hit {
            t: self.t[i],
            b1: self.b1[i],
            b2: self.b2[i],
            primitive: self.primitive[i],
            instance: self.instance[i],
        }
    }

    /// Whether ray `i < N` has hit a surface.
    #[inline(always)]
    pub fn is_hit(&self, i: usize) -> bool {
        self.t[i] < f32::MAX
    }

    /// Sets hit `i < N`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, hit: &Hit) {
        self.t[i] = hit.t;
        self.b1[i] = hit.b1;
        self.b2[i] = hit.b2;
        self.primitive[i] = hit.primitive;
        self.instance[i] = hit.instance;
    }
}
