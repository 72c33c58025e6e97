//! The clear coat of the principled model: a second highlight with a long tail.
//!
//! Burley 2012, "Physically-Based Shading at Disney", section 5.6 and appendix B: normals follow the generalised
//! Trowbridge-Reitz distribution of exponent 1, with the width a,
//!
//!   D(h) = (a^2 - 1) / (pi ln(a^2) (1 + (a^2 - 1) cos^2(theta_h))),   f = c / 4 F(wi . h) D(h) G(wi) G(wo),
//!
//! F Schlick's approximation from 0.04, and G Smith's masking of GGX with a width of 0.25. As in the appendix, there is no
//! further 1 / (4 cos cos): G stands for both. c is in `specular_reflectance`, a in `alpha.x`, between [`SMALLEST`] and [`LARGEST`]. Half
//! vectors are drawn from D(h) cos(theta_h). Invariants (tests): reciprocity, values of an independent renderer.

use super::coat_reflection::half_vector;
use super::fresnel::reflect;
use super::principled_diffuse::schlick_weight;
use super::{BsdfSample, Lobe, event, sample_reflection};
use crate::math::{Rgb, float};
use core::f32::consts::{PI, TAU};
use glam::{Vec2, Vec3};

/// Width at the highest gloss.
pub const SMALLEST: f32 = 0.001;
/// Width without gloss.
pub const LARGEST: f32 = 0.1;
/// Reflectance at normal incidence.
const NORMAL_REFLECTANCE: f32 = 0.04;
/// Width of the masking.
const MASKING_WIDTH: f32 = 0.25;

/// The width of a gloss in [0, 1], which a record has as its `exponent` (Burley 2012, section 5.6: linear in between).
#[inline]
pub fn width(gloss: f32) -> f32 {
    LARGEST + (SMALLEST - LARGEST) * gloss.max(0.0).min(1.0)
}

/// Square of the width.
#[inline]
fn width_squared(lobe: &Lobe) -> f32 {
    float::sqr(lobe.alpha.x.max(SMALLEST).min(LARGEST))
}

/// The distribution of half vectors above the horizon.
#[inline]
fn distribution(lobe: &Lobe, h: Vec3) -> f32 {
    let a2 = width_squared(lobe);
    // 1 + (a^2 - 1) cos^2 without the cancellation near the pole.
    let denominator = h.x * h.x + h.y * h.y + a2 * h.z * h.z;
    (a2 - 1.0) / (PI * float::ln(a2) * denominator)
}

/// Smith's masking of GGX, over both hemispheres the same.
#[inline]
fn masking(w: Vec3) -> f32 {
    let a2 = MASKING_WIDTH * MASKING_WIDTH;
    let cos2 = w.z * w.z;
    2.0 * w.z / (w.z + float::sqrt(cos2 + a2 * (1.0 - cos2).max(0.0)))
}

/// What is reflected at an incident cosine at most: Schlick's approximation.
#[inline]
pub fn fresnel(cos: f32) -> f32 {
    float::lerp(NORMAL_REFLECTANCE, 1.0, schlick_weight(cos))
}

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    let h = half_vector(wi, wo);
    let cos_h = wi.dot(h);
    if wi.z <= 0.0 || wo.z <= 0.0 || cos_h <= 0.0 {
        return Vec3::ZERO;
    }
    let value = 0.25 * fresnel(cos_h) * distribution(lobe, h) * masking(wi) * masking(wo);
    lobe.specular_reflectance * value
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    let h = half_vector(wi, wo);
    let cos_h = wi.dot(h);
    if wi.z <= 0.0 || wo.z <= 0.0 || cos_h <= 0.0 {
        return 0.0;
    }
    // Jacobian of the reflection at h: d omega_h / d omega_o = 1 / (4 wi . h).
    distribution(lobe, h) * h.z / (4.0 * cos_h)
}

/// The mirror image of `wi` at a half vector of the distribution; `u1` is not used.
#[inline]
pub fn sample(lobe: &Lobe, wi: Vec3, _u1: f32, u2: Vec2) -> BsdfSample {
    sample_reflection(
        wi,
        || direction(lobe, wi, u2),
        |wo| (eval(lobe, wi, wo), pdf(lobe, wi, wo)),
    )
}

/// The direction of [`sample`], which may lie below the horizon.
#[inline]
pub(super) fn direction(lobe: &Lobe, wi: Vec3, u2: Vec2) -> BsdfSample {
    // Inversion of the cumulative distribution: sin^2 = (a^(2 (1 - u)) - a^2) / (1 - a^2).
    let a2 = width_squared(lobe);
    let sin2 = ((float::pow(a2, 1.0 - u2.x) - a2) / (1.0 - a2))
        .max(0.0)
        .min(1.0);
    let sin = float::sqrt(sin2);
    let (sin_phi, cos_phi) = float::sin_cos(TAU * u2.y);
    let h = Vec3::new(sin * cos_phi, sin * sin_phi, float::safe_sqrt(1.0 - sin2));
    BsdfSample::towards(
        reflect(wi, h).normalize(),
        event::REFLECTION | event::GLOSSY,
    )
}
