//! The diffuse part of the principled model: Lambert's law that darkens or brightens towards grazing angles with the
//! roughness, and a fit to scattering below the surface.
//!
//! Burley 2012, "Physically-Based Shading at Disney", section 5.3, and Burley 2015, "Extending the Disney BRDF to a BSDF with
//! Integrated Subsurface Scattering". With S(c) = (1 - c)^5, the half vector h, r the roughness, and R = 2 r (wo . h)^2,
//!
//!   f = rho / pi [(1 - t) (f_d + f_r) + t f_s],
//!   f_d = (1 - S_i / 2) (1 - S_o / 2),   f_r = R (S_i + S_o + S_i S_o (R - 1)),
//!   f_s = 1.25 [(1 + S_i (R / 2 - 1)) (1 + S_o (R / 2 - 1)) (1 / (cos_i + cos_o) - 1/2) + 1/2],
//!
//! rho in `reflectance`, r in `alpha.x`, t (called flatness) in `exponent`. Sampled with the cosine. The fit is not exactly
//! conservative: white surfaces return up to 1.51 of the light at grazing angles, where r is 1 (tested). Further invariants (tests):
//! reciprocity, values of an independent renderer.

use super::coat_reflection::half_vector;
use super::{BsdfSample, Lobe, diffuse};
use crate::math::{Rgb, float};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};

/// Schlick's weight (1 - cos)^5.
#[inline]
pub fn schlick_weight(cos: f32) -> f32 {
    let m = (1.0 - cos).max(0.0).min(1.0);
    float::sqr(m * m) * m
}

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    let (s_i, s_o) = (schlick_weight(wi.z), schlick_weight(wo.z));
    let cos_d = wo.dot(half_vector(wi, wo));
    let r = 2.0 * lobe.alpha.x.max(0.0).min(1.0) * cos_d * cos_d;
    let flatness = lobe.exponent.max(0.0).min(1.0);
    let direct = (1.0 - 0.5 * s_i) * (1.0 - 0.5 * s_o);
    let retro = r * (s_o + s_i + s_o * s_i * (r - 1.0));
    let along = (1.0 + s_i * (0.5 * r - 1.0)) * (1.0 + s_o * (0.5 * r - 1.0));
    // Bounded where both directions graze, for the sake of finite numbers.
    let below = 1.25 * (along * (1.0 / (wi.z + wo.z).max(1e-4) - 0.5) + 0.5);
    lobe.reflectance * (float::lerp(direct + retro, below, flatness) * FRAC_1_PI).max(0.0)
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    diffuse::pdf(lobe, wi, wo)
}

/// A cosine-distributed direction.
#[inline]
pub fn sample(lobe: &Lobe, wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    diffuse::sample_value(lobe, wi, u1, u2, |wo| eval(lobe, wi, wo))
}
