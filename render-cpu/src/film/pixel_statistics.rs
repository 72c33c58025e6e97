//! Running statistics of the samples of a pixel.
//!
//! Per channel, after n samples x_1 ... x_n (Welford 1962, in f64):
//!
//! mean_n = mean_{n-1} + (x_n - mean_{n-1}) / n,   M2_n = M2_{n-1} + (x_n - mean_{n-1}) (x_n - mean_n),
//! variance of the mean = M2_n / (n (n - 1)).
//!
//! For stratified samplers (Sobol') that figure is an upper estimate: their samples of one pixel repel each other.

use glam::Vec3;

/// Running statistics of one pixel; one cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct PixelStatistics {
    /// Samples taken, rejected ones included: also the index of the pixel's next sample.
    pub count: u32,
    /// Samples that were not finite. They count as black, so that `count` stays the sample index.
    pub rejected: u32,
    /// Mean radiance per channel.
    pub mean: [f64; 3],
    /// Sum of squared deviations from the mean, per channel.
    pub m2: [f64; 3],
    /// Sum of squared deviations of luminance; its mean is the luminance of `mean`.
    pub luminance_m2: f64,
}

/// Luminance of linear sRGB in f64 (Rec. 709 weights, as `halflight_kernel::math::luminance`).
pub fn luminance(c: [f64; 3]) -> f64 {
    0.212_671 * c[0] + 0.715_160 * c[1] + 0.072_169 * c[2]
}

impl PixelStatistics {
    /// Adds one sample: radiance times the signed filter weight.
    #[inline]
    pub fn add(&mut self, value: Vec3) {
        let value = if value.is_finite() {
            value
        } else {
            self.rejected = self.rejected.saturating_add(1);
            Vec3::ZERO
        };
        self.count = self.count.saturating_add(1);
        let inverse = 1.0 / f64::from(self.count);
        let mut before = [0.0; 3];
        let mut after = [0.0; 3];
        for c in 0..3 {
            before[c] = f64::from(value[c]) - self.mean[c];
            self.mean[c] += before[c] * inverse;
            after[c] = f64::from(value[c]) - self.mean[c];
            self.m2[c] += before[c] * after[c];
        }
        self.luminance_m2 += luminance(before) * luminance(after);
    }

    /// Adds the samples of another pixel: pooled mean and deviations (Chan, Golub and LeVeque 1979, equation 2.1).
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        if self.count == 0 {
            *self = *other;
            return;
        }
        let (na, nb) = (f64::from(self.count), f64::from(other.count));
        let n = na + nb;
        let mut delta = [0.0; 3];
        for c in 0..3 {
            delta[c] = other.mean[c] - self.mean[c];
            self.mean[c] += delta[c] * (nb / n);
            self.m2[c] += other.m2[c] + delta[c] * delta[c] * (na * nb / n);
        }
        let delta = luminance(delta);
        self.luminance_m2 += other.luminance_m2 + delta * delta * (na * nb / n);
        self.count = self.count.saturating_add(other.count);
        self.rejected = self.rejected.saturating_add(other.rejected);
    }

    /// Estimated variance of the mean per channel; zero below two samples, where nothing is known of it.
    pub fn variance_of_mean(&self) -> [f64; 3] {
        self.m2.map(|m2| self.of_mean(m2))
    }

    /// Estimated variance of the mean luminance.
    pub fn luminance_variance_of_mean(&self) -> f64 {
        self.of_mean(self.luminance_m2)
    }

    fn of_mean(&self, m2: f64) -> f64 {
        if self.count < 2 {
            return 0.0;
        }
        let n = f64::from(self.count);
        // Rounding can leave a tiny negative sum.
        m2.max(0.0) / (n * (n - 1.0))
    }
}
