//! Phong: a power of the cosine, `D(m) = (n + 2) / (2 pi) m.z^n`, `n = 2 / alpha^2 - 2`.
//!
//! Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", equation 30, with their conversion of
//! the exponent, by which `D` at the pole equals Beckmann's. Anisotropic as in Ashikhmin and Shirley 2000, "An
//! Anisotropic Phong BRDF Model": `D(m) = sqrt((n_x + 2) (n_y + 2)) / (2 pi) m.z^n`, `n` the mean of `n_x` and `n_y`
//! weighted by the squared cosine and sine of the azimuth of `m`.
//!
//! Smith's projected area has no closed form here; Walter et al. put Beckmann's of the same `alpha` instead, and so
//! does every renderer. At alpha 1 the true projected area at grazing directions is 1.77 times Beckmann's, so that rough
//! Phong surfaces gain energy at grazing angles: a white furnace returns at most 1.003 at alpha 0.3, 1.07 at 0.5 and 1.35
//! at 1 (tested). The values agree with other renderers; where energy must be conserved, take another distribution.
//! `alpha` is at most 1: beyond, the density grows towards the horizon without bound.

use crate::math::float::{exp, ln, ln_1p, safe_sqrt, sin_cos_2pi, sqrt};
use crate::math::frame::upper_unit_vector;
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

/// `n + 2` of a width.
#[inline]
fn exponent_plus_two(alpha: f32) -> f32 {
    let alpha = alpha.min(1.0);
    2.0 / (alpha * alpha)
}

/// `n + 2` along the azimuth of `(x, y)`.
#[inline]
fn exponent_along(alpha: Vec2, x: f32, y: f32) -> f32 {
    let (nx, ny) = (exponent_plus_two(alpha.x), exponent_plus_two(alpha.y));
    let across = x * x + y * y;
    if across > 0.0 {
        (nx * x * x + ny * y * y) / across
    } else {
        0.5 * (nx + ny)
    }
}

/// `D(m)` for `m.z > 0`.
#[inline]
pub fn distribution(alpha: Vec2, m: Vec3) -> f32 {
    let (nx, ny) = (exponent_plus_two(alpha.x), exponent_plus_two(alpha.y));
    let n = exponent_along(alpha, m.x, m.y) - 2.0;
    // ln m.z from the sine near the pole, where rounding of m.z would be raised to n.
    let across = m.x * m.x + m.y * m.y;
    let ln_z = if across < 0.25 {
        0.5 * ln_1m(across)
    } else {
        ln(m.z)
    };
    let e = n * ln_z;
    if e < -80.0 {
        return 0.0;
    }
    sqrt(nx * ny) / (2.0 * PI) * exp(e)
}

/// `ln(1 - x)` for `x` in [0, 0.25], to a relative 1e-6.
#[inline]
fn ln_1m(x: f32) -> f32 {
    // 2 atanh(q), q = -x / (2 - x), |q| < 0.143.
    let q = -x / (2.0 - x);
    let q2 = q * q;
    2.0 * q * (1.0 + q2 * (1.0 / 3.0 + q2 * (0.2 + q2 * (1.0 / 7.0))))
}

/// The slope at the quantile `u` for `n + 2`.
#[inline]
fn slope_of(n_plus_two: f32, u: f32) -> f32 {
    // q = 1 - u, cos = q^(1 / (n + 2)), tan^2 = cos^-2 - 1, both by the logarithm of q.
    let x = -2.0 * ln_1p(-u.min(0.999_999_94)) / n_plus_two;
    // exp(x) - 1 without cancellation for narrow lobes.
    let tan2 = if x < 0.05 {
        x * (1.0 + x * (0.5 + x * (1.0 / 6.0 + x * (1.0 / 24.0))))
    } else {
        exp(x) - 1.0
    };
    safe_sqrt(tan2)
}

/// The slope at the quantile `u` of an isotropic distribution.
#[inline]
pub fn sample_radius(alpha: f32, u: f32) -> f32 {
    slope_of(exponent_plus_two(alpha), u)
}

/// A normal with density `D(m) m.z`.
#[inline]
pub fn sample_normal(alpha: Vec2, u: Vec2) -> Vec3 {
    let (nx, ny) = (exponent_plus_two(alpha.x), exponent_plus_two(alpha.y));
    let (s, c) = sin_cos_2pi(u.x);
    // tan(phi) = sqrt(nx / ny) tan(2 pi u), in the quadrant of the angle.
    let (x, y) = (sqrt(ny) * c, sqrt(nx) * s);
    let scale = 1.0 / safe_sqrt(x * x + y * y);
    let t = slope_of(exponent_along(alpha, x, y), u.y);
    upper_unit_vector(x * scale * t, y * scale * t, 1.0)
}

/// `-2 t / (d ln P / dt)` for the slope density `P ~ (1 + t^2)^(-(n + 4) / 2)`: `2 (1 + t^2) / (n + 4)`; `inverse` is
/// `1 / alpha^2` along the azimuth.
#[inline]
pub fn local_alpha_squared(inverse: f32, t2: f32) -> f32 {
    (1.0 + t2) / (inverse.max(1.0) + 1.0)
}
