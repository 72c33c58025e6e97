//! Plain progressive photon mapping: radii that shrink by a fixed rule.
//!
//! - Knaus and Zwicker 2011: `r_{N+1}^2 = r_N^2 (N + alpha) / (N + 1)` (Kaplanyan 2017, equation 5.5), asymptotically
//!   `r_N = r_1 N^((alpha - 1) / 2)` (5.6), the same for all pixels and without statistics;
//! - Hachisuka et al. 2008: per pixel, from the photons found, `N' = N + alpha M`, `R' = R sqrt(N' / (N + M))`, and
//!   the accumulated flux scaled by `(R' / R)^2`.
//!
//! alpha in (0, 1) trades variance N^-alpha against bias N^(alpha - 1); the squared error falls fastest, as N^(-2/3),
//! at alpha = 2/3 (5.8). N counts from 1; radii in scene units. Invariants (tests): both rules keep the same limit,
//! the rates by simulation.

use crate::math::Rgb;
use crate::math::float::{pow, sqrt};

/// The asymptotically optimal alpha (equation 5.8).
pub const OPTIMAL_ALPHA: f32 = 2.0 / 3.0;

/// Equation 5.6: the radius of iteration `n`.
#[inline]
pub fn radius(initial: f32, n: u32, alpha: f32) -> f32 {
    initial * pow(n.max(1) as f32, 0.5 * (alpha.max(0.0).min(1.0) - 1.0))
}

/// Equation 5.5: the squared radius of iteration `n + 1` from that of iteration `n`.
#[inline]
pub fn next_squared_radius(squared_radius: f32, n: u32, alpha: f32) -> f32 {
    let n = n as f32;
    squared_radius * ((n + alpha.max(0.0).min(1.0)) / (n + 1.0))
}

/// Statistics of a pixel after Hachisuka, Ogaki and Jensen 2008.
#[derive(Clone, Copy, Debug)]
pub struct ProgressivePixel {
    /// Radius of the next pass.
    pub radius: f32,
    /// Photons kept, N: a share alpha of those found.
    pub photons: f32,
    /// Flux of the kept photons, BSDF included.
    pub flux: Rgb,
}

impl ProgressivePixel {
    /// A pixel before its first pass.
    pub fn new(radius: f32) -> ProgressivePixel {
        ProgressivePixel {
            radius,
            photons: 0.0,
            flux: Rgb::ZERO,
        }
    }

    /// Takes the `found` photons within the radius with the sum of their contributions `flux`.
    #[inline]
    pub fn update(&mut self, found: u32, flux: Rgb, alpha: f32) {
        if found == 0 {
            return;
        }
        let m = found as f32;
        let kept = self.photons + alpha.max(0.0).min(1.0) * m;
        let shrink = kept / (self.photons + m);
        self.flux = (self.flux + flux) * shrink;
        self.radius *= sqrt(shrink);
        self.photons = kept;
    }

    /// Radiance after `emitted` photons in all passes: the flux over the disk.
    #[inline]
    pub fn radiance(&self, emitted: f32) -> Rgb {
        let area = core::f32::consts::PI * self.radius * self.radius;
        let scale = area * emitted;
        if !(scale > 1e-30) {
            return Rgb::ZERO;
        }
        self.flux * (1.0 / scale)
    }
}
