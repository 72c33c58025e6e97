//! Whether two images are estimates of the same radiance: a z-test of all pixels with one false-alarm rate.
//!
//! Both images come with the estimated variance of each pixel's mean. Per pixel and channel
//!
//! `z = (a - b) / sqrt(V_a + V_b + (floor * magnitude)^2)`,
//!
//! and four levels are tested: single pixels, means of 8 x 8 blocks, of 32 x 32 blocks, and of the whole image. Pixels
//! find what is wrong in single pixels, blocks find small differences over an area, down to a fraction of a percent for the
//! whole image. The false-alarm rate alpha is split by Sidak's formula, first over the levels, 1 - (1 - alpha)^(1/4),
//! then over the tests of a level. Tests of one level are positively dependent, which makes Sidak's bound conservative.
//!
//! What a textbook z-test gets wrong on rendered images, and what is done about it:
//!
//! - *Variances are estimates.* One from n runs or samples has n - 1 degrees of freedom (16 runs: their tail at 1e-8
//!   begins at 10 deviations, not at 5.7). Pixels use Student's t with the degrees of freedom of Welch and
//!   Satterthwaite; blocks add up those of their pixels.
//! - *A pixel that missed its rare bright samples underestimates its mean and its variance together*, and looks certain
//!   of a wrong value. So each variance is the larger of the pixel's own and the mean of its 5 x 5 neighbourhood, of
//!   which some pixel has caught the event. Where the samples behind both images are known, a variance is moreover at
//!   least that of the other image, scaled by the ratio of samples: the same scene has much the same variance per
//!   sample. All this can only make the test more conservative.
//! - *Neighbouring pixels may be correlated*: a renderer that splats each sample into all pixels under its filter leaves
//!   the variance of a block's mean larger than independent pixels say, threefold for a Gaussian of deviation 0.5. The
//!   factor, the sum of the autocorrelation of z over lags up to 3 pixels, is estimated from differences of pixels
//!   8 apart: those cancel a systematic difference between the images, which must not excuse itself as correlation.
//!   Lags below two standard errors count as zero, so independent pixels get a factor near 1.
//! - *Some pixels have no variance* (a lamp seen directly) and differ by rounding. The floor, a share of the radiance below
//!   which differences are not tested, applies at every level, because such differences do not average out.
//!
//! Stratified samples overestimate their variance, which makes the test more conservative as well.
//!
//! A test draws images of equal distribution and counts the alarms against alpha, and finds a bias of one percent.

use super::{RgbImage, assert_same_size};
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// An image with what is known of its error.
#[derive(Clone, Copy, Debug)]
pub struct Estimate<'a> {
    /// Mean radiance.
    pub mean: &'a RgbImage,
    /// Estimated variance of the mean, of the same size.
    pub variance: &'a RgbImage,
    /// Degrees of freedom of each variance: independent runs or samples per pixel, less one.
    pub degrees_of_freedom: f64,
    /// Samples per pixel, if the two images' are to be compared; see the module's description.
    pub samples: Option<f64>,
}

/// How strict the test is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Probability of a false alarm: that images of the same radiance are reported as different.
    pub false_alarm_rate: f64,
    /// Share of the radiance that is never tested.
    pub relative_floor: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            false_alarm_rate: 1e-3,
            relative_floor: 5e-4,
        }
    }
}

/// The most significant test of a level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelResult {
    /// Side of the blocks in pixels; 0 is the whole image.
    pub block: usize,
    /// Its deviations from zero.
    pub z: f64,
    /// First column of the block.
    pub x: usize,
    /// First row of the block.
    pub y: usize,
    /// Channel: 0 red, 1 green, 2 blue.
    pub channel: usize,
    /// Two-sided probability of such a deviation in one test.
    pub p: f64,
    /// The probability below which this level rejects.
    pub critical_p: f64,
}

/// Outcome of the test.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// The levels: pixels, 8 x 8, 32 x 32, the whole image.
    pub levels: [LevelResult; 4],
    /// Mean of z over pixels and channels; far from zero is a bias.
    pub mean_z: f64,
    /// Share of |z| > 3; 0.0027 for normal noise of known variance.
    pub share_above_3: f64,
    /// By how much the variance of block means exceeds that of independent pixels.
    pub correlation: f64,
}

impl Outcome {
    /// The most significant level: ln p over its critical value. Above 1 the images differ.
    pub fn severity(&self) -> f64 {
        self.levels
            .iter()
            .map(LevelResult::severity)
            .fold(0.0, f64::max)
    }

    /// Whether the images pass as estimates of the same radiance.
    pub fn passes(&self) -> bool {
        self.severity() <= 1.0
    }
}

impl LevelResult {
    /// ln p over its critical value. Above 1 this level rejects.
    pub fn severity(&self) -> f64 {
        // A probability that underflows counts as the smallest there is.
        self.p.max(f64::MIN_POSITIVE).ln() / self.critical_p.ln()
    }
}

/// Tests whether two images estimate the same radiance.
///
/// # Panics
/// If sizes differ, a value is not finite, or the false-alarm rate is not between 0 and 1.
pub fn ztest(a: Estimate<'_>, b: Estimate<'_>, settings: Settings) -> Outcome {
    for other in [a.variance, b.mean, b.variance] {
        assert_same_size(a.mean, other);
    }
    let alpha = settings.false_alarm_rate;
    assert!(
        alpha > 0.0 && alpha < 1.0,
        "a false-alarm rate is between 0 and 1"
    );
    let (width, height) = (a.mean.width, a.mean.height);
    let field = Field::new(a, b, settings.relative_floor);
    let correlation = correlation_factor(&field.z, width);

    let level_alpha = sidak(alpha, 4.0);
    let levels = [1, 8, 32, 0].map(|block| {
        let side = if block == 0 { width.max(height) } else { block };
        let tests = 3 * width.div_ceil(side) * height.div_ceil(side);
        let mut worst = LevelResult {
            block,
            z: 0.0,
            x: 0,
            y: 0,
            channel: 0,
            p: 1.0,
            critical_p: sidak(level_alpha, tests as f64),
        };
        for y in (0..height).step_by(side) {
            for x in (0..width).step_by(side) {
                for channel in 0..3 {
                    let factor = if block == 1 { 1.0 } else { correlation };
                    let (z, dof) =
                        field.block([x, y], side, channel, factor, settings.relative_floor);
                    // The tail shrinks with z and with the degrees of freedom, so most tests need no distribution.
                    if z.abs() > worst.z.abs() || (z.abs() > 2.0 && worst.p > 0.0) {
                        let p = two_sided(z, dof);
                        if p < worst.p || (p == worst.p && z.abs() > worst.z.abs()) {
                            worst = LevelResult {
                                z,
                                x,
                                y,
                                channel,
                                p,
                                ..worst
                            };
                        }
                    }
                }
            }
        }
        worst
    });
    let n = field.z.len() as f64 * 3.0;
    let values = || field.z.iter().flatten();
    Outcome {
        levels,
        mean_z: values().sum::<f64>() / n,
        share_above_3: values().filter(|z| z.abs() > 3.0).count() as f64 / n,
        correlation,
    }
}

/// The rate at which each of `tests` independent tests may raise a false alarm for `alpha` of all together.
fn sidak(alpha: f64, tests: f64) -> f64 {
    -((-alpha).ln_1p() / tests).exp_m1()
}

/// Two-sided probability of a deviation.
fn two_sided(z: f64, degrees_of_freedom: f64) -> f64 {
    let z = z.abs();
    // From here on Student's t is the normal distribution to the precision that matters.
    if degrees_of_freedom > 1e6 {
        return 2.0 * Normal::standard().sf(z);
    }
    match StudentsT::new(0.0, 1.0, degrees_of_freedom.max(1.0)) {
        Ok(t) => 2.0 * t.sf(z),
        Err(_) => 1.0,
    }
}

/// Differences, their variances and degrees of freedom, per pixel.
struct Field {
    width: usize,
    height: usize,
    difference: Vec<[f64; 3]>,
    magnitude: Vec<[f64; 3]>,
    variance: Vec<[f64; 3]>,
    degrees_of_freedom: Vec<[f64; 3]>,
    z: Vec<[f64; 3]>,
}

impl Field {
    fn new(a: Estimate<'_>, b: Estimate<'_>, floor: f64) -> Self {
        let (width, height) = (a.mean.width, a.mean.height);
        let (smooth_a, smooth_b) = (smoothed(a.variance), smoothed(b.variance));
        let ratio = match (a.samples, b.samples) {
            (Some(a), Some(b)) if a > 0.0 && b > 0.0 => Some(a / b),
            _ => None,
        };
        let n = width * height;
        let mut field = Self {
            width,
            height,
            difference: vec![[0.0; 3]; n],
            magnitude: vec![[0.0; 3]; n],
            variance: vec![[0.0; 3]; n],
            degrees_of_freedom: vec![[0.0; 3]; n],
            z: vec![[0.0; 3]; n],
        };
        for i in 0..n {
            for c in 0..3 {
                let (mean_a, mean_b) = (a.mean.pixels[i][c], b.mean.pixels[i][c]);
                let (mut va, mut vb) = (smooth_a[i][c], smooth_b[i][c]);
                if let Some(ratio) = ratio {
                    (va, vb) = (va.max(vb / ratio), vb.max(va * ratio));
                }
                let v = va + vb;
                // Welch and Satterthwaite; without any variance there is no test but the floor's.
                let parts = va * va / a.degrees_of_freedom.max(1.0)
                    + vb * vb / b.degrees_of_freedom.max(1.0);
                field.degrees_of_freedom[i][c] = if parts > 0.0 {
                    v * v / parts
                } else {
                    f64::INFINITY
                };
                field.variance[i][c] = v;
                field.difference[i][c] = mean_a - mean_b;
                field.magnitude[i][c] = 0.5 * (mean_a.abs() + mean_b.abs());
                field.z[i][c] = deviations(mean_a - mean_b, v, floor * field.magnitude[i][c]);
            }
        }
        field
    }

    /// Deviations of the mean difference of a block, and degrees of freedom of its variance.
    fn block(
        &self,
        [x, y]: [usize; 2],
        side: usize,
        c: usize,
        correlation: f64,
        floor: f64,
    ) -> (f64, f64) {
        let (mut difference, mut magnitude, mut variance, mut dof, mut n) =
            (0.0, 0.0, 0.0, 0.0, 0.0);
        for row in y..(y + side).min(self.height) {
            for i in row * self.width + x..row * self.width + (x + side).min(self.width) {
                difference += self.difference[i][c];
                magnitude += self.magnitude[i][c];
                variance += self.variance[i][c];
                dof += self.degrees_of_freedom[i][c];
                n += 1.0;
            }
        }
        let z = deviations(
            difference / n,
            variance * correlation / (n * n),
            floor * magnitude / n,
        );
        (z, dof)
    }
}

/// Deviations of a difference from zero. Differences near the smallest floats are no differences.
fn deviations(difference: f64, variance: f64, floor: f64) -> f64 {
    difference / (variance + floor * floor + 1e-24).sqrt()
}

/// The larger of each variance and the mean of its 5 x 5 neighbourhood.
fn smoothed(variance: &RgbImage) -> Vec<[f64; 3]> {
    let (width, height) = (variance.width, variance.height);
    let mut result = Vec::with_capacity(variance.pixels.len());
    for y in 0..height {
        for x in 0..width {
            let mut sum = [0.0; 3];
            let mut n = 0.0;
            for row in y.saturating_sub(2)..(y + 3).min(height) {
                for v in &variance.pixels
                    [row * width + x.saturating_sub(2)..row * width + (x + 3).min(width)]
                {
                    (0..3).for_each(|c| sum[c] += v[c]);
                    n += 1.0;
                }
            }
            let variance_here = variance.pixels[y * width + x];
            result.push(std::array::from_fn(|c| {
                variance_here[c].max(sum[c] / n).max(0.0)
            }));
        }
    }
    result
}

/// Largest factor accepted for correlated noise: a Gaussian of deviation 0.5, the usual filter, has pi. A larger estimate is
/// caused by a systematic difference between the images.
const MAX_CORRELATION: f64 = 4.0;

/// Sum of the autocorrelation of z over the lags that are significant, at least 1 and at most 4.
fn correlation_factor(z: &[[f64; 3]], width: usize) -> f64 {
    const REACH: isize = 3;
    const APART: usize = 8;
    let height = z.len() / width;
    // Differences of pixels 8 apart, along rows or along columns, whichever is longer; clamped against outliers.
    let along_rows = width >= height;
    let (w, h) = if along_rows {
        (width.saturating_sub(APART), height)
    } else {
        (width, height.saturating_sub(APART))
    };
    if w < 2 * APART || h < 2 * APART {
        return 1.0;
    }
    let step = if along_rows { APART } else { APART * width };
    let clamped = |v: f64| v.clamp(-3.0, 3.0);
    let mut differences = Vec::with_capacity(w * h);
    for y in 0..h {
        for x in 0..w {
            let i = y * width + x;
            let (a, b) = (z[i], z[i + step]);
            differences.push([0, 1, 2].map(|c| clamped(a[c]) - clamped(b[c])));
        }
    }
    let covariance = |dx: isize, dy: isize| {
        let (mut sum, mut n) = (0.0, 0.0);
        for y in 0..h as isize - dy {
            for x in (-dx).max(0)..(w as isize - dx).min(w as isize) {
                let i = y as usize * w + x as usize;
                let j = (y + dy) as usize * w + (x + dx) as usize;
                sum += (0..3)
                    .map(|c| differences[i][c] * differences[j][c])
                    .sum::<f64>();
                n += 1.0;
            }
        }
        sum / n
    };
    let variance = covariance(0, 0);
    if !(variance > 0.0) {
        return 1.0;
    }
    let standard_error = 1.0 / ((w * h) as f64).sqrt();
    let mut factor = 1.0;
    for dy in 0..=REACH {
        for dx in -REACH..=REACH {
            // Half of the lags; the other half are their mirror images.
            if dy == 0 && dx <= 0 {
                continue;
            }
            let correlation = covariance(dx, dy) / variance;
            if correlation > 2.0 * standard_error {
                factor += 2.0 * correlation;
            }
        }
    }
    factor.min(MAX_CORRELATION)
}
