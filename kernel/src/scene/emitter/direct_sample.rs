//! The record of a sample of direct illumination.

use crate::math::Rgb;
use crate::scene::NONE;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// Light arriving at a point from a sampled direction.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct DirectSample {
    /// Unit direction from the reference point to the light, in world space.
    pub direction: Vec3,
    /// Distance to the light along it; [`f32::MAX`] for lights at infinity.
    pub distance: f32,
    /// End of the segment to test for visibility: a point just off the light's surface, on the reference point's side.
    /// Meaningless for lights at infinity.
    pub target: Vec3,
    /// Radiance, or irradiance on a facing surface for delta lights.
    pub radiance: Rgb,
    /// Density per solid angle including the choice of the emitter, or the probability of the choice for delta lights;
    /// zero for no sample.
    pub pdf: f32,
    /// 1 if no other strategy can find this direction.
    pub is_delta: u32,
    /// Index into the emitters.
    pub emitter: u32,
}

impl DirectSample {
    /// No sample.
    pub const NONE: DirectSample = DirectSample {
        direction: Vec3::Z,
        distance: 0.0,
        target: Vec3::ZERO,
        radiance: Vec3::ZERO,
        pdf: 0.0,
        is_delta: 0,
        emitter: NONE,
    };

    /// Whether it is a sample of positive radiance.
    #[inline]
    pub fn is_some(&self) -> bool {
        !(self.pdf <= 0.0 || self.radiance.max_element() <= 0.0)
    }
}
