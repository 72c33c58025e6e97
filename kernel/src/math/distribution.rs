//! Discrete distributions as cumulative tables inside the scene's `data`.
//!
//! A table of `count` words holds `cdf[i] = p_0 + ... + p_i`, normalised so that the last word is one. Index `i` is
//! chosen for `cdf[i-1] <= u < cdf[i]`, so an index of zero probability is never chosen, and its probability is the
//! difference of the stored words: sampling and density agree exactly, whatever the rounding of the table.
//! Invariant (tests): `fill_cdf` gives every positive weight a positive probability and every zero weight none.

use super::element;
use super::float::to_index;
use super::select::select;

/// The probability of index `i` in the table at `offset`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn cdf_pmf(data: &[f32], offset: u32, i: u32) -> f32 {
    let upper = element(data, offset + i);
    let lower = if i == 0 {
        0.0
    } else {
        element(data, offset + i - 1)
    };
    upper - lower
}

/// Chooses an index of the table of `count >= 1` words at `offset` with `u` in [0, 1).
///
/// Returns the index, `u` stretched to [0, 1) inside the index's interval, and the index's probability.
#[inline]
pub fn sample_cdf(data: &[f32], offset: u32, count: u32, u: f32) -> (u32, f32, f32) {
    search(data, offset, 0, count - 1, u)
}

/// [`sample_cdf`] for a table with a guide, the [`GUIDE_WORDS`] words at `guide`: the same index, found in constant time
/// where the probabilities do not differ by much.
#[inline]
pub fn sample_cdf_guided(data: &[f32], offset: u32, guide: u32, u: f32) -> (u32, f32, f32) {
    let (low, high) = guided_range(data, guide, u);
    search(data, offset, low, high, u)
}

/// Between which indices of a guided table the one that `u` chooses is.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn guided_range(data: &[f32], guide: u32, u: f32) -> (u32, u32) {
    // Exact: a multiplication by a power of two.
    let cell = to_index(u * GUIDE_CELLS as f32).min(GUIDE_CELLS - 1);
    (
        to_index(element(data, guide + cell)),
        to_index(element(data, guide + cell + 1)),
    )
}

/// The first index from `low` to `high` whose cumulative value is above `u`, or `high`; see [`sample_cdf`].
#[inline]
fn search(data: &[f32], offset: u32, low: u32, high: u32, u: f32) -> (u32, f32, f32) {
    let (mut low, mut high) = (low, high);
    while low < high {
        (low, high) = halved(data, offset, low, high, u);
    }
    let (stretched, pmf) = interval(data, offset, low, u);
    (low, stretched, pmf)
}

/// The half of the indices from `low` to `high`, `low < high`, that holds the first one whose cumulative value is above `u`,
/// or `high`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn halved(data: &[f32], offset: u32, low: u32, high: u32, u: f32) -> (u32, u32) {
    let middle = (low + high) / 2;
    let is_above = element(data, offset + middle) > u;
    (
        select(is_above, low, middle + 1),
        select(is_above, middle, high),
    )
}

/// `u` stretched to [0, 1) inside the interval of the index that it chooses, and the index's probability.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn interval(data: &[f32], offset: u32, index: u32, u: f32) -> (f32, f32) {
    let lower = if index == 0 {
        0.0
    } else {
        element(data, offset + index - 1)
    };
    let pmf = element(data, offset + index) - lower;
    let stretched = if pmf > 0.0 { (u - lower) / pmf } else { 0.0 };
    (stretched.max(0.0).min(ONE_MINUS_EPSILON), pmf)
}

/// Number of equal parts of [0, 1) for which a guide holds the range to search: a power of two.
const GUIDE_CELLS: u32 = 128;

/// Words of a guide: for each of its cells the first index that a number of the cell can choose (Chen and Asau 1974, "On
/// Generating Random Variates from an Empirical Distribution"), and the last index of all. Indices below 2^24 are exact.
pub const GUIDE_WORDS: u32 = GUIDE_CELLS + 1;

/// Fills the guide `out` of the cumulative table `cdf`; host only, as [`fill_cdf`].
#[cfg(not(target_arch = "spirv"))]
pub fn fill_guide(cdf: &[f32], out: &mut [f32]) {
    let last = cdf.len().saturating_sub(1);
    let mut index = 0;
    for (cell, word) in out.iter_mut().enumerate() {
        let start = cell as f32 / GUIDE_CELLS as f32;
        while index < last && cdf[index] <= start {
            index += 1;
        }
        *word = index as f32;
    }
}

/// The largest float below one.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// Turns `weights` into a normalised cumulative table in place and returns the sum of the weights.
///
/// Negative and non-finite weights count as zero. A positive weight is raised to 2^-22 of the sum where it is smaller:
/// below one, `f32` resolves 2^-24, and a probability that rounds to nothing would be a bias. Tables of up to a
/// million entries keep every positive one. If all weights are zero, the table is uniform and the sum is zero.
///
/// Runs on the host only: sums over millions of entries need `f64`, which shaders need not have.
#[cfg(not(target_arch = "spirv"))]
pub fn fill_cdf(weights: &mut [f32]) -> f64 {
    let valid = |w: f32| w > 0.0 && w.is_finite();
    let count = weights.len();
    let total: f64 = weights
        .iter()
        .filter(|w| valid(**w))
        .map(|w| f64::from(*w))
        .sum();
    if total <= 0.0 {
        for (i, w) in weights.iter_mut().enumerate() {
            *w = ((i + 1) as f64 / count as f64) as f32;
        }
        return 0.0;
    }
    let smallest = total / f64::from(1 << 22);
    let raised: f64 = weights
        .iter()
        .filter(|w| valid(**w))
        .map(|w| f64::from(*w).max(smallest))
        .sum();
    let mut sum = 0.0;
    let mut last = 0;
    for i in 0..count {
        if valid(weights[i]) {
            sum += f64::from(weights[i]).max(smallest);
            last = i;
        }
        weights[i] = ((sum / raised) as f32).min(1.0);
    }
    // Rounding must not leave a gap above the last positive weight.
    for w in &mut weights[last..] {
        *w = 1.0;
    }
    total
}
