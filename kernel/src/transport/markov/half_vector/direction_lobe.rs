//! The von Mises-Fisher lobe by which manifold exploration perturbs directions, and the Gaussian of film positions.

use crate::math::Frame;
use crate::math::float::{exp_m1, ln, ln_1p, sin_cos_2pi, sqrt};
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

/// A von Mises-Fisher lobe around a direction.
#[derive(Clone, Copy, Debug)]
pub struct DirectionLobe {
    /// Concentration.
    pub kappa: f32,
}

impl DirectionLobe {
    /// With the peak lambda^2 times the density of the direction.
    pub(super) fn new(pdf: f32, lambda: f32) -> DirectionLobe {
        let pdf = pdf.max(0.25 / PI).min(1e8);
        DirectionLobe {
            kappa: (2.0 * PI * pdf * lambda * lambda).max(1.0),
        }
    }

    /// A direction near another.
    pub fn sample(&self, direction: Vec3, u: Vec2) -> Vec3 {
        // 1 - cos, which the cosine itself would round.
        let height = -ln_1p(u.x * exp_m1(-2.0 * self.kappa)) / self.kappa;
        let sin = sqrt((height * (2.0 - height)).max(0.0));
        let (s, c) = sin_cos_2pi(u.y);
        Frame::from_normal(direction)
            .to_world(Vec3::new(sin * c, sin * s, 1.0 - height))
            .normalize()
    }

    /// Logarithm of the density per solid angle.
    pub fn ln_pdf(&self, from: Vec3, to: Vec3) -> f32 {
        let height = 0.5 * (to - from).length_squared();
        ln(self.kappa / (2.0 * PI * -exp_m1(-2.0 * self.kappa))) - self.kappa * height
    }
}

/// A point of the normal distribution in two dimensions.
pub fn gaussian(u: Vec2) -> Vec2 {
    let r = sqrt(-2.0 * ln_1p(-u.x.min(0.999_999_94)));
    let (s, c) = sin_cos_2pi(u.y);
    Vec2::new(r * c, r * s)
}
