//! The first stage of a two-stage start: how bright the parts of the image are, by candidates of a group that no image has.
//!
//! It is a function of the seed alone, so that interrupted runs and shares of an image go on with the same; and whatever it is, groups
//! are unbiased.

use halflight_kernel::transport::markov::ChainAlgorithm;
use halflight_kernel::transport::markov::importance::{cell, cells_of, weights};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Group number of its candidates.
pub const PILOT: u32 = u32::MAX;

/// How many.
const CANDIDATES: u32 = 1 << 15;

/// Candidates of one task.
const CHUNK: u32 = 256;

/// What one path may add to a cell, in units of the mean of all candidates.
const LIMIT: f32 = 16.0;

/// How often chains shall come to each cell of a window of so many pixels that begins at `offset`.
pub fn first_stage<A: ChainAlgorithm>(algorithm: &A, size: [u32; 2], offset: [u32; 2]) -> Vec<f32> {
    let [columns, rows] = cells_of(size);
    let mut light = vec![0.0f32; columns as usize * rows as usize];
    let count = light.len();
    // In their order, whatever the threads.
    let found: Vec<Vec<(usize, f32)>> = (0..CANDIDATES / CHUNK)
        .into_par_iter()
        .map(|chunk| {
            let mut found = Vec::new();
            for candidate in chunk * CHUNK..(chunk + 1) * CHUNK {
                algorithm.candidate_luminances(candidate, &mut |film, weight| {
                    if weight.is_finite() {
                        found.push((cell(film, offset, columns, count), weight));
                    }
                });
            }
            found
        })
        .collect();
    let found = || found.iter().flatten();
    let sum: f64 = found().map(|(_, weight)| f64::from(*weight)).sum();
    let limit = LIMIT * (sum / f64::from(CANDIDATES)) as f32;
    for (cell, weight) in found() {
        light[*cell] += weight.min(limit);
    }
    weights(&light, size).collect()
}
