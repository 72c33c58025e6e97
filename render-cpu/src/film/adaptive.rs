//! Adaptive sampling: how many samples each pixel gets in the next pass.
//!
//! After Tungsten (its author's page describes the reasons), which follows Pajot et al. 2011:
//!
//! 1. until every pixel has [`UNIFORM_SAMPLES`] samples, all pixels get the same;
//! 2. blocks of 4 x 4 pixels: relative squared error of luminance (`kernel::math::statistics`), so that each estimate is
//!    based on sixteen times as many samples;
//! 3. errors are clamped to the 95th percentile of the positive ones, so that fireflies do not use up the budget;
//! 4. each block takes the largest error of itself and its eight neighbours: noise is coherent in space, and a block
//!    that has missed its rare bright samples so far is found through a neighbour that has not;
//! 5. a budget of `samples_per_pixel` times the number of pixels: one sample for each pixel, the rest in proportion
//!    to the errors. Fractions are carried along the rows from pixel to pixel, so the budget is met exactly.
//!
//! Two deliberate differences from Tungsten: the variance is that of samples within their own pixel, because texture
//! between the pixels of a block is not noise; and the dilation covers all 3 x 3 blocks, where its two passes in place
//! leave out two corners.
//!
//! The result is a function of the film alone: a resumed run takes the same decisions. Sample counts that depend on
//! earlier samples bias an image slightly; the bias falls with the number of samples of the uniform passes.

use crate::film::{Film, luminance};
use halflight_kernel::math::statistics::relative_squared_error;

/// Samples that every pixel gets before errors are believed.
pub const UNIFORM_SAMPLES: u32 = 16;

/// Side of a block in pixels.
const BLOCK: usize = 4;

/// Share of the positive errors that is not clamped.
const PERCENTILE: f64 = 0.95;

/// Number of samples of each pixel in the next pass, by rows: at least one each, together exactly
/// `samples_per_pixel` times the number of pixels.
///
/// # Panics
/// If `samples_per_pixel` is zero.
pub fn next_sample_counts(film: &Film, samples_per_pixel: u32) -> Vec<u32> {
    assert!(
        samples_per_pixel > 0,
        "a pass takes at least one sample per pixel"
    );
    let (width, height) = (film.width() as usize, film.height() as usize);
    let uniform = vec![samples_per_pixel; width * height];
    if film.statistics().iter().any(|p| p.count < UNIFORM_SAMPLES) {
        return uniform;
    }
    let across = width.div_ceil(BLOCK);
    let mut errors = block_errors(film);
    clamp_to_percentile(&mut errors);
    let weights = dilate(&errors, across);

    let weight_of = |x: usize, y: usize| f64::from(weights[y / BLOCK * across + x / BLOCK]);
    let mut total = 0.0;
    for y in 0..height {
        for x in 0..width {
            total += weight_of(x, y);
        }
    }
    if !(total > 0.0) {
        return uniform;
    }
    let budget = (u64::from(samples_per_pixel) - 1) * (width * height) as u64;
    let mut counts = uniform;
    let mut sum = 0.0;
    let mut given = 0_u64;
    for y in 0..height {
        for x in 0..width {
            // The running sum in the same order ends at `total` to the last bit, so that the budget is met.
            sum += weight_of(x, y);
            let target = ((sum / total * budget as f64).round() as u64).clamp(given, budget);
            counts[y * width + x] = 1 + u32::try_from(target - given).unwrap_or(u32::MAX - 1);
            given = target;
        }
    }
    counts
}

/// Relative squared error of each block of pixels, by rows of blocks.
pub fn block_errors(film: &Film) -> Vec<f32> {
    let (width, height) = (film.width() as usize, film.height() as usize);
    let mut errors = Vec::with_capacity(width.div_ceil(BLOCK) * height.div_ceil(BLOCK));
    for top in (0..height).step_by(BLOCK) {
        for left in (0..width).step_by(BLOCK) {
            let (mut mean, mut m2, mut samples, mut pixels) = (0.0, 0.0, 0.0, 0.0);
            for y in top..(top + BLOCK).min(height) {
                for p in &film.statistics()[y * width + left..y * width + (left + BLOCK).min(width)]
                {
                    mean += luminance(p.mean);
                    m2 += p.luminance_m2;
                    samples += f64::from(p.count);
                    pixels += 1.0;
                }
            }
            let variance = if samples > pixels {
                m2 / (samples - pixels)
            } else {
                0.0
            };
            errors.push(relative_squared_error(
                (mean / pixels) as f32,
                variance as f32,
                samples as f32,
            ));
        }
    }
    errors
}

/// Clamps errors to the 95th percentile of the positive ones.
fn clamp_to_percentile(errors: &mut [f32]) {
    let mut positive: Vec<f32> = errors.iter().copied().filter(|&e| e > 0.0).collect();
    if positive.is_empty() {
        return;
    }
    positive.sort_unstable_by(f32::total_cmp);
    let limit = positive[((positive.len() - 1) as f64 * PERCENTILE) as usize];
    for error in errors {
        *error = error.min(limit);
    }
}

/// The largest of each block's 3 x 3 neighbourhood.
fn dilate(errors: &[f32], across: usize) -> Vec<f32> {
    let down = errors.len() / across;
    let mut dilated = Vec::with_capacity(errors.len());
    for y in 0..down {
        for x in 0..across {
            let mut largest = 0.0_f32;
            for neighbour_y in y.saturating_sub(1)..(y + 2).min(down) {
                for neighbour_x in x.saturating_sub(1)..(x + 2).min(across) {
                    largest = largest.max(errors[neighbour_y * across + neighbour_x]);
                }
            }
            dilated.push(largest);
        }
    }
    dilated
}
