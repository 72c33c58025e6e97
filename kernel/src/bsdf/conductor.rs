//! Smooth conductor: a mirror with the exact Fresnel reflectance of a complex index.
//!
//! `f cos = specular_reflectance F(wi.z) delta(wo - mirrored wi)`; `lobe.eta` and `lobe.k` are the index per channel,
//! relative to the exterior. One-sided: nothing below the horizon. The reflectance is at most
//! `specular_reflectance` (tested).

use super::fresnel::fresnel_conductor;
use super::{BsdfSample, Lobe, event};
use crate::math::Rgb;
use glam::{Vec2, Vec3};

/// Zero: the lobe is a delta distribution.
#[inline]
pub fn eval(_lobe: &Lobe, _wi: Vec3, _wo: Vec3) -> Rgb {
    Rgb::ZERO
}

/// Zero: the lobe is a delta distribution.
#[inline]
pub fn pdf(_lobe: &Lobe, _wi: Vec3, _wo: Vec3) -> f32 {
    0.0
}

/// The mirrored direction.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample(lobe: &Lobe, wi: Vec3, _u1: f32, _u2: Vec2) -> BsdfSample {
    if wi.z <= 0.0 {
        return BsdfSample::NONE;
    }
    BsdfSample {
        wo: Vec3::new(-wi.x, -wi.y, wi.z),
        weight: lobe.specular_reflectance * fresnel_conductor(wi.z, lobe.eta, lobe.k),
        pdf: 1.0,
        eta: 1.0,
        event: event::DELTA | event::REFLECTION,
    }
}
