//! Rays from the sensor, side by side: [`super::super::sensor_ray`].

use super::paths::PathLanes;
use super::search::{SearchLanes, search};
use super::segment::Segment;
use crate::math::distribution::guided_range;
use crate::math::filter::{Cut, even_sample, is_even};
use crate::math::vectors::{Vectors, over_lanes};
use crate::sampler::LaneSampler;
use crate::scene::Tables;
use crate::scene::camera::{Support, ray_through};
use crate::transport::path::Path;
use bytemuck::Zeroable;
use glam::Vec2;

/// The film positions of `N` paths.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct FilmLanes<const N: usize> {
    /// The pixels.
    pub pixel: [[u32; N]; 2],
    /// The numbers that choose the film and the lens position.
    numbers: [[f32; N]; 4],
    film: [[f32; N]; 2],
    /// The reconstruction weights.
    pub weight: [f32; N],
}

impl<const N: usize> FilmLanes<N> {
    /// Begins the first `count` paths, whose samplers and pixels are set.
    pub fn begin<S: LaneSampler>(
        &mut self,
        vectors: Vectors,
        tables: &Tables<'_>,
        count: usize,
        searches: &mut SearchLanes<N>,
        paths: &mut PathLanes<N>,
    ) {
        let segment = Segment { first: 0, count };
        draw::<S, N>(vectors, segment, paths, &mut self.numbers, &mut self.weight);
        self.place::<0>(vectors, tables, segment, searches);
        self.place::<1>(vectors, tables, segment, searches);
        send(vectors, tables, segment, &self.film, &self.numbers, paths);
    }

    /// Film coordinates along an axis.
    fn place<const AXIS: usize>(
        &mut self,
        vectors: Vectors,
        tables: &Tables<'_>,
        segment: Segment,
        searches: &mut SearchLanes<N>,
    ) {
        let (pixel, u) = (&self.pixel[AXIS], &self.numbers[AXIS]);
        let (film, weight) = (&mut self.film[AXIS], &mut self.weight);
        if is_even(&tables.camera) {
            evenly::<AXIS, N>(vectors, tables, segment, pixel, u, film, weight);
        } else {
            aim::<AXIS, N>(vectors, tables, segment, pixel, u, searches);
            search(vectors, tables.data, segment, searches);
            hit::<AXIS, N>(vectors, tables, segment, pixel, searches, film, weight);
        }
    }
}

over_lanes! {
    /// Draws the numbers.
    fn draw<S: LaneSampler; const N: usize>(
        segment: Segment,
        paths: &mut PathLanes<N>,
        numbers: &mut [[f32; N]; 4],
        weight: &mut [f32; N],
    ) {
        for k in segment.slots::<N>() {
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

    /// Film coordinates of filters without a table.
    fn evenly<; const AXIS: usize, const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        pixel: &[u32; N],
        u: &[f32; N],
        film: &mut [f32; N],
        weight: &mut [f32; N],
    ) {
        for k in segment.slots::<N>() {
            let support = Support::new::<AXIS>(&tables.camera, pixel[k]);
            let (offset, factor) = even_sample(support.lo, support.hi, u[k]);
            let (at, factor) = if support.is_empty() {
                support.outside()
            } else {
                (support.center + offset, factor)
            };
            film[k] = at;
            weight[k] *= factor;
        }
    }

    /// Begins to search the filter's table.
    fn aim<; const AXIS: usize, const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        pixel: &[u32; N],
        u: &[f32; N],
        searches: &mut SearchLanes<N>,
    ) {
        let camera = &tables.camera;
        let guide = camera.filter_table + 2 * camera.filter_table_size;
        for k in segment.slots::<N>() {
            let support = Support::new::<AXIS>(camera, pixel[k]);
            let cut = Cut::new(camera, tables.data, support.lo, support.hi);
            let target = cut.target(u[k]);
            let (low, high) = guided_range(tables.data, guide, target);
            searches.set(k, camera.filter_table, target, low, high);
        }
    }

    /// Film coordinates where the searches ended.
    fn hit<; const AXIS: usize, const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        pixel: &[u32; N],
        searches: &SearchLanes<N>,
        film: &mut [f32; N],
        weight: &mut [f32; N],
    ) {
        let camera = &tables.camera;
        for k in segment.slots::<N>() {
            let support = Support::new::<AXIS>(camera, pixel[k]);
            let cut = Cut::new(camera, tables.data, support.lo, support.hi);
            let (step, position, _) = searches.found(tables.data, k);
            let (offset, factor) = if cut.is_positive() {
                cut.at(camera, tables.data, step, position)
            } else {
                cut.middle()
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

    /// The rays.
    fn send<; const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        film: &[[f32; N]; 2],
        numbers: &[[f32; N]; 4],
        paths: &mut PathLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let film = Vec2::new(film[0][k], film[1][k]);
            let lens = Vec2::new(numbers[2][k], numbers[3][k]);
            let ray = ray_through(&tables.camera, film, lens);
            paths.set(k, &Path::new(&ray));
            paths.place[k] = k as u32;
        }
    }
}
