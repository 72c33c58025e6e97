//! The reflection of the modified Phong model: a power of the cosine to the mirror direction.
//!
//! Lafortune and Willems 1994, "Using the Modified Phong Reflectance Model for Physically Based Rendering": with a the
//! angle between wo and the mirror image of wi, and the exponent n,
//!
//!   f = rho_s (n + 2) / (2 pi) cos^n(a).
//!
//! The model's diffuse part is a lobe of its own. Directions are drawn from the power itself, p = (n + 1) / (2 pi) cos^n(a);
//! those below the horizon are lost, so that the albedo falls towards grazing angles. `exponent` is clamped to
//! [0, [`MAX_EXPONENT`]]. Invariants (tests): reciprocity, an albedo of rho_s at most, the published values.

use super::{BsdfSample, Lobe, event, sample_reflection};
use crate::math::{Frame, Rgb, float};
use core::f32::consts::TAU;
use glam::{Vec2, Vec3};

/// Largest exponent: single precision resolves no narrower lobe.
pub const MAX_EXPONENT: f32 = 1e5;

/// The exponent in its domain.
#[inline]
fn exponent(lobe: &Lobe) -> f32 {
    lobe.exponent.max(0.0).min(MAX_EXPONENT)
}

/// Cosine of the angle between `wo` and the mirror image of `wi`.
#[inline]
fn cos_to_mirror(wi: Vec3, wo: Vec3) -> f32 {
    (wi.z * wo.z - wi.x * wo.x - wi.y * wo.y).min(1.0)
}

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    let cos = cos_to_mirror(wi, wo);
    if wi.z <= 0.0 || wo.z <= 0.0 || cos <= 0.0 {
        return Vec3::ZERO;
    }
    let n = exponent(lobe);
    lobe.specular_reflectance * ((n + 2.0) / TAU * float::pow(cos, n))
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    let cos = cos_to_mirror(wi, wo);
    if wi.z <= 0.0 || wo.z <= 0.0 || cos <= 0.0 {
        return 0.0;
    }
    let n = exponent(lobe);
    (n + 1.0) / TAU * float::pow(cos, n)
}

/// A direction about the mirror image of `wi`; `u1` is not used.
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
    let cos = float::pow(u2.x, 1.0 / (exponent(lobe) + 1.0));
    let sin = float::safe_sqrt(1.0 - cos * cos);
    let (sin_phi, cos_phi) = float::sin_cos(TAU * u2.y);
    let mirror = Frame::from_normal(Vec3::new(-wi.x, -wi.y, wi.z));
    let wo = mirror.to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos));
    BsdfSample::towards(wo.normalize(), event::REFLECTION | event::GLOSSY)
}
