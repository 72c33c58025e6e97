//! Where on a path regularisation is needed: sampler quality and path diffusion.
//!
//! Jendersie and Grosch 2019, section 3.5. rho_k bounds the BSDF at vertex k ([`super::regularized_bsdf::bound`]), d_k
//! is the length of the segment from vertex k to k + 1, per steradian and in scene units.
//!
//! Sampler quality bounds the best connection of the path (equation 17), `q = min_k rho_k rho_{k+1} (d_path / d_k)^2`
//! with d_path the sum of all d_k. If q < tau^2 some connection is as good as any regularised one, and regularisation
//! is switched off (equation 18): tau' = infinity. The smooth variant fades over a range of q, so that no
//! discontinuity shows in animations: `tau' = tau / s((q / tau^2 - a) / (1 - a))`, s the smooth step and a in [0, 1)
//! where it is fully off; a -> 1 is equation 18.
//!
//! Path diffusion is the standard deviation of the direction along the path from the sensor (equations 19 to 21):
//! `tau' = tau / sigma_angle`: blur hides behind a rough surface, and stays away from directly visible mirrors, where
//! sigma is 0 and tau' infinite. Both are capped at [`TAU_MAX`], which means "not regularised".
//!
//! Misprint: equation 20 adds `sigma_angle,k-1 d` to the footprint at vertex k, where equation 21 has put the
//! scattering at vertex k - 1 into sigma_angle,k: each footprint would miss the last scattering before it. A simulated
//! bounce off a rough plane settles it (test): the segment from k - 1 to k spreads by sigma_angle,k.

use super::bandwidth::TAU_MAX;
use crate::math::float::{abs, sqrt};
use core::f32::consts::PI;

/// Largest length or squared length that stays finite in products.
const LARGEST: f32 = 1e18;

/// Sampler quality of a path, gathered segment by segment.
#[derive(Clone, Copy, Debug)]
pub struct SamplerQuality {
    /// `min rho_k rho_{k+1} / d_k^2` so far.
    pub least: f32,
    /// Length so far.
    pub length: f32,
}

impl SamplerQuality {
    /// No segment yet.
    pub const EMPTY: SamplerQuality = SamplerQuality {
        least: f32::MAX,
        length: 0.0,
    };

    /// Adds a segment of length `d` between vertices with the bounds `rho` and `rho_next`.
    #[inline]
    pub fn add(&mut self, rho: f32, rho_next: f32, d: f32) {
        let d = if d > 1e-18 { d } else { 1e-18 };
        // Root by root: the product of the bounds over d^2 overflows for mirrors.
        let root = sqrt(rho.max(0.0).min(TAU_MAX)) * sqrt(rho_next.max(0.0).min(TAU_MAX)) / d;
        let value = if root < LARGEST {
            root * root
        } else {
            f32::MAX
        };
        if value < self.least {
            self.least = value;
        }
        let length = self.length + d;
        self.length = if length < LARGEST { length } else { LARGEST };
    }

    /// q of equation 17.
    #[inline]
    pub fn value(&self) -> f32 {
        if self.length <= 0.0 {
            return f32::MAX;
        }
        let q = sqrt(self.least) * self.length;
        if q < LARGEST { q * q } else { f32::MAX }
    }
}

/// Equation 18: `tau`, or [`TAU_MAX`] where a sampler is good enough.
#[inline]
pub fn quality_threshold(tau: f32, q: f32) -> f32 {
    if relative_quality(tau, q) >= 1.0 {
        tau
    } else {
        TAU_MAX
    }
}

/// The smooth variant of [`quality_threshold`]; `off` in [0, 1) is q / tau^2 below which regularisation is off.
/// Continuous and falling in q.
#[inline]
pub fn smooth_quality_threshold(tau: f32, q: f32, off: f32) -> f32 {
    let off = off.max(0.0).min(0.999);
    let x = ((relative_quality(tau, q) - off) / (1.0 - off))
        .max(0.0)
        .min(1.0);
    divide(tau, x * x * (3.0 - 2.0 * x))
}

/// The share in [0, 1] of a path's contribution that is regularised: all of it for `q >= tau^2`, nothing below `off tau^2`, the
/// smooth step in between. It fades the contribution where [`smooth_quality_threshold`] fades tau: the sum over all strategies
/// of their regularised weights, and that of their plain ones, is one each, and so is any mixture that depends on the path
/// alone. Both can be had by recursion, weights for a tau of each path cannot.
#[inline]
pub fn quality_share(tau: f32, q: f32, off: f32) -> f32 {
    let ratio = relative_quality(tau, q);
    if ratio >= 1.0 {
        return 1.0;
    }
    if !(ratio > off) {
        return 0.0;
    }
    let x = (ratio - off) / (1.0 - off);
    x * x * (3.0 - 2.0 * x)
}

/// q / tau^2.
#[inline]
fn relative_quality(tau: f32, q: f32) -> f32 {
    if !(tau > 0.0) {
        return 1.0;
    }
    let ratio = sqrt(q.max(0.0)) / tau;
    if ratio < LARGEST {
        ratio * ratio
    } else {
        f32::MAX
    }
}

/// Spread of the paths around the one at hand, along the walk from the sensor.
#[derive(Clone, Copy, Debug)]
pub struct PathDiffusion {
    /// Standard deviation of the position, sigma_x, in scene units.
    pub position: f32,
    /// Tangential standard deviation of the direction, sigma_angle.
    pub direction: f32,
}

impl PathDiffusion {
    /// A pinhole's sharp ray.
    pub const SHARP: PathDiffusion = PathDiffusion {
        position: 0.0,
        direction: 0.0,
    };

    /// Equation 21: scatters at a surface whose BSDF is bounded by `rho` and whose mean curvature is `curvature` (one
    /// over scene units, of any sign): the Gaussian of maximum rho has the deviation (2 pi rho)^-1/2.
    #[inline]
    pub fn scatter(&mut self, rho: f32, curvature: f32) {
        let lobe = if rho > 1e-12 {
            1.0 / sqrt(2.0 * PI * rho.min(TAU_MAX))
        } else {
            1.0 / sqrt(2.0 * PI * 1e-12)
        };
        let sum = self.direction + lobe + self.position * abs(curvature).min(1e15);
        self.direction = if sum < LARGEST { sum } else { LARGEST };
    }

    /// Equation 20: travels the distance `d`.
    #[inline]
    pub fn travel(&mut self, d: f32) {
        let sum = self.position + self.direction * d.max(0.0).min(1e15);
        self.position = if sum < LARGEST { sum } else { LARGEST };
    }
}

/// Equation 19: `tau / sigma_angle`, at most [`TAU_MAX`].
#[inline]
pub fn diffusion_threshold(tau: f32, diffusion: &PathDiffusion) -> f32 {
    divide(tau, diffusion.direction)
}

/// `tau / x`, at most [`TAU_MAX`].
#[inline]
fn divide(tau: f32, x: f32) -> f32 {
    if !(tau < TAU_MAX * x) {
        return TAU_MAX;
    }
    tau / x
}
