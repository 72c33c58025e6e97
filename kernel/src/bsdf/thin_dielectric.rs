//! Thin slab of a dielectric: two parallel boundaries with nothing between them that shifts or absorbs the light.
//!
//! The reflections inside the slab add up to `R' = R + T^2 R / (1 - R^2) = 2 R / (1 + R)` with `T = 1 - R` of one
//! boundary; the rest goes straight through. Both sides look alike, and no radiance is scaled, because the light ends
//! in the medium that it came from: `eta` of the sample is 1. `lobe.eta.x` is the index of the slab over that of the
//! surroundings. Checked: `R'` against the summed series, probabilities add to 1.

use super::fresnel::fresnel_dielectric;
use super::{BsdfSample, Lobe, event};
use crate::math::Rgb;
use crate::math::float::abs;
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

/// Reflection when `u1` is below the slab's reflectance, straight transmission otherwise.
///
/// Transmission carries no [`event::NULL`]: it is an interaction, which shadow rays do not pass.
#[inline]
pub fn sample(lobe: &Lobe, wi: Vec3, u1: f32, _u2: Vec2) -> BsdfSample {
    let boundary = fresnel_dielectric(abs(wi.z), lobe.eta.x).0;
    let reflectance = 2.0 * boundary / (1.0 + boundary);
    if u1 < reflectance {
        return BsdfSample {
            wo: Vec3::new(-wi.x, -wi.y, wi.z),
            weight: lobe.specular_reflectance,
            pdf: reflectance,
            eta: 1.0,
            event: event::DELTA | event::REFLECTION,
        };
    }
    if reflectance >= 1.0 {
        return BsdfSample::NONE;
    }
    BsdfSample {
        wo: -wi,
        weight: lobe.specular_transmittance,
        pdf: 1.0 - reflectance,
        eta: 1.0,
        event: event::DELTA | event::TRANSMISSION,
    }
}
