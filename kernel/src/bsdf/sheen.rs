//! The sheen of the principled model: light that grazes the fibres of cloth.
//!
//! Burley 2012, "Physically-Based Shading at Disney", section 5.7: `f = s S(wo . h) lerp(1, rho / Y(rho), t)` with Schlick's
//! weight S(c) = (1 - c)^5, the half vector h and the luminance Y. s is in `specular_reflectance`, rho in `reflectance`, the tint t
//! in `exponent`. Sampled with the cosine. Invariant (tests): reciprocity, values of an independent renderer.

use super::coat_reflection::half_vector;
use super::principled_diffuse::schlick_weight;
use super::{BsdfSample, Lobe, diffuse};
use crate::math::{Rgb, luminance};
use glam::{Vec2, Vec3};

/// The hue of a colour: the colour over its luminance, white for black.
#[inline]
pub fn hue(color: Rgb) -> Rgb {
    let y = luminance(color);
    if y > 1e-6 { color / y } else { Vec3::ONE }
}

/// The colour of the sheen.
#[inline]
pub fn color(lobe: &Lobe) -> Rgb {
    let tint = lobe.exponent.max(0.0).min(1.0);
    lobe.specular_reflectance * Vec3::ONE.lerp(hue(lobe.reflectance), tint)
}

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    color(lobe) * schlick_weight(wo.dot(half_vector(wi, wo)))
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
