//! A wavefront of paths: adding them, and tracing them to their ends bounce by bounce.

use super::camera_rays::FilmLanes;
use super::division::WaveDivision;
use super::queues::ShadingQueues;
use super::wave_bounce::{Mode, WaveState, WavefrontBounce};
use crate::math::Rgb;
use crate::path::remainder::Remainder;
use crate::regularize::settings::Regularization;
use crate::sampler::LaneSampler;
use crate::scene::{SceneView, Traverse};
use crate::simd::SimdLevel;
use crate::transport::bounce::bounce;
use crate::transport::settings::IntegratorSettings;
use bytemuck::Zeroable;
use core::marker::PhantomData;

/// A wavefront of paths in `N` slots, of which [`Wavefront::CAPACITY`] are sure to find one; zeros are an empty wavefront.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub struct Wavefront<S, const N: usize> {
    count: u32,
    film: FilmLanes<N>,
    state: WaveState<N>,
    sampler: PhantomData<S>,
}

impl<S: LaneSampler, const N: usize> Wavefront<S, N> {
    /// The most paths that are sure to find a slot each.
    pub const CAPACITY: usize = ShadingQueues::<N>::capacity();

    /// Whether there is no space for another path.
    pub fn is_full(&self) -> bool {
        self.count as usize >= Self::CAPACITY
    }

    /// From now on paths keep what the remainder says of all that they gather.
    pub fn keep(&mut self, remainder: Remainder) {
        self.state.remainder = remainder.scale;
    }

    /// Adds a sample of the pixel at absolute film coordinates, if there is space; the numbers of the sampler are those of
    /// [`sample_pixel`](crate::transport::sample_pixel).
    pub fn push(&mut self, pixel: [u32; 2], sampler: S) {
        self.push_samples(pixel, 1, |_| sampler);
    }

    /// Adds samples 0, 1, ... of a pixel with the samplers of their numbers, as many of `count` as fit; returns
    /// how many.
    #[inline]
    pub fn push_samples(&mut self, pixel: [u32; 2], count: u32, sampler: impl Fn(u32) -> S) -> u32 {
        let first = (self.count as usize).min(Self::CAPACITY);
        let count = count.min((Self::CAPACITY - first) as u32);
        for i in 0..count {
            self.state.paths.set_sampler(first + i as usize, sampler(i));
        }
        let added = first..first + count as usize;
        self.film.pixel[0][added.clone()].fill(pixel[0]);
        self.film.pixel[1][added].fill(pixel[1]);
        self.count += count;
        count
    }

    /// [`Wavefront::push_samples`] of paths whose connections are regularised, each by that of its sample.
    pub fn push_regularized(
        &mut self,
        pixel: [u32; 2],
        count: u32,
        sampler: impl Fn(u32) -> S,
        mut regularization: impl FnMut(u32) -> Regularization,
    ) -> u32 {
        let first = self.count as usize;
        let count = self.push_samples(pixel, count, sampler);
        for i in 0..count {
            self.state
                .regularized
                .begin(first + i as usize, regularization(i));
        }
        count
    }

    /// Traces the paths to their ends. Returns [`sample_pixel`](crate::transport::sample_pixel) of each, in the order in
    /// which they were added, and leaves the wavefront empty.
    pub fn run<T: Traverse>(
        &mut self,
        simd: SimdLevel,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
    ) -> &[Rgb] {
        let count = self.trace(simd, view, settings, Mode::Plain);
        &self.state.radiance[..count]
    }

    /// [`Wavefront::run`] that also divides the light of the paths; where nothing counts but the paths of the first
    /// expression, what is returned is that part.
    pub fn run_divided<T: Traverse>(
        &mut self,
        simd: SimdLevel,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        division: &mut WaveDivision<'_>,
    ) -> &[Rgb] {
        let count = self.trace(simd, view, settings, Mode::Divided(division));
        &self.state.radiance[..count]
    }

    /// [`Wavefront::run`] of paths whose connections are regularised, each as [`Wavefront::push_regularized`] was told. Returns
    /// what [`crate::transport::regularized_path::radiance`] finds times the weights of the samples, and of what is
    /// regularised of each the luminance and that times the logarithm of tau or of the radius.
    ///
    /// The settings are none that [follow paths](crate::regularize::settings::RegularizationSettings::follows_paths).
    pub fn run_regularized<T: Traverse>(
        &mut self,
        simd: SimdLevel,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
    ) -> (&[Rgb], &[[f32; 2]]) {
        let count = self.trace(simd, view, settings, Mode::Regularized);
        let shares = self.state.regularized.finish(count, &self.film.weight);
        (&self.state.radiance[..count], shares)
    }

    /// Traces the paths to their ends; returns how many there are.
    fn trace<T: Traverse>(
        &mut self,
        simd: SimdLevel,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        mut mode: Mode<'_, '_>,
    ) -> usize {
        let count = self.count as usize;
        self.count = 0;
        let searches = self.state.shading.searches();
        self.film
            .generate::<S>(simd, &view.tables, count, searches, &mut self.state.paths);
        self.state.radiance[..count].fill(Rgb::ZERO);
        match &mut mode {
            Mode::Plain => {}
            Mode::Divided(division) => division.begin(count),
            Mode::Regularized => self.state.regularized.pending.fill(0),
        }
        let mut active = if settings.rules.max_depth > 0 {
            count
        } else {
            0
        };
        while active > 0 {
            let mut driver = WavefrontBounce {
                state: &mut self.state,
                sampler: PhantomData::<S>,
                simd,
                view,
                settings,
                count: active,
                mode: &mut mode,
            };
            bounce(&mut driver, WavefrontBounce::shade);
            active = self.state.compact(simd);
        }
        for k in 0..count {
            self.state.radiance[k] *= self.film.weight[k];
            if let Mode::Divided(division) = &mut mode {
                self.state.radiance[k] = division.finish(k, self.film.weight[k]);
            }
        }
        count
    }
}
