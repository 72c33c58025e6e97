//! Rough diffuse reflection: V-shaped grooves of Lambertian facets.
//!
//! Oren and Nayar 1994, "Generalization of Lambert's Reflectance Model", the full fit (equations 27 to 30), not the
//! two-term one: with theta_r >= theta_i the larger and the smaller polar angle, phi the azimuth between the directions,
//!
//! - direct light `rho / pi [C1 + cos(phi) C2 tan(theta_i) + (1 - |cos(phi)|) C3 tan((theta_i + theta_r) / 2)]`,
//! - one interreflection `0.17 rho^2 / pi sigma^2 / (sigma^2 + 0.13) (1 - cos(phi) (2 theta_i / pi)^2)`.
//!
//! sigma, the standard deviation of the grooves' slope angle, is `alpha / sqrt(2)`, so that `alpha` compares with the
//! microfacet roughnesses; domain [0, 1], beyond it is clamped. `alpha = 0` is Lambert exactly. Directions are sampled
//! with the cosine. Invariants (tests): symmetry; Lambert at zero; values of an independent renderer. The fit is not exactly
//! conservative: white grooves return up to 1.042 of the light (tested).

use super::{BsdfSample, Lobe, diffuse};
use crate::math::Rgb;
use crate::math::float::{abs, atan2, safe_sqrt, sqr};
use core::f32::consts::{FRAC_1_PI, PI};
use glam::{Vec2, Vec3};

/// The BSDF, without a cosine.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    let alpha = lobe.alpha.x.max(0.0).min(1.0);
    let sigma2 = 0.5 * alpha * alpha;
    if sigma2 <= 0.0 {
        return lobe.reflectance * FRAC_1_PI;
    }
    let (sin_i, sin_o) = (sin_theta(wi), sin_theta(wo));
    let cos_phi = if sin_i * sin_o > 0.0 {
        ((wi.x * wo.x + wi.y * wo.y) / (sin_i * sin_o))
            .max(-1.0)
            .min(1.0)
    } else {
        0.0
    };
    let (theta_i, theta_o) = (atan2(sin_i, wi.z), atan2(sin_o, wo.z));
    let (larger, smaller) = if theta_i > theta_o {
        (theta_i, theta_o)
    } else {
        (theta_o, theta_i)
    };
    let sin_larger = sin_i.max(sin_o);
    let (tan_smaller, cos_larger) = if theta_i > theta_o {
        (sin_o / wo.z, wi.z)
    } else {
        (sin_i / wi.z, wo.z)
    };

    let c1 = 1.0 - 0.5 * sigma2 / (sigma2 + 0.33);
    let b = 2.0 * FRAC_1_PI * smaller;
    let groove = if cos_phi >= 0.0 {
        sin_larger
    } else {
        sin_larger - b * b * b
    };
    let c2 = 0.45 * sigma2 / (sigma2 + 0.09) * groove;
    let c3 = 0.125 * sigma2 / (sigma2 + 0.09) * sqr(4.0 * FRAC_1_PI * FRAC_1_PI * larger * smaller);
    // tan of the mean angle, by half angles: (sin a + sin b) / (cos a + cos b).
    let cos_smaller = if theta_i > theta_o { wo.z } else { wi.z };
    let tan_mean = (sin_i + sin_o) / (cos_larger + cos_smaller).max(1e-6);
    // tan of the smaller angle grows without bound only where both directions graze.
    let tan_smaller = tan_smaller.min(1e6);
    let direct = c1 + cos_phi * c2 * tan_smaller + (1.0 - abs(cos_phi)) * c3 * tan_mean;
    let again = 0.17 * sigma2 / (sigma2 + 0.13) * (1.0 - cos_phi * b * b);
    let f = lobe.reflectance * direct + lobe.reflectance * lobe.reflectance * again;
    (f * FRAC_1_PI).max(Vec3::ZERO)
}

/// Density of [`sample`] per solid angle.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    diffuse::pdf(lobe, wi, wo)
}

/// A cosine-distributed direction.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample(lobe: &Lobe, wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    let mut s = diffuse::sample(lobe, wi, u1, u2);
    if s.pdf > 0.0 {
        s.weight = eval(lobe, wi, s.wo) * PI;
    }
    s
}

/// Sine of the polar angle.
#[inline]
fn sin_theta(w: Vec3) -> f32 {
    safe_sqrt(w.x * w.x + w.y * w.y)
}
