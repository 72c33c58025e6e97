//! The anisotropic Phong lobe on the unit disk, moved anywhere by a Moebius transformation.
//!
//! Around the origin, with exponents `k_u`, `k_v` along the axes (Ashikhmin and Shirley 2000, "An Anisotropic Phong BRDF
//! Model"; projected onto the disk):
//!
//! `p(z) = sqrt((k_u + 1)(k_v + 1)) / (2 pi) (1 - |z|^2)^((k_u cos^2 phi + k_v sin^2 phi - 1) / 2)`,
//!
//! per area of the disk. Its map from the square: `tan phi = sqrt((k_u + 1) / (k_v + 1)) tan(2 pi u_0)` in the quadrant of
//! `2 pi u_0`, `cos theta = u_1^(1 / (k_u cos^2 phi + k_v sin^2 phi + 1))`, `z = sin theta e^(i phi)`. A lobe around `a` is
//! `M_a` of that, rotated so that its axes have the given orientation ([`DiskLobe::axis`]).
//!
//! An isotropic lobe has a variance of exactly `1 / (k + 3)` per axis in the disk, hence [`exponent_of_deviation`]. In slope
//! units that is a Gaussian's for narrow lobes (2 % off at k = 10). Checked: integrates to one around any pivot, chi-square
//! of samples, the variance, the symmetry `p(a -> b) / p(b -> a) = ((1 - |a|^2) / (1 - |b|^2))^2` of isotropic lobes.

use crate::math::float::{abs, exp_m1, ln_1p, pow, safe_sqrt, sin_cos_2pi, sqrt};
use crate::math::moebius::{clamp_pivot, moebius, moebius_jacobian};
use core::f32::consts::FRAC_1_PI;
use glam::Vec2;

/// A lobe on the unit disk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskLobe {
    /// Centre.
    pub center: Vec2,
    /// Unit direction of the first exponent; the second is a quarter turn further.
    pub axis: Vec2,
    /// Exponents along both axes, at least zero.
    pub exponent: Vec2,
}

/// The exponent whose isotropic lobe has the standard deviation `deviation` per axis of the disk; zero, the broadest,
/// from 1 / sqrt(3) on.
#[inline]
pub fn exponent_of_deviation(deviation: f32) -> f32 {
    const NARROWEST: f32 = 1e-6;
    let s = if deviation > NARROWEST {
        deviation
    } else {
        NARROWEST
    };
    (1.0 / (s * s) - 3.0).max(0.0)
}

/// `v` turned by the angle of the unit vector `r`.
#[inline]
pub fn rotate(r: Vec2, v: Vec2) -> Vec2 {
    Vec2::new(r.x * v.x - r.y * v.y, r.y * v.x + r.x * v.y)
}

/// `v` turned back.
#[inline]
pub fn rotate_back(r: Vec2, v: Vec2) -> Vec2 {
    Vec2::new(r.x * v.x + r.y * v.y, r.x * v.y - r.y * v.x)
}

impl DiskLobe {
    /// A point of the lobe for `u` in [0, 1)^2.
    #[inline]
    pub fn sample(&self, u: Vec2) -> Vec2 {
        let k = self.exponent.max(Vec2::ZERO);
        // The direction (cos, sin) of an angle whose tangent is stretched, without a quadrant to correct.
        let (s, c) = sin_cos_2pi(u.x);
        let d = Vec2::new(c * sqrt(k.y + 1.0), s * sqrt(k.x + 1.0));
        let d = d * (1.0 / safe_sqrt(d.length_squared()).max(f32::MIN_POSITIVE));
        let k = k.x * d.x * d.x + k.y * d.y * d.y;
        // 1 - cos_theta, which the power itself rounds to multiples of 6e-8; 1 - u keeps it away from zero.
        let height = -exp_m1(ln_1p(-u.y) / (k + 1.0));
        let z = d * safe_sqrt(height * (2.0 - height));
        moebius(self.center, rotate(self.axis, z))
    }

    /// Density of [`DiskLobe::sample`] per area of the disk; zero outside. At the rim, where lobes with an exponent below
    /// one have a pole, it is capped.
    #[inline]
    pub fn pdf_disk(&self, w: Vec2) -> f32 {
        let r2 = w.length_squared();
        if !(r2 < 1.0) {
            return 0.0;
        }
        let center = clamp_pivot(self.center);
        let z = rotate_back(self.axis, moebius(center, w));
        let z2 = z.length_squared();
        let k = self.exponent.max(Vec2::ZERO);
        let along = if z2 > 0.0 {
            (k.x * z.x * z.x + k.y * z.y * z.y) / z2
        } else {
            k.x
        };
        // 1 - |z|^2 = (1 - |a|^2)(1 - |w|^2) / |1 - conj(a) w|^2 does not cancel near the rim.
        let jacobian = moebius_jacobian(center, w);
        let height2 = ((1.0 - r2) * sqrt(jacobian)).max(1e-12).min(1.0);
        let peak = sqrt((k.x + 1.0) * (k.y + 1.0)) * (0.5 * FRAC_1_PI);
        let p = peak * pow(height2, 0.5 * (along - 1.0)) * jacobian;
        if abs(p) <= f32::MAX { p } else { 0.0 }
    }
}
