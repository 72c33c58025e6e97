//! Separable filters over planes of numbers.

use rayon::prelude::*;

/// What a filter reads beyond the border.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Border {
    /// The nearest pixel.
    Replicate,
    /// Nothing: the result is smaller by the filter's extent.
    Valid,
}

/// Convolves a plane with the filter `horizontal` along rows and then `vertical` along columns, both of odd length.
/// Filters are applied without mirroring: element `radius + k` weighs the pixel at distance `k`.
pub(super) fn convolve(
    plane: &[f64],
    width: usize,
    horizontal: &[f64],
    vertical: &[f64],
    border: Border,
) -> Vec<f64> {
    let height = plane.len() / width;
    let (rx, ry) = (horizontal.len() / 2, vertical.len() / 2);
    let (shrink_x, shrink_y) = if border == Border::Valid {
        (rx, ry)
    } else {
        (0, 0)
    };
    let (out_width, out_height) = (width - 2 * shrink_x, height - 2 * shrink_y);
    let mut rows = vec![0.0; out_width * height];
    rows.par_chunks_mut(out_width)
        .zip(plane.par_chunks(width))
        .for_each(|(out, row)| {
            for (x, out) in out.iter_mut().enumerate() {
                let center = x + shrink_x;
                let mut sum = 0.0;
                for (k, weight) in horizontal.iter().enumerate() {
                    sum += weight * row[(center + k).saturating_sub(rx).min(width - 1)];
                }
                *out = sum;
            }
        });
    let mut result = vec![0.0; out_width * out_height];
    result
        .par_chunks_mut(out_width)
        .enumerate()
        .for_each(|(y, out)| {
            let center = y + shrink_y;
            for (k, weight) in vertical.iter().enumerate() {
                let source = (center + k).saturating_sub(ry).min(height - 1);
                for (out, value) in out.iter_mut().zip(&rows[source * out_width..]) {
                    *out += weight * value;
                }
            }
        });
    result
}

/// A Gaussian at the integers from -radius to radius, scaled to the sum 1.
pub(super) fn gaussian(deviation: f64, radius: usize) -> Vec<f64> {
    let weight = |i: usize| {
        let x = i as f64 - radius as f64;
        (-x * x / (2.0 * deviation * deviation)).exp()
    };
    let weights: Vec<f64> = (0..=2 * radius).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter().map(|w| w / sum).collect()
}
