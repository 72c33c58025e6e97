//! Lambertian reflection.
//!
//! f = rho / pi for both directions above the surface, zero elsewhere (Lambert 1760). Sampled with the cosine-weighted
//! hemisphere, p = cos / pi per solid angle, so that the sample's weight is rho itself. Invariant: the integral of
//! f cos over the hemisphere is rho for every wi (furnace test), and f is symmetric.

use super::{BsdfSample, Lobe, event};
use crate::math::{Rgb, warp};
use core::f32::consts::{FRAC_1_PI, PI};
use glam::{Vec2, Vec3};

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    lobe.reflectance * FRAC_1_PI
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(_lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return 0.0;
    }
    wo.z * FRAC_1_PI
}

/// A cosine-distributed direction.
#[inline]
pub fn sample(lobe: &Lobe, wi: Vec3, _u1: f32, u2: Vec2) -> BsdfSample {
    if wi.z <= 0.0 {
        return BsdfSample::NONE;
    }
    let wo = warp::square_to_cosine_hemisphere(u2);
    BsdfSample {
        wo,
        weight: lobe.reflectance,
        // Rounding may put wo on the horizon: density zero says that there is no sample.
        pdf: pdf(lobe, wi, wo),
        eta: 1.0,
        event: event::REFLECTION | event::DIFFUSE,
    }
}

/// [`sample`] for a model that draws its directions from the same density and has the BSDF `eval` there.
#[inline]
pub fn sample_value(
    lobe: &Lobe,
    wi: Vec3,
    u1: f32,
    u2: Vec2,
    eval: impl FnOnce(Vec3) -> Rgb,
) -> BsdfSample {
    let mut s = sample(lobe, wi, u1, u2);
    if s.pdf > 0.0 {
        s.weight = eval(s.wo) * PI;
    }
    s
}
