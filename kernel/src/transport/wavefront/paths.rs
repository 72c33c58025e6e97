//! The state of many paths, side by side.

use super::super::path::{Path, Scattering};
use crate::math::Rgb;
use crate::sampler::LaneSampler;
use crate::scene::RayBatch;
use crate::simd::lanes::{Vec3Lanes, gather, round_up_to_vector};
use crate::simd::multiversioned;
use bytemuck::Zeroable;

/// Up to `N` paths; what they have gathered is kept by [`PathLanes::place`].
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct PathLanes<const N: usize> {
    /// See [`Path::ray`].
    pub rays: RayBatch<N>,
    /// See [`Path::throughput`].
    pub throughput: Vec3Lanes<N>,
    /// See [`Path::eta`].
    pub eta: [f32; N],
    /// See [`Scattering`].
    pub last_position: Vec3Lanes<N>,
    pub last_pdf: [f32; N],
    pub last_light_samples: [f32; N],
    /// See [`Path::depth`].
    pub depth: [u32; N],
    /// See [`Path::crossings`].
    pub crossings: [u32; N],
    /// The words of the paths' samplers.
    pub sampler: [[u32; N]; 4],
    /// Which of the wave's paths it is.
    pub place: [u32; N],
}

impl<const N: usize> PathLanes<N> {
    /// Path `i`, the last one beyond the end, with no light gathered.
    #[inline(always)]
    pub fn gather(&self, i: u32) -> Path {
        Path {
            ray: crate::math::Ray {
                origin: self.rays.origin.gather(i),
                direction: self.rays.direction.gather(i),
                t_min: gather(&self.rays.t_min, i),
                t_max: gather(&self.rays.t_max, i),
            },
            radiance: Rgb::ZERO,
            throughput: self.throughput.gather(i),
            eta: gather(&self.eta, i),
            last: Scattering {
                position: self.last_position.gather(i),
                pdf: gather(&self.last_pdf, i),
                light_samples: gather(&self.last_light_samples, i),
            },
            depth: gather(&self.depth, i),
            crossings: gather(&self.crossings, i),
        }
    }

    /// Sets path `i < N` but for its sampler and its place.
    #[inline(always)]
    pub fn set(&mut self, i: usize, path: &Path) {
        self.rays.set(i, &path.ray);
        self.throughput.set(i, path.throughput);
        self.eta[i] = path.eta;
        self.last_position.set(i, path.last.position);
        self.last_pdf[i] = path.last.pdf;
        self.last_light_samples[i] = path.last.light_samples;
        self.depth[i] = path.depth;
        self.crossings[i] = path.crossings;
    }

    /// The sampler of path `i`, the last one beyond the end.
    #[inline(always)]
    pub fn sampler<S: LaneSampler>(&self, i: u32) -> S {
        let [a, b, c, d] = &self.sampler;
        S::from_words([gather(a, i), gather(b, i), gather(c, i), gather(d, i)])
    }

    /// The sampler of path `i < N`.
    #[inline(always)]
    pub fn sampler_at<S: LaneSampler>(&self, i: usize) -> S {
        let [a, b, c, d] = &self.sampler;
        S::from_words([a[i], b[i], c[i], d[i]])
    }

    /// Sets the sampler of path `i < N`.
    #[inline(always)]
    pub fn set_sampler<S: LaneSampler>(&mut self, i: usize, sampler: S) {
        let words = sampler.to_words();
        self.sampler[0][i] = words[0];
        self.sampler[1][i] = words[1];
        self.sampler[2][i] = words[2];
        self.sampler[3][i] = words[3];
    }
}

multiversioned! {
    /// Makes `to` the first `count` paths of `list`.
    pub(super) fn take<; const N: usize>(
        from: &PathLanes<N>,
        list: &[u32; N],
        count: usize,
        to: &mut PathLanes<N>,
    ) {
        for k in 0..round_up_to_vector::<N>(count) {
            let i = gather(list, k as u32);
            to.set(k, &from.gather(i));
            to.sampler[0][k] = gather(&from.sampler[0], i);
            to.sampler[1][k] = gather(&from.sampler[1], i);
            to.sampler[2][k] = gather(&from.sampler[2], i);
            to.sampler[3][k] = gather(&from.sampler[3], i);
            to.place[k] = gather(&from.place, i);
        }
    }
}
