//! Adaptive progressive photon mapping: a gather radius per pixel that balances bias and variance.
//!
//! Kaplanyan 2017, chapter 5 (Kaplanyan and Dachsbacher 2013). With J photons per pass, N passes, the Perlin kernel K
//! on a disk of radius r, p_l the density of photons per area and emitted photon, psi the contribution of a photon to
//! the pixel (flux times BSDF times importance) and I the pixel's value, I = p_l `E[psi]`:
//!
//! - bias `k2 r^2 laplacian(I) / 2` (equation 5.13), k2 = 5/48 the kernel's second moment per axis;
//! - variance `k3 p_l E[psi^2] / (J N r^2)`, k3 = 287/(132 pi) its square norm (the line before 5.12);
//! - the radius that minimises their sum, `r_N = (2 V / (J k2^2 laplacian^2))^(1/6) N^(-1/6)` (5.15) with the variance
//!   written V / (J N r^2).
//!
//! Equation 5.12 replaces that V by `Var[psi] / (pi p_l)`, the variance of a mean over the photons in the disk, as if
//! their number were given. [`Variance`] has both. With photons of equal power `Var[psi]` = 0 and the radius collapses
//! to its lower bound, while the number of photons still varies; a simulation settles which minimises the error (test,
//! experiment `appm`), and [`Variance::KERNEL`] is what `bandwidth` takes. psi here is a flux; for
//! [`Variance::MEASUREMENT`] it is scaled to radiance by p_l.
//!
//! The Laplacian is estimated by second differences of the kernel (5.16) with its own, wider radius r'_N, which
//! shrinks as N^(-1/8): `r'_N = 1.9635 sigma N^(-1/8)` (5.18), sigma the deviation of the Laplacian. Of the constant
//! we know no derivation (Silverman's rule with the trace of the second moments gives 1.9397), and sigma is not a
//! length: the bounds decide about r' until it is calibrated to a scene's units. Both radii stay in `[r_min, r_max]`
//! times their power of N, so that the estimator is consistent whatever the statistics say.
//!
//! The thesis prints the normalisation 1/(pi r^2) and k2 of one dimension (5/42): the mass would be 2/7 and 5.13 off.
//! Invariants (tests): constants by quadrature, bias and variance by simulation, consistency of the Laplacian, r ->
//! r_N N^(-1/6).

use crate::math::float::{pow, sqrt};
use crate::regularize::mollifier::{self, PERLIN};
use core::f32::consts::FRAC_1_PI;
use glam::Vec2;

/// Second moment per axis of the Perlin kernel on the disk.
pub const SECOND_MOMENT: f32 = 5.0 / 48.0;
/// Integral of its square, 287 / (132 pi).
pub const SQUARE_NORM: f32 = 287.0 / 132.0 * FRAC_1_PI;
/// Constant of equation 5.18.
pub const DERIVATIVE_CONSTANT: f32 = 1.9635;
/// The best radius of the running mean over that of a single pass with all photons, 3^(-1/6). With radii r_i = r_1 i^(-1/6) the
/// mean over N passes has 3/2 of the last pass's bias and 3/4 of the variance `V / (J N r_N^2)`; the least of `9/4 (k2
/// laplacian r^2 / 2)^2 + 3/4 V / (J N r^2)` lies at a sixth power of r that is a third of equation 5.15's, and is 13.5 %
/// below the error there.
pub const RUNNING_MEAN: f32 = 0.832_683_2;
/// Silverman's rule for second derivatives in the form `(d R / (k2^2 / (2 pi)))^(1/8)` with the moment per axis.
pub const NORMAL_REFERENCE: f32 = 2.306_7;
/// Least radius over that of the scene.
pub const LEAST_RADIUS: f32 = 1e-6;
/// Largest radius over that of the scene, in the thesis.
pub const LARGEST_RADIUS: f32 = 1e-1;

/// Which variance a bandwidth balances.
pub struct Variance;

impl Variance {
    /// That of the kernel estimate, `k3 p_l E[psi^2]`.
    pub const KERNEL: u32 = 0;
    /// Equation 5.12, `p_l Var[psi] / pi`: the thesis's, psi in units of radiance.
    pub const MEASUREMENT: u32 = 1;
}

/// Statistics of a pixel: eight floats.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PhotonStatistics {
    /// Passes so far, N.
    pub passes: f32,
    /// Photons that fell within the radius, over all passes.
    pub photons: f32,
    /// Mean of psi over those.
    pub mean: f32,
    /// Mean of psi^2 over those.
    pub square: f32,
    /// Mean of the Laplacian over the passes.
    pub laplacian: f32,
    /// Mean of its square over the passes.
    pub laplacian_square: f32,
    /// p_l: photons per area and emitted photon.
    pub density: f32,
    /// The pixel's value, I.
    pub value: f32,
}

/// Sums over the photons of one pass around one pixel.
#[derive(Clone, Copy, Debug, Default)]
pub struct PhotonPass {
    /// Number of photons within the radius.
    pub photons: f32,
    /// Sum of psi over those.
    pub sum: f32,
    /// Sum of psi^2 over those.
    pub square_sum: f32,
    /// Sum of the kernel over those.
    pub kernel_sum: f32,
    /// Sum of psi times the kernel over those.
    pub value_sum: f32,
    /// Sum of psi times [`laplacian_kernel`] over the photons within twice the derivative's radius.
    pub laplacian_sum: f32,
}

impl PhotonPass {
    /// Adds a photon at `offset` from the eye path's vertex, in its tangent plane, with the contribution `psi`; returns the
    /// kernel of the estimate there.
    #[inline]
    pub fn add(&mut self, offset: Vec2, psi: f32, radius: f32, derivative_radius: f32) -> f32 {
        let distance = sqrt(offset.length_squared());
        let mut k = 0.0;
        if distance < radius {
            k = mollifier::eval_scaled(PERLIN, 2, distance, radius);
            self.photons += 1.0;
            self.sum += psi;
            self.square_sum += psi * psi;
            self.kernel_sum += k;
            self.value_sum += psi * k;
        }
        if distance < 2.0 * derivative_radius {
            self.laplacian_sum += psi * laplacian_kernel(offset, derivative_radius);
        }
        k
    }
}

/// Kernel of the Laplacian (equations 5.16, 5.17): second differences of the scaled kernel over `radius` along both
/// axes. Its integral against a quadratic function is the function's Laplacian.
#[inline]
pub fn laplacian_kernel(offset: Vec2, radius: f32) -> f32 {
    if !(radius > 1e-9) {
        return 0.0;
    }
    let x = offset * (1.0 / radius);
    let k = |x: f32, y: f32| mollifier::shape(PERLIN, sqrt(x * x + y * y));
    let sum = k(x.x + 1.0, x.y) + k(x.x - 1.0, x.y) + k(x.x, x.y + 1.0) + k(x.x, x.y - 1.0);
    let differences = sum - 4.0 * k(x.x, x.y);
    let inverse = 1.0 / (radius * radius);
    mollifier::normalization(PERLIN, 2) * differences * inverse * inverse
}

impl PhotonStatistics {
    /// Takes a pass of `emitted` photons (J).
    #[inline]
    pub fn update(&mut self, pass: &PhotonPass, emitted: f32) {
        let per_photon = 1.0 / emitted.max(1.0);
        self.passes += 1.0;
        let share = 1.0 / self.passes;
        self.value += (pass.value_sum * per_photon - self.value) * share;
        self.density += (pass.kernel_sum * per_photon - self.density) * share;
        let laplacian = pass.laplacian_sum * per_photon;
        self.laplacian += (laplacian - self.laplacian) * share;
        self.laplacian_square += (laplacian * laplacian - self.laplacian_square) * share;
        if pass.photons > 0.0 {
            self.photons += pass.photons;
            let share = 1.0 / self.photons;
            self.mean += (pass.sum - pass.photons * self.mean) * share;
            self.square += (pass.square_sum - pass.photons * self.square) * share;
        }
    }

    /// Variance of psi.
    #[inline]
    pub fn variance(&self) -> f32 {
        (self.square - self.mean * self.mean).max(0.0)
    }

    /// V of the variance V / (J N r^2); `kind` is one of [`Variance`].
    #[inline]
    pub fn variance_coefficient(&self, kind: u32) -> f32 {
        if kind == Variance::KERNEL {
            SQUARE_NORM * self.density * self.square
        } else {
            FRAC_1_PI * self.density * self.variance()
        }
    }

    /// The Laplacian as far as it stands out from its noise: the root of its square less the variance of its mean, by which the
    /// square of an estimate is too large on average. Raw, it would take noise in flat regions for curvature.
    #[inline]
    pub fn significant_laplacian(&self) -> f32 {
        let square = self.laplacian * self.laplacian;
        if self.passes < 2.0 {
            return sqrt(square);
        }
        let variance = (self.laplacian_square - square).max(0.0);
        sqrt((square - variance / (self.passes - 1.0)).max(0.0))
    }

    /// r'_N from a normal fit, as equation 5.18 but with a length for its deviation. Where the measured function is a Gaussian
    /// bump of deviation s, its Laplacian at the top is -2 I / s^2; so s = sqrt(2 I / D), D the root mean square of the
    /// Laplacian over the passes, and r' = [`NORMAL_REFERENCE`] s N^(-1/8). Between `least` and `largest` times N^(-1/8).
    #[inline]
    pub fn curvature_bandwidth(&self, least: f32, largest: f32) -> f32 {
        let power = pow(self.passes.max(1.0), -1.0 / 8.0);
        let largest = largest.max(least);
        let curvature = sqrt(self.laplacian_square.max(0.0));
        let square = 2.0 * self.value.max(0.0) / curvature.max(1e-30);
        let r = NORMAL_REFERENCE * sqrt(square.max(0.0));
        // Not a number of passes without photons: nothing is known yet.
        if !(curvature > 0.0) || !(r < largest) {
            return largest * power;
        }
        r.max(least) * power
    }

    /// r_N, the radius of the next pass, from the statistics so far ([`RUNNING_MEAN`] of equation 5.15's), between `least` and `largest` times N^(-1/6).
    #[inline]
    pub fn bandwidth(&self, kind: u32, emitted: f32, least: f32, largest: f32) -> f32 {
        let n = self.passes.max(1.0);
        let power = pow(n, -1.0 / 6.0);
        let v = self.variance_coefficient(kind);
        let laplacian = self.significant_laplacian();
        let r = RUNNING_MEAN * optimal_bandwidth(v, laplacian, emitted * n);
        r.max(least * power).min(largest.max(least) * power)
    }

    /// r'_N, the radius of the Laplacian in the next pass (equation 5.18), between `least` and `largest` times
    /// N^(-1/8).
    #[inline]
    pub fn derivative_bandwidth(&self, least: f32, largest: f32) -> f32 {
        let n = self.passes.max(1.0);
        let power = pow(n, -1.0 / 8.0);
        if self.passes < 2.0 {
            // No deviation is known yet (algorithm 1 starts with the largest radius).
            return largest.max(least) * power;
        }
        let variance = (self.laplacian_square - self.laplacian * self.laplacian).max(0.0);
        let r = DERIVATIVE_CONSTANT * sqrt(variance);
        r.max(least).min(largest.max(least)) * power
    }
}

/// The radius that minimises `v / (m r^2) + (k2 laplacian r^2 / 2)^2` for `m` emitted photons; very large where
/// nothing is known of the function, or it is flat.
#[inline]
pub fn optimal_bandwidth(v: f32, laplacian: f32, m: f32) -> f32 {
    let slope = SECOND_MOMENT * laplacian;
    if !(m > 0.0) || !(slope * slope > 1e-30) {
        return UNBOUNDED;
    }
    let sixth_power = 2.0 * v.max(0.0) / (m * slope * slope);
    pow(sixth_power, 1.0 / 6.0).min(UNBOUNDED)
}

/// An infinite radius, as a number; callers clamp it.
pub const UNBOUNDED: f32 = 1e12;
