//! Camera rays in lanes: [`camera_ray`](crate::transport::camera_ray).
//!
//! Film positions are drawn from the reconstruction filter one axis after the other: uniformly over its support, or by a
//! search in its table.

use super::cdf_search::{SearchLanes, search};
use super::paths::PathLanes;
use super::segment::Segment;
use crate::math::distribution::guided_range;
use crate::math::filter::{Interval, is_uniform, sample_uniform};
use crate::sampler::LaneSampler;
use crate::scene::camera::{Support, projective_ray};
use crate::scene::{Tables, camera_kind, irradiance_meter, spherical_camera};
use crate::simd::{SimdLevel, multiversioned};
use crate::transport::path::Path;
use bytemuck::Zeroable;
use glam::Vec2;

/// The film positions of `N` paths.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct FilmLanes<const N: usize> {
    /// Pixels, in absolute film coordinates.
    pub pixel: [[u32; N]; 2],
    /// Random numbers: two for the film position, two for the lens.
    numbers: [[f32; N]; 4],
    /// Film positions.
    film: [[f32; N]; 2],
    /// The reconstruction weights.
    pub weight: [f32; N],
}

impl<const N: usize> FilmLanes<N> {
    /// Starts the first `count` paths, whose samplers and pixels are set, on their camera rays.
    pub fn generate<S: LaneSampler>(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        count: usize,
        searches: &mut SearchLanes<N>,
        paths: &mut PathLanes<N>,
    ) {
        let segment = Segment { first: 0, count };
        draw_numbers::<S, N>(simd, segment, paths, &mut self.numbers, &mut self.weight);
        self.sample_axis::<0>(simd, tables, segment, searches);
        self.sample_axis::<1>(simd, tables, segment, searches);
        match tables.camera.kind {
            camera_kind::SPHERICAL => self.generate_spherical_rays(tables, segment, paths),
            camera_kind::IRRADIANCE_METER => self.generate_meter_rays(tables, segment, paths),
            _ => generate_rays(simd, tables, segment, &self.film, &self.numbers, paths),
        }
    }

    /// Rays of a panoramic camera, one after the other.
    fn generate_spherical_rays(
        &self,
        tables: &Tables<'_>,
        segment: Segment,
        paths: &mut PathLanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let film = Vec2::new(self.film[0][k], self.film[1][k]);
            let ray = spherical_camera::ray(&tables.camera, film);
            paths.set(k, &Path::new(&ray));
            paths.index[k] = k as u32;
        }
    }

    /// Rays of a meter, one after the other.
    fn generate_meter_rays(
        &mut self,
        tables: &Tables<'_>,
        segment: Segment,
        paths: &mut PathLanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let film = Vec2::new(self.film[0][k], self.film[1][k]);
            let direction = Vec2::new(self.numbers[2][k], self.numbers[3][k]);
            let (ray, _) = irradiance_meter::ray(tables, film, direction);
            self.weight[k] *= irradiance_meter::RESPONSE;
            paths.set(k, &Path::new(&ray));
            paths.index[k] = k as u32;
        }
    }

    /// Samples the film positions along an axis.
    fn sample_axis<const AXIS: usize>(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        segment: Segment,
        searches: &mut SearchLanes<N>,
    ) {
        let (pixel, u) = (&self.pixel[AXIS], &self.numbers[AXIS]);
        let (film, weight) = (&mut self.film[AXIS], &mut self.weight);
        if is_uniform(&tables.camera.reconstruction_filter()) {
            sample_uniformly::<AXIS, N>(simd, tables, segment, pixel, u, film, weight);
        } else {
            begin_search::<AXIS, N>(simd, tables, segment, pixel, u, searches);
            search(simd, tables.data, segment, searches);
            finish_search::<AXIS, N>(simd, tables, segment, pixel, searches, film, weight);
        }
    }
}

multiversioned! {
    /// Draws the random numbers.
    fn draw_numbers<S: LaneSampler; const N: usize>(
        segment: Segment,
        paths: &mut PathLanes<N>,
        numbers: &mut [[f32; N]; 4],
        weight: &mut [f32; N],
    ) {
        for k in segment.padded::<N>() {
            let mut sampler = paths.sampler_at::<S>(k);
            let film = sampler.next_2d();
            let lens = sampler.next_2d();
            numbers[0][k] = film.x;
            numbers[1][k] = film.y;
            numbers[2][k] = lens.x;
            numbers[3][k] = lens.y;
            paths.set_sampler(k, sampler);
            weight[k] = 1.0;
        }
    }

    /// Film positions of filters without a table.
    fn sample_uniformly<; const AXIS: usize, const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        pixel: &[u32; N],
        u: &[f32; N],
        film: &mut [f32; N],
        weight: &mut [f32; N],
    ) {
        for k in segment.padded::<N>() {
            let support = Support::new::<AXIS>(&tables.camera, pixel[k]);
            let (offset, factor) = sample_uniform(support.lo, support.hi, u[k]);
            let (at, factor) = if support.is_empty() {
                support.outside()
            } else {
                (support.center + offset, factor)
            };
            film[k] = at;
            weight[k] *= factor;
        }
    }

    /// Begins the searches in the table of the filter.
    fn begin_search<; const AXIS: usize, const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        pixel: &[u32; N],
        u: &[f32; N],
        searches: &mut SearchLanes<N>,
    ) {
        let camera = &tables.camera;
        let filter = camera.reconstruction_filter();
        let guide = filter.guide();
        for k in segment.padded::<N>() {
            let support = Support::new::<AXIS>(camera, pixel[k]);
            let interval = Interval::new(&filter, tables.data, support.lo, support.hi);
            let target = interval.target(u[k]);
            let (low, high) = guided_range(tables.data, guide, target);
            searches.set(k, filter.table, target, low, high);
        }
    }

    /// Film positions from the results of the searches.
    fn finish_search<; const AXIS: usize, const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        pixel: &[u32; N],
        searches: &SearchLanes<N>,
        film: &mut [f32; N],
        weight: &mut [f32; N],
    ) {
        let camera = &tables.camera;
        let filter = camera.reconstruction_filter();
        for k in segment.padded::<N>() {
            let support = Support::new::<AXIS>(camera, pixel[k]);
            let interval = Interval::new(&filter, tables.data, support.lo, support.hi);
            let (step, position, _) = searches.found(tables.data, k);
            let (offset, factor) = if interval.is_positive() {
                interval.offset_at(&filter, tables.data, step, position)
            } else {
                interval.midpoint()
            };
            let (at, factor) = if support.is_empty() {
                support.outside()
            } else {
                (support.center + offset, factor)
            };
            film[k] = at;
            weight[k] *= factor;
        }
    }

    /// Rays through the film positions.
    fn generate_rays<; const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        film: &[[f32; N]; 2],
        numbers: &[[f32; N]; 4],
        paths: &mut PathLanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let film = Vec2::new(film[0][k], film[1][k]);
            let lens = Vec2::new(numbers[2][k], numbers[3][k]);
            let ray = projective_ray(&tables.camera, film, lens);
            paths.set(k, &Path::new(&ray));
            paths.index[k] = k as u32;
        }
    }
}
