//! Statistics that decide where samples go.
//!
//! Adaptive sampling (after Tungsten; its idea is Pajot et al. 2011, "Robust Adaptive Sampling For Monte-Carlo-Based
//! Rendering") spends samples where the relative squared error of a block of pixels is large.

/// Luminance squared below which an error counts as absolute: otherwise black pixels would ask for all samples.
pub const DARKEST_SQUARED_MEAN: f32 = 1e-3;

/// Relative squared error of the mean of `count` samples,
///
/// `error = variance / (count * max(mean^2, 1e-3))`,
///
/// with the variance of one sample. Dimensionless, not negative; zero without samples or variance.
/// Invariant: it falls as 1 / count, and does not change with exposure above the dark limit.
#[inline]
pub fn relative_squared_error(mean: f32, variance: f32, count: f32) -> f32 {
    if !(variance > 0.0 && count > 0.0) {
        return 0.0;
    }
    let squared_mean = mean * mean;
    let scale = if squared_mean > DARKEST_SQUARED_MEAN {
        squared_mean
    } else {
        DARKEST_SQUARED_MEAN
    };
    let error = variance / count / scale;
    // A variance near the largest float over a small scale overflows.
    if error < f32::MAX { error } else { f32::MAX }
}
