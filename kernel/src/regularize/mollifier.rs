//! Mollifiers: compact kernels of unit mass that replace a delta distribution.
//!
//! `phi_r(x) = K(|x| / r) / r^d` for a bandwidth `r` in `d` dimensions tends to the delta as r -> 0 (Kaplanyan 2017,
//! thesis, equation 6.1; Hegland and Anderssen 1996). K is radial, zero from distance 1 on, of mass one:
//!
//! | kind | K(t) up to its constant | constants for d = 1, 2, 3 |
//! |---|---|---|
//! | [`CONSTANT`] | 1 | 1/2, 1/pi, 3/(4 pi) |
//! | [`PARABOLIC`] (Epanechnikov) | 1 - t^2 | 3/4, 2/pi, 15/(8 pi) |
//! | [`QUARTIC`] (biweight) | (1 - t^2)^2 | 15/16, 3/pi, 105/(32 pi) |
//! | [`PERLIN`] | 1 - 10 t^3 + 15 t^4 - 6 t^5 | 1, 7/(2 pi), 21/(5 pi) |
//!
//! The error of a mollified integral is governed by two numbers: the bias by the second moment per axis, `bias = r^2 /
//! 2 * second_moment * laplacian`, the variance by the square norm, `variance = g(0)^2 ... square_norm / r^d` (thesis,
//! proof of lemma 1). Domain: t >= 0, d in 1..=3 (others are taken as 3). Densities per d-dimensional volume.
//! Invariants (tests): unit mass, moments by quadrature, samples follow the density, smooth kernels vanish at the rim.
//!
//! The thesis normalises Perlin's kernel by `1 / (pi r^2)` (text after equation 5.3), which leaves a mass of 2/7; the
//! kernel here is `7 k(t) / (2 pi r^2)`.

use crate::math::float::{pow, safe_sqrt, sin_cos_2pi, sqrt};
use core::f32::consts::{FRAC_1_PI, PI};
use glam::{Vec2, Vec3};

/// One inside the unit ball.
pub const CONSTANT: u32 = 0;
/// The parabola of Epanechnikov.
pub const PARABOLIC: u32 = 1;
/// The square of the parabola, differentiable at the rim.
pub const QUARTIC: u32 = 2;
/// Perlin's fade curve, twice differentiable.
pub const PERLIN: u32 = 3;

/// Coefficients of the powers 0 to 5 of the distance, before normalisation.
#[inline]
fn coefficients(kind: u32) -> [f32; 6] {
    match kind {
        CONSTANT => [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        PARABOLIC => [1.0, 0.0, -1.0, 0.0, 0.0, 0.0],
        QUARTIC => [1.0, 0.0, -2.0, 0.0, 1.0, 0.0],
        _ => [1.0, 0.0, 0.0, -10.0, 15.0, -6.0],
    }
}

/// The kernel's shape, 1 at the centre and 0 from `t = 1` on, in forms that keep their digits at the rim.
#[inline]
pub fn shape(kind: u32, t: f32) -> f32 {
    if !(t < 1.0) {
        return 0.0;
    }
    let s = (1.0 - t) * (1.0 + t);
    match kind {
        CONSTANT => 1.0,
        PARABOLIC => s,
        QUARTIC => s * s,
        _ => {
            let d = 1.0 - t;
            d * d * d * (1.0 + t * (3.0 + 6.0 * t))
        }
    }
}

/// One over the integral of [`shape`] over the unit ball.
#[inline]
pub fn normalization(kind: u32, dimensions: u32) -> f32 {
    match (kind, dimensions) {
        (CONSTANT, 1) => 0.5,
        (CONSTANT, 2) => FRAC_1_PI,
        (CONSTANT, _) => 0.75 * FRAC_1_PI,
        (PARABOLIC, 1) => 0.75,
        (PARABOLIC, 2) => 2.0 * FRAC_1_PI,
        (PARABOLIC, _) => 1.875 * FRAC_1_PI,
        (QUARTIC, 1) => 0.9375,
        (QUARTIC, 2) => 3.0 * FRAC_1_PI,
        (QUARTIC, _) => 3.28125 * FRAC_1_PI,
        (_, 1) => 1.0,
        (_, 2) => 3.5 * FRAC_1_PI,
        (_, _) => 4.2 * FRAC_1_PI,
    }
}

/// K(t), the kernel of bandwidth 1.
#[inline]
pub fn eval(kind: u32, dimensions: u32, t: f32) -> f32 {
    normalization(kind, dimensions) * shape(kind, t)
}

/// `K(distance / r) / r^d`; zero for a bandwidth that is not positive.
#[inline]
pub fn eval_scaled(kind: u32, dimensions: u32, distance: f32, bandwidth: f32) -> f32 {
    // Below this a volume of three dimensions underflows.
    if !(bandwidth > 1e-12) {
        return 0.0;
    }
    let inverse = 1.0 / bandwidth;
    let per_volume = match dimensions {
        1 => inverse,
        2 => inverse * inverse,
        _ => inverse * inverse * inverse,
    };
    eval(kind, dimensions, distance * inverse) * per_volume
}

/// Surface of the unit sphere in `d` dimensions.
#[inline]
fn sphere_surface(dimensions: u32) -> f32 {
    match dimensions {
        1 => 2.0,
        2 => 2.0 * PI,
        _ => 4.0 * PI,
    }
}

#[inline]
fn clamp_dimensions(dimensions: u32) -> u32 {
    if dimensions == 1 || dimensions == 2 {
        dimensions
    } else {
        3
    }
}

/// `integral of |x|^p K(|x|) dx` over the unit ball; 1 for `p = 0`.
#[inline]
pub fn radial_moment(kind: u32, dimensions: u32, p: u32) -> f32 {
    let d = clamp_dimensions(dimensions);
    let a = coefficients(kind);
    let mut sum = 0.0;
    for j in 0..6 {
        sum += a[j] / (j as u32 + d + p) as f32;
    }
    sphere_surface(d) * normalization(kind, d) * sum
}

/// `integral of x_1^2 K dx`, the second moment along one axis: what belongs to the Laplacian in the bias. The trace
/// over all axes is `radial_moment(kind, d, 2)`.
#[inline]
pub fn second_moment(kind: u32, dimensions: u32) -> f32 {
    let d = clamp_dimensions(dimensions);
    radial_moment(kind, d, 2) / d as f32
}

/// `integral of K^2 dx`: what belongs to the variance.
#[inline]
pub fn square_norm(kind: u32, dimensions: u32) -> f32 {
    // In closed form: the alternating sum of Perlin's coefficients would lose two digits.
    match (kind, dimensions) {
        (CONSTANT, 1) => 0.5,
        (CONSTANT, 2) => FRAC_1_PI,
        (CONSTANT, _) => 0.75 * FRAC_1_PI,
        (PARABOLIC, 1) => 0.6,
        (PARABOLIC, 2) => 4.0 / 3.0 * FRAC_1_PI,
        (PARABOLIC, _) => 15.0 / 14.0 * FRAC_1_PI,
        (QUARTIC, 1) => 5.0 / 7.0,
        (QUARTIC, 2) => 1.8 * FRAC_1_PI,
        (QUARTIC, _) => 35.0 / 22.0 * FRAC_1_PI,
        (_, 1) => 181.0 / 231.0,
        (_, 2) => 287.0 / 132.0 * FRAC_1_PI,
        (_, _) => 1498.0 / 715.0 * FRAC_1_PI,
    }
}

/// Mass within distance `t` of the centre.
#[inline]
pub fn radial_cdf(kind: u32, dimensions: u32, t: f32) -> f32 {
    let d = clamp_dimensions(dimensions);
    let t = t.max(0.0).min(1.0);
    let a = coefficients(kind);
    let mut sum = 0.0;
    let mut j = 6;
    while j > 0 {
        j -= 1;
        sum = sum * t + a[j] / (j as u32 + d) as f32;
    }
    let power = match d {
        1 => t,
        2 => t * t,
        _ => t * t * t,
    };
    (sphere_surface(d) * normalization(kind, d) * sum * power).min(1.0)
}

/// The distance from the centre below which a share `u` of the mass lies.
#[inline]
pub fn sample_radius(kind: u32, dimensions: u32, u: f32) -> f32 {
    let d = clamp_dimensions(dimensions);
    let u = u.max(0.0).min(1.0);
    if kind == CONSTANT {
        return match d {
            1 => u,
            2 => sqrt(u),
            _ => pow(u, 1.0 / 3.0),
        };
    }
    if d == 2 && (kind == PARABOLIC || kind == QUARTIC) {
        // 1 - (1 - t^2)^2 and 1 - (1 - t^2)^3.
        let rest = if kind == PARABOLIC {
            sqrt(1.0 - u)
        } else {
            pow(1.0 - u, 1.0 / 3.0)
        };
        return safe_sqrt(1.0 - rest);
    }
    // Bisection, because the distribution is flat at the rim, then Newton's method inside the bracket.
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..12 {
        let middle = 0.5 * (low + high);
        if radial_cdf(kind, d, middle) < u {
            low = middle;
        } else {
            high = middle;
        }
    }
    let mut t = 0.5 * (low + high);
    for _ in 0..3 {
        let volume = match d {
            1 => 1.0,
            2 => t,
            _ => t * t,
        };
        let density = sphere_surface(d) * volume * eval(kind, d, t);
        if density > 1e-6 {
            t = (t + (u - radial_cdf(kind, d, t)) / density)
                .max(low)
                .min(high);
        }
    }
    t
}

/// A point of the interval [-1, 1] with density K.
#[inline]
pub fn sample_1d(kind: u32, u: f32) -> f32 {
    let t = sample_radius(kind, 1, crate::math::float::abs(2.0 * u - 1.0));
    if u < 0.5 { -t } else { t }
}

/// A point of the unit disk with density K.
#[inline]
pub fn sample_2d(kind: u32, u: Vec2) -> Vec2 {
    let t = sample_radius(kind, 2, u.x);
    let (s, c) = sin_cos_2pi(u.y);
    Vec2::new(t * c, t * s)
}

/// A point of the unit ball with density K.
#[inline]
pub fn sample_3d(kind: u32, u: Vec3) -> Vec3 {
    let w = crate::math::warp::square_to_uniform_sphere(Vec2::new(u.y, u.z));
    w * sample_radius(kind, 3, u.x)
}
