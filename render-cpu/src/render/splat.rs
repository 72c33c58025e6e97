//! Splats: light that arrives anywhere on the film, spread by the reconstruction filter.
//!
//! A splat at film position x adds `value f(x - c_j) / integral of f` to the sum of every pixel j, c_j its centre and the
//! integral over what the crop window leaves of the filter's support: what a sample drawn from the filter estimates for the
//! pixel (see [`halflight_kernel::math::filter`]).

use glam::Vec2;
use halflight_kernel::math::{Rgb, filter};
use halflight_kernel::scene::camera::Support;
use halflight_kernel::scene::{Camera, filter_kind};
use std::ops::AddAssign;

/// Light at a film position.
#[derive(Clone, Copy, Debug)]
pub struct Splat {
    /// In pixels of the whole film.
    pub film: Vec2,
    /// What it adds to the mean of a pixel with a filter of area one.
    pub value: Rgb,
}

/// The weights of splats in the pixels around them.
#[derive(Clone, Debug)]
pub struct SplatFilter {
    kind: u32,
    parameters: [f32; 3],
    radius: f32,
    offset: [u32; 2],
    size: [u32; 2],
    /// One over the integral of the filter, by column and by row of the window.
    scale: [Vec<f32>; 2],
    /// Whether a splat belongs to the pixel that holds it, and to no other.
    is_pixel: bool,
}

impl SplatFilter {
    /// Of a sensor.
    pub fn new(camera: &Camera) -> SplatFilter {
        let scale = [axis::<0>(camera), axis::<1>(camera)];
        let radius = filter::radius(camera.filter, camera.filter_parameters);
        SplatFilter {
            kind: camera.filter,
            parameters: camera.filter_parameters,
            radius,
            offset: camera.crop_offset,
            size: camera.crop_size,
            scale,
            is_pixel: camera.filter == filter_kind::BOX && radius == 0.5,
        }
    }

    /// A film position from the window's corner on.
    pub fn in_window(&self, film: Vec2) -> Vec2 {
        film - Vec2::new(self.offset[0] as f32, self.offset[1] as f32)
    }

    /// Rows of the window that a splat reaches.
    pub fn rows(&self, splat: &Splat) -> std::ops::Range<u32> {
        self.reach(1, splat.film.y)
    }

    fn reach(&self, axis: usize, x: f32) -> std::ops::Range<u32> {
        let x = x - self.offset[axis] as f32;
        let (first, last) = if self.is_pixel {
            (x.floor(), x.floor())
        } else {
            (
                (x - 0.5 - self.radius).ceil(),
                (x - 0.5 + self.radius).floor(),
            )
        };
        let size = self.size[axis];
        // Casts saturate: what lies outside gives an empty range.
        let start = (first.max(0.0) as u32).min(size);
        let end = ((last + 1.0).max(0.0) as u32).min(size);
        start..end.max(start)
    }

    fn weight(&self, axis: usize, pixel: u32, x: f32) -> f32 {
        if self.is_pixel {
            return 1.0;
        }
        let center = (self.offset[axis] + pixel) as f32 + 0.5;
        filter::eval(self.kind, self.parameters, x - center) * self.scale[axis][pixel as usize]
    }

    /// Adds a splat to the pixels of the rows from `first_row` on that `sums` holds.
    pub fn add<F: AddAssign + From<f32>>(
        &self,
        splat: &Splat,
        first_row: u32,
        sums: &mut [[F; 3]],
    ) {
        let width = self.size[0];
        let end_row = first_row + sums.len() as u32 / width;
        let rows = self.rows(splat);
        for y in rows.start.max(first_row)..rows.end.min(end_row) {
            let weight_y = self.weight(1, y, splat.film.y);
            for x in self.reach(0, splat.film.x) {
                let value = splat.value * (self.weight(0, x, splat.film.x) * weight_y);
                let sum = &mut sums[((y - first_row) * width + x) as usize];
                for c in 0..3 {
                    sum[c] += F::from(value[c]);
                }
            }
        }
    }
}

/// One over the integral of the filter around each pixel of an axis; zero where that is not positive.
fn axis<const AXIS: usize>(camera: &Camera) -> Vec<f32> {
    let mut last = (f32::NAN, f32::NAN, 0.0);
    (0..camera.crop_size[AXIS])
        .map(|i| {
            let support = Support::new::<AXIS>(camera, camera.crop_offset[AXIS] + i);
            // All but those at the window's rim are the same.
            if (support.lo, support.hi) != (last.0, last.1) {
                let integral = filter::integral(
                    camera.filter,
                    camera.filter_parameters,
                    support.lo,
                    support.hi,
                );
                let scale = if integral > 0.0 { 1.0 / integral } else { 0.0 };
                last = (support.lo, support.hi, scale as f32);
            }
            last.2
        })
        .collect()
}
