//! Beckmann: Gaussian slopes, `D(m) = exp(-(x^2/ax^2 + y^2/ay^2)/z^2) / (pi ax ay z^4)`.
//!
//! Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", equation 25; masking is the exact
//! expression with the error function (Heitz 2014, equation 66), not the rational fit that many renderers use, whose
//! error is up to 0.4 %: the fit breaks the identity of the projected area by as much, and with it the density of
//! visible normals. The callers in [`super`] clamp `alpha`, check sides, and stretch to unit roughness.

use crate::math::float::{
    abs, erf_inv, erfc_scaled, exp, ln, ln_1p, safe_sqrt, sin_cos_2pi, sqr, sqrt,
};
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

/// `1 / sqrt(pi)`.
const FRAC_1_SQRT_PI: f32 = 0.564_189_6;

/// `D(m)` for `m.z > 0`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn distribution(alpha: Vec2, m: Vec3) -> f32 {
    let z2 = m.z * m.z;
    // Squared slope over alpha squared; beyond 80 the exponential is zero next to any other normal.
    let t = sqr(m.x / alpha.x) + sqr(m.y / alpha.y);
    let density = exp(-t / z2) / (PI * alpha.x * alpha.y * z2 * z2);
    if t >= 80.0 * z2 { 0.0 } else { density }
}

/// Projected area for a cosine and `spread = alpha sin(theta)`: `cos (1 + Lambda)`, which with `a = cos / spread` is
/// `(cos (1 + erf(a)) + spread exp(-a^2) / sqrt(pi)) / 2`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn projected_area(cos: f32, spread: f32) -> f32 {
    // From a = 4 on the second term and the complement of erf are below a rounding error.
    let area = visible_area_below(cos / spread, cos, spread);
    if cos >= 4.0 * spread { cos } else { area }
}

/// Area, projected along a direction in the x-z plane with the given cosine and sine, of the microfacets of unit
/// roughness whose slope against that direction is below `x`; `x` is at most `cos / sin`. Relative precision holds far
/// into the tail of negative `x`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn visible_area_below(x: f32, cos: f32, sin: f32) -> f32 {
    let e = exp(-x * x);
    let tail = 0.5 * cos * e * erfc_scaled(abs(x));
    let gaussian = 0.5 * FRAC_1_SQRT_PI * sin * e;
    if x < 0.0 {
        tail + gaussian
    } else {
        cos - tail + gaussian
    }
}

/// A normal of unit roughness, not normalised, visible from the unit vector `w`, `w.z >= 0`.
///
/// Along the azimuth of `w` the slope `x` has density `(cos - sin x) exp(-x^2)` on `x < cos / sin`, across it the
/// slope is Gaussian (Heitz and d'Eon 2014, appendix A.2). The first is inverted by Newton's method on the
/// logarithm of the cumulative distribution: that is concave, because the density is log-concave, so from the left of
/// the solution the iteration rises towards it, and a step from the right lands on the left.
#[inline]
pub fn sample_visible_normal(w: Vec3, u: Vec2) -> Vec3 {
    let mut slope = VisibleSlope::new(w, u);
    for _ in 0..VisibleSlope::STEPS {
        if !slope.step() {
            break;
        }
    }
    slope.normal(w)
}

/// The state of the iteration for the quantile of the visible slope along the azimuth of a direction.
#[derive(Clone, Copy, Debug)]
pub struct VisibleSlope {
    /// Cosine and sine of the direction.
    pub cos: f32,
    /// See `cos`.
    pub sin: f32,
    /// No quantile is to the left of it.
    pub start: f32,
    /// Nor to the right of it.
    pub end: f32,
    /// The visible area below the solution.
    pub target: f32,
    /// The slope so far.
    pub along: f32,
    /// The slope across the azimuth.
    pub across: f32,
}

impl VisibleSlope {
    /// The most steps that are taken.
    pub const STEPS: u32 = 10;

    /// Where the search for the slope begins that is visible from the unit vector `w`, `w.z >= 0`.
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn new(w: Vec3, u: Vec2) -> VisibleSlope {
        let sin = safe_sqrt(w.x * w.x + w.y * w.y);
        let cos = w.z;
        let across = erf_inv(2.0 * u.y - 1.0);
        // The quantile of the limit at normal incidence.
        let gaussian = erf_inv(2.0 * u.x - 1.0);
        let u = u.x.max(1e-9).min(0.999_999_94);
        // Beyond 4 the cumulative distribution does not change in f32.
        let end = (cos / sin).min(4.0);
        // The quantile at grazing incidence. The family is ordered in the cotangent: no quantile is to the left of it.
        let start = -sqrt(-ln(u));
        let is_normal = sin < 1e-7;
        VisibleSlope {
            cos,
            sin,
            start,
            end,
            target: u * visible_area_below(end, cos, sin),
            along: if is_normal {
                gaussian
            } else {
                start + cos * (gaussian.min(end) - start)
            },
            across,
        }
    }

    /// One step; whether another would change the slope.
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn step(&mut self) -> bool {
        let x = self.along;
        let area = visible_area_below(x, self.cos, self.sin);
        let density = FRAC_1_SQRT_PI * (self.cos - self.sin * x) * exp(-x * x);
        // At normal incidence the start is the solution.
        if density <= 0.0 || self.sin < 1e-7 {
            return false;
        }
        let step = ln(self.target / area) * area / density;
        self.along = (x + step).max(self.start).min(self.end);
        // Newton's method squares the error: the next one would be below a rounding error.
        abs(step) >= 1e-4
    }

    /// The normal of unit roughness, not normalised.
    #[inline]
    pub fn normal(&self, w: Vec3) -> Vec3 {
        if self.sin < 1e-7 {
            return Vec3::new(-self.along, -self.across, 1.0);
        }
        let (c, s) = (w.x / self.sin, w.y / self.sin);
        let (along, across) = (self.along, self.across);
        Vec3::new(-(c * along - s * across), -(s * along + c * across), 1.0)
    }
}

/// A slope with density `exp(-s^2) / pi`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample_slope(u: Vec2) -> Vec2 {
    let (sin_phi, cos_phi) = sin_cos_2pi(u.x);
    let r = sqrt(-ln_1p(-u.y.min(0.999_999_94)));
    Vec2::new(r * cos_phi, r * sin_phi)
}
