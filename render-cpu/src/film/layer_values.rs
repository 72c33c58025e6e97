//! Values of the layers of a film, from the sums that its pixels keep.
//!
//! With n samples x_i of a pixel, a layer shows the mean sum x_i / n, and the variance of that mean is estimated by
//! (sum x_i^2 - (sum x_i)^2 / n) / (n (n - 1)). Output variables are plain means over the sample positions: the signs of a filter
//! would only add noise.

use super::aov::Aov;
use super::{Film, luminance};

/// What the layers of regularisation show: the share `sum` of the luminance `whole` that is regularised, and the mean of tau or of the
/// radius whose logarithm, weighted by it, adds up to `logarithm`.
pub fn share_and_scale(whole: f64, sum: f64, logarithm: f64) -> [f64; 2] {
    let share = if whole > 0.0 {
        // A filter has negative weights.
        (sum / whole).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let scale = if sum > 0.0 {
        (logarithm / sum).exp()
    } else {
        0.0
    };
    [share, scale]
}

/// Numbers of a colour.
const CHANNELS: usize = 3;

impl Film {
    fn part_sum(&self, part: usize, number: usize, pixel: usize) -> f64 {
        let first = pixel * self.sums_per_pixel() + self.aovs.accumulators();
        self.aov_sums[first + self.aovs.sums_per_part() * part + number]
    }

    /// Mean of one channel of a part over the samples of a pixel; zero where there is no sample.
    pub fn part_mean(&self, part: usize, channel: usize, pixel: usize) -> f64 {
        let count = self.statistics[pixel].count;
        if count == 0 {
            return 0.0;
        }
        self.part_sum(part, channel, pixel) / f64::from(count)
    }

    /// Estimated variance of that mean, if the film keeps variances; zero below two samples.
    pub fn part_variance(&self, part: usize, channel: usize, pixel: usize) -> Option<f64> {
        if !self.aovs.contains(Aov::Variance) {
            return None;
        }
        let n = f64::from(self.statistics[pixel].count);
        if n < 2.0 {
            return Some(0.0);
        }
        let sum = self.part_sum(part, channel, pixel);
        let squares = self.part_sum(part, CHANNELS + channel, pixel);
        Some((squares - sum * sum / n).max(0.0) / (n * (n - 1.0)))
    }

    /// Mean of one channel of an output variable over the samples of a pixel; zero where there is no sample.
    pub fn aov_mean(&self, aov: Aov, channel: usize, pixel: usize) -> f64 {
        let statistics = &self.statistics[pixel];
        match aov {
            Aov::Variance => statistics.variance_of_mean()[channel],
            Aov::Samples => f64::from(statistics.count),
            // What is kept for the next pass is no sum over samples.
            Aov::Bandwidth if self.aovs.contains(aov) => {
                self.aov_sums[pixel * self.sums_per_pixel() + self.aovs.offset(aov)]
            }
            Aov::Acceptance | Aov::Iterations | Aov::Jumps if self.aovs.contains(aov) => {
                let start = pixel * self.sums_per_pixel() + self.aovs.offset(aov);
                let [sum, number] = [0, 1].map(|i| self.aov_sums[start + i]);
                if number > 0.0 { sum / number } else { 0.0 }
            }
            Aov::Regularization if self.aovs.contains(aov) => {
                let start = pixel * self.sums_per_pixel() + self.aovs.offset(aov);
                let [sum, logarithm] = [0, 1].map(|i| self.aov_sums[start + i]);
                let whole = luminance(statistics.mean) * f64::from(statistics.count);
                share_and_scale(whole, sum, logarithm)[channel]
            }
            _ if !self.aovs.contains(aov) || statistics.count == 0 => 0.0,
            _ => {
                self.aov_sums[pixel * self.sums_per_pixel() + self.aovs.offset(aov) + channel]
                    / f64::from(statistics.count)
            }
        }
    }
}
