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
use super::float;
use crate::scene::{Camera, filter_kind};
use core::f32::consts::PI;

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
#[inline]
fn integral_to(data: &[f32], offset: u32, size: u32, position: f32) -> f32 {
    let i = float::floor(position.max(0.0).min(size as f32));
    let step = i as u32;
    let before = if step == 0 {
        0.0
    } else {
        data[(offset + step - 1) as usize]
    };
    if step >= size {
        return before;
    }
    float::lerp(before, data[(offset + step) as usize], position - i)
}

/// Draws an offset from the pixel's centre within [`lo`, `hi`] with `u` in [0, 1); returns the offset and its weight.
///
/// The interval lies within the filter's radius and holds the pixel. The weight is zero where the filter's integral
/// over the interval is not positive.
pub fn sample(camera: &Camera, data: &[f32], lo: f32, hi: f32, u: f32) -> (f32, f32) {
    let r = radius(camera.filter, camera.filter_parameters);
    let size = camera.filter_table_size;
    if camera.filter == filter_kind::BOX || size == 0 || !(r > 0.0) {
        return (float::lerp(lo, hi, u).max(lo).min(hi), 1.0);
    }
    let absolute = camera.filter_table;
    let signed = camera.filter_table + size;
    let steps_per_pixel = size as f32 / (2.0 * r);
    let (mut a0, mut a1) = (0.0, data[(absolute + size - 1) as usize]);
    let (mut s0, mut s1) = (0.0, data[(signed + size - 1) as usize]);
    if lo > -r || hi < r {
        let from = (lo + r) * steps_per_pixel;
        let to = (hi + r) * steps_per_pixel;
        a0 = integral_to(data, absolute, size, from);
        a1 = integral_to(data, absolute, size, to);
        s0 = integral_to(data, signed, size, from);
        s1 = integral_to(data, signed, size, to);
    }
    if !(a1 > a0) || !(s1 > s0) {
        return (0.5 * (lo + hi), 0.0);
    }
    let target = float::lerp(a0, a1, u);
    let (step, stretched, _) = sample_cdf_guided(data, absolute, signed + size, target);
    let offset = (step as f32 + stretched) / steps_per_pixel - r;
    let before = if step == 0 {
        0.0
    } else {
        data[(signed + step - 1) as usize]
    };
    let is_negative = data[(signed + step) as usize] < before;
    let weight = (a1 - a0) / (s1 - s0);
    (
        offset.max(lo).min(hi),
        if is_negative { -weight } else { weight },
    )
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
