//! Diffuse transmission: Lambert's law on the other side.
//!
//! f = tau / pi for directions on opposite sides of the surface, zero elsewhere; tau is `specular_transmittance`. Sampled
//! with the cosine, p = |cos| / pi per solid angle. There is no change of index, so radiance is not scaled. Invariant: what
//! is transmitted is tau for every wi (furnace test), and f is symmetric.

use super::{BsdfSample, Lobe, event};
use crate::math::{Rgb, float, warp};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z * wo.z >= 0.0 {
        return Vec3::ZERO;
    }
    lobe.specular_transmittance * FRAC_1_PI
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(_lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    if wi.z * wo.z >= 0.0 {
        return 0.0;
    }
    float::abs(wo.z) * FRAC_1_PI
}

/// A cosine-distributed direction on the other side; `u1` is not used.
#[inline]
pub fn sample(lobe: &Lobe, wi: Vec3, _u1: f32, u2: Vec2) -> BsdfSample {
    let above = warp::square_to_cosine_hemisphere(u2);
    let wo = Vec3::new(above.x, above.y, float::with_sign_of(above.z, -wi.z));
    BsdfSample {
        wo,
        weight: lobe.specular_transmittance,
        // Directions in the horizon have no side.
        pdf: pdf(lobe, wi, wo),
        eta: 1.0,
        event: event::TRANSMISSION | event::DIFFUSE,
    }
}
