//! The Gaussian in slope space: steps of half vectors in the plane at distance one above the tangent plane.
//!
//! A Beckmann lobe of roughness alpha is a Gaussian of variance alpha^2 / 2 per axis there, and the domain has no border. The
//! Gaussian has its own axes and two standard deviations:
//!
//! `p(h) = exp(-(d_0^2 / s_0^2 + d_1^2 / s_1^2) / 2) / (2 pi s_0 s_1)`, `d = R^T (h - center)`.
//!
//! Samples by Box and Muller 1958. An axis whose deviation is below [`NARROWEST`] does not move: it is fixed, and the density
//! is that of the others (a perfectly specular vertex has two such axes, and density one by convention). Checked: integrates
//! to one, chi-square of samples.

use super::disk_lobe::{rotate, rotate_back};
use crate::math::float::{exp, ln_1p, safe_sqrt, sin_cos_2pi};
use glam::Vec2;

/// Deviations below are none.
pub const NARROWEST: f32 = 1e-7;

/// A Gaussian on the slope plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeGaussian {
    /// Mean.
    pub center: Vec2,
    /// Unit direction of the first deviation; the second is a quarter turn further.
    pub axis: Vec2,
    /// Standard deviations along both axes.
    pub deviation: Vec2,
}

impl SlopeGaussian {
    /// A sample for `u` in [0, 1)^2.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Vec2 {
        let r = safe_sqrt(-2.0 * ln_1p(-u.x.min(0.999_999_94)));
        let (s, c) = sin_cos_2pi(u.y);
        self.center
            + rotate(
                self.axis,
                Vec2::new(
                    r * c * deviation(self.deviation.x),
                    r * s * deviation(self.deviation.y),
                ),
            )
    }

    /// Density per area of the slope plane, along the axes that move.
    #[inline]
    pub fn pdf_slope(&self, h: Vec2) -> f32 {
        let d = rotate_back(self.axis, h - self.center);
        let p = normal(d.x, self.deviation.x) * normal(d.y, self.deviation.y);
        if p <= f32::MAX { p } else { 0.0 }
    }
}

/// The deviation, zero for an axis that does not move.
#[inline]
fn deviation(s: f32) -> f32 {
    if s > NARROWEST { s } else { 0.0 }
}

/// The one-dimensional density; one for an axis that does not move.
#[inline]
fn normal(d: f32, s: f32) -> f32 {
    if !(s > NARROWEST) {
        return 1.0;
    }
    let t = d / s;
    exp(-0.5 * t * t) * (0.398_942_28 / s)
}
