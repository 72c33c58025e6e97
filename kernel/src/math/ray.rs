//! Rays with a parameter interval.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Points `origin + t direction` for `t` in `(t_min, t_max)`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Ray {
    /// Start.
    pub origin: Vec3,
    /// Unit direction in world space (may be scaled inside an instance, where t keeps its world meaning).
    pub direction: Vec3,
    /// Open lower end of the interval.
    pub t_min: f32,
    /// Open upper end of the interval.
    pub t_max: f32,
}

impl Ray {
    /// A ray from `origin` to infinity.
    #[inline]
    pub fn new(origin: Vec3, direction: Vec3) -> Ray {
        Ray {
            origin,
            direction,
            t_min: 0.0,
            t_max: f32::MAX,
        }
    }

    /// The point at `t`.
    #[inline]
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}
