//! Reconstruction filters: a pixel's value is the mean of the image weighted by the filter around the pixel's centre.
//!
//! Instead of spreading each sample over the pixels around it, samples are drawn from the filter itself (Ernst,
//! Stamminger and Greiner 2006, "Filter Importance Sampling"). Both have the same expectation; drawn samples belong to
//! one pixel only, so pixels stay independent of each other. Where the crop window cuts the filter's support, the rest
//! is renormalised, as in a film that holds samples of the window only.
//!
//! Domain: `x` in pixels from the centre; filters are separable, even, and zero beyond [`radius`]. They need no
//! normalisation: only ratios of integrals are used. Negative lobes give negative weights.
//! Invariant (tests): `E[weight L(offset)]` is the integral of f L over the integral of f on the interval; the weight of
//! a filter without negative lobes is exactly one.
//!
//! For sampling, a filter is a table of its means over `size` equal steps of [-radius, radius] (error of a step's
//! integral: none; of its shape: below 1e-5 of the image at 512 steps). Layout in `data`: `size` words of the integral
//! of |f| up to the end of each step, normalised to one, then `size` words of the integral of f in the same unit, then
//! the guide of the first.

use super::distribution::{GUIDE_WORDS, sample_cdf_guided};
use super::{element, float};
use core::f32::consts::PI;

/// Reconstruction filters.
pub mod filter_kind {
    /// Box, radius `parameters[0]`.
    pub const BOX: u32 = 0;
    /// Tent, radius `parameters[0]`.
    pub const TENT: u32 = 1;
    /// Truncated gaussian, radius and standard deviation, shifted to zero at the radius.
    pub const GAUSSIAN: u32 = 2;
    /// Mitchell-Netravali, radius 2, parameters B and C in `[1]`, `[2]`.
    pub const MITCHELL: u32 = 3;
    /// Catmull-Rom, radius 2.
    pub const CATMULL_ROM: u32 = 4;
    /// Lanczos-windowed sinc, radius `parameters[0]` (lobes).
    pub const LANCZOS: u32 = 5;
}

/// A filter, and the location of its table in `data`.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    /// One of [`filter_kind`].
    pub kind: u32,
    /// See the kinds.
    pub parameters: [f32; 3],
    /// First word of the table.
    pub table: u32,
    /// Number of steps of the table; zero samples the interval uniformly.
    pub table_size: u32,
}

impl Filter {
    /// First word of the guide of the table.
    #[inline]
    pub fn guide(&self) -> u32 {
        self.table + 2 * self.table_size
    }
}

/// Number of steps a front end should tabulate a filter with.
pub const TABLE_SIZE: u32 = 512;

/// Distance from the centre beyond which the filter is zero, in pixels.
#[inline]
pub fn radius(kind: u32, parameters: [f32; 3]) -> f32 {
    if kind == filter_kind::MITCHELL || kind == filter_kind::CATMULL_ROM {
        2.0
    } else {
        parameters[0]
    }
}

/// The filter at distance `x` from the centre.
pub fn eval(kind: u32, parameters: [f32; 3], x: f32) -> f32 {
    let r = radius(kind, parameters);
    let x = float::abs(x);
    if !(x <= r) {
        return 0.0;
    }
    if kind == filter_kind::TENT {
        return 1.0 - x / r;
    }
    if kind == filter_kind::GAUSSIAN {
        let s = parameters[1];
        let scale = -0.5 / (s * s);
        let shifted = float::exp(scale * x * x) - float::exp(scale * r * r);
        return if shifted > 0.0 { shifted } else { 0.0 };
    }
    if kind == filter_kind::MITCHELL {
        return mitchell(x, parameters[1], parameters[2]);
    }
    if kind == filter_kind::CATMULL_ROM {
        return mitchell(x, 0.0, 0.5);
    }
    if kind == filter_kind::LANCZOS {
        return sinc(x) * sinc(x / r);
    }
    1.0
}

/// The two-parameter family of cubics for `x` in [0, 2] (Mitchell and Netravali 1988, "Reconstruction Filters in
/// Computer Graphics", eq. 8).
#[inline]
fn mitchell(x: f32, b: f32, c: f32) -> f32 {
    let x2 = x * x;
    let x3 = x2 * x;
    let sum = if x < 1.0 {
        (12.0 - 9.0 * b - 6.0 * c) * x3 + (-18.0 + 12.0 * b + 6.0 * c) * x2 + (6.0 - 2.0 * b)
    } else {
        (-b - 6.0 * c) * x3
            + (6.0 * b + 30.0 * c) * x2
            + (-12.0 * b - 48.0 * c) * x
            + (8.0 * b + 24.0 * c)
    };
    sum * (1.0 / 6.0)
}

/// sin(pi x) / (pi x).
#[inline]
fn sinc(x: f32) -> f32 {
    let y = PI * x;
    if float::abs(y) < 1e-3 {
        return 1.0 - y * y * (1.0 / 6.0);
    }
    float::sin(y) / y
}

/// The words in `data` that a table of `size` steps takes.
#[inline]
pub fn table_words(size: u32) -> u32 {
    2 * size + GUIDE_WORDS
}

/// A table read between its words: the integral up to `position` steps.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn integral_to(data: &[f32], offset: u32, size: u32, position: f32) -> f32 {
    let i = float::floor(position.max(0.0).min(size as f32));
    let step = float::to_index(i);
    let before = if step == 0 {
        0.0
    } else {
        element(data, offset + step - 1)
    };
    if step >= size {
        return before;
    }
    float::lerp(before, element(data, offset + step), position - i)
}

/// Draws an offset from the pixel's centre within [`lo`, `hi`] with `u` in [0, 1); returns the offset and its weight.
///
/// The interval lies within the filter's radius and holds the pixel. The weight is zero where the filter's integral
/// over the interval is not positive.
pub fn sample(filter: &Filter, data: &[f32], lo: f32, hi: f32, u: f32) -> (f32, f32) {
    if is_uniform(filter) {
        return sample_uniform(lo, hi, u);
    }
    let interval = Interval::new(filter, data, lo, hi);
    if !interval.is_positive() {
        return interval.midpoint();
    }
    let (step, stretched, _) =
        sample_cdf_guided(data, filter.table, filter.guide(), interval.target(u));
    interval.offset_at(filter, data, step, stretched)
}

/// Whether samples are uniform over the interval, without a table.
#[inline]
pub fn is_uniform(filter: &Filter) -> bool {
    let r = radius(filter.kind, filter.parameters);
    filter.kind == filter_kind::BOX || filter.table_size == 0 || !(r > 0.0)
}

/// [`sample`] without a table.
#[inline]
pub fn sample_uniform(lo: f32, hi: f32, u: f32) -> (f32, f32) {
    (float::lerp(lo, hi, u).max(lo).min(hi), 1.0)
}

/// A tabulated filter restricted to an interval.
#[derive(Clone, Copy)]
pub struct Interval {
    lo: f32,
    hi: f32,
    /// Integrals of |f| and of f up to both ends.
    absolute: [f32; 2],
    signed: [f32; 2],
}

impl Interval {
    /// The restriction to [`lo`, `hi`], see [`sample`].
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn new(filter: &Filter, data: &[f32], lo: f32, hi: f32) -> Interval {
        let r = radius(filter.kind, filter.parameters);
        let size = filter.table_size;
        let absolute = filter.table;
        let signed = filter.table + size;
        let steps_per_pixel = size as f32 / (2.0 * r);
        let mut interval = Interval {
            lo,
            hi,
            absolute: [0.0, element(data, absolute + size - 1)],
            signed: [0.0, element(data, signed + size - 1)],
        };
        if lo > -r || hi < r {
            let from = (lo + r) * steps_per_pixel;
            let to = (hi + r) * steps_per_pixel;
            interval.absolute[0] = integral_to(data, absolute, size, from);
            interval.absolute[1] = integral_to(data, absolute, size, to);
            interval.signed[0] = integral_to(data, signed, size, from);
            interval.signed[1] = integral_to(data, signed, size, to);
        }
        interval
    }

    /// Whether the integral over the interval is positive, so that it can be sampled.
    #[inline]
    pub fn is_positive(&self) -> bool {
        self.absolute[1] > self.absolute[0] && self.signed[1] > self.signed[0]
    }

    /// The sample of zero weight where it is not.
    #[inline]
    pub fn midpoint(&self) -> (f32, f32) {
        (0.5 * (self.lo + self.hi), 0.0)
    }

    /// The number by which `u` chooses a step of the table.
    #[inline]
    pub fn target(&self, u: f32) -> f32 {
        float::lerp(self.absolute[0], self.absolute[1], u)
    }

    /// Offset and weight at a position within a step.
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn offset_at(&self, filter: &Filter, data: &[f32], step: u32, position: f32) -> (f32, f32) {
        let r = radius(filter.kind, filter.parameters);
        let size = filter.table_size;
        let signed = filter.table + size;
        let steps_per_pixel = size as f32 / (2.0 * r);
        let offset = (step as f32 + position) / steps_per_pixel - r;
        let before = if step == 0 {
            0.0
        } else {
            element(data, signed + step - 1)
        };
        let is_negative = element(data, signed + step) < before;
        let weight = (self.absolute[1] - self.absolute[0]) / (self.signed[1] - self.signed[0]);
        (
            offset.max(self.lo).min(self.hi),
            if is_negative { -weight } else { weight },
        )
    }
}

/// Integral of the filter over [`lo`, `hi`], in pixels from the centre; Simpson's rule in `f64`.
///
/// Runs on the host only, once per row and column of a film.
#[cfg(not(target_arch = "spirv"))]
pub fn integral(kind: u32, parameters: [f32; 3], lo: f32, hi: f32) -> f64 {
    const PARTS: u32 = 4096;
    let r = radius(kind, parameters);
    let (lo, hi) = (f64::from(lo.max(-r)), f64::from(hi.min(r)));
    let width = (hi - lo) / f64::from(PARTS);
    let mut sum = 0.0;
    for k in 0..=PARTS {
        let weight = if k == 0 || k == PARTS {
            1.0
        } else if k % 2 == 1 {
            4.0
        } else {
            2.0
        };
        let x = (lo + f64::from(k) * width) as f32;
        sum += weight * f64::from(eval(kind, parameters, x.max(-r).min(r)));
    }
    sum * width / 3.0
}

/// Fills the table of a filter; `out` has [`table_words`] of the number of steps.
///
/// Runs on the host only, once per scene: it sums in `f64`.
#[cfg(not(target_arch = "spirv"))]
pub fn fill_table(kind: u32, parameters: [f32; 3], out: &mut [f32]) {
    let size = (out.len() - GUIDE_WORDS as usize) / 2;
    let r = f64::from(radius(kind, parameters));
    // Simpson's rule on eight parts of a step; a step is short against every feature of a filter.
    let step_integral = |step: usize| {
        let width = 2.0 * r / size as f64;
        let mut sum = 0.0;
        for k in 0..=8 {
            let x = -r + (step as f64 + f64::from(k) / 8.0) * width;
            // The end points may round to just outside the support.
            let inside = x.max(-r).min(r) as f32;
            let weight = if k == 0 || k == 8 {
                1.0
            } else if k % 2 == 1 {
                4.0
            } else {
                2.0
            };
            sum += weight * f64::from(eval(kind, parameters, inside));
        }
        sum * width / 24.0
    };
    let mut total = 0.0;
    for i in 0..size {
        total += step_integral(i).abs();
    }
    let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
    let (mut absolute, mut signed) = (0.0, 0.0);
    for i in 0..size {
        let integral = step_integral(i);
        absolute += integral.abs() * scale;
        signed += integral * scale;
        out[i] = absolute.min(1.0) as f32;
        out[size + i] = signed.min(1.0) as f32;
    }
    if size > 0 && total > 0.0 {
        out[size - 1] = 1.0;
    }
    let (tables, guide) = out.split_at_mut(2 * size);
    super::distribution::fill_guide(&tables[..size], guide);
}
