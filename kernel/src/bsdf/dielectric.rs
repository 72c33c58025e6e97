//! Smooth dielectric boundary: Fresnel reflection and refraction.
//!
//! `f cos = specular_reflectance F delta(reflected) + specular_transmittance (1 - F) s delta(refracted)`, where `s` is
//! `1 / eta^2` for radiance and 1 for importance, `eta` the index on the side of `wo` over that of `wi`. `lobe.eta.x`
//! is interior over exterior; `wi` may be on either side. A branch is chosen with its Fresnel probability, so that its
//! weight is its colour. At `lobe.eta.x == 1` light passes straight on. Checked: probabilities add to 1, Snell's law,
//! Stokes' reciprocity.

use super::fresnel::{fresnel_dielectric, relative_eta};
use super::{BsdfSample, Lobe, event, mode};
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

/// Reflection when `u1` is below the reflectance, refraction otherwise.
#[inline]
pub fn sample(lobe: &Lobe, wi: Vec3, u1: f32, _u2: Vec2) -> BsdfSample {
    let (reflectance, cos_t) = fresnel_dielectric(wi.z, lobe.eta.x);
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
    let eta = relative_eta(wi.z, lobe.eta.x);
    let scale = 1.0 / eta;
    let mut weight = lobe.specular_transmittance;
    if lobe.mode == mode::RADIANCE {
        // Radiance is spread over a solid angle that shrinks by eta^2.
        weight *= scale * scale;
    }
    BsdfSample {
        wo: Vec3::new(-wi.x * scale, -wi.y * scale, cos_t),
        weight,
        pdf: 1.0 - reflectance,
        eta,
        event: event::DELTA | event::TRANSMISSION,
    }
}
