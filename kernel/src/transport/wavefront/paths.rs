//! The states of paths, in lanes.

use super::segment::Segment;
use crate::math::{Ray, Rgb};
use crate::path::Subpath;
use crate::sampler::LaneSampler;
use crate::scene::RayBatch;
use crate::simd::lanes::{Vec3Lanes, gather, round_up_to_vector};
use crate::simd::multiversioned;
use crate::transport::path::Path;
use bytemuck::Zeroable;

/// Up to `N` paths. Their radiance is accumulated elsewhere, at [`PathLanes::index`].
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct PathLanes<const N: usize> {
    /// See [`Subpath`].
    pub rays: RayBatch<N>,
    pub throughput: Vec3Lanes<N>,
    pub eta: [f32; N],
    pub position: Vec3Lanes<N>,
    pub depth: [u32; N],
    pub crossings: [u32; N],
    /// See [`Path`].
    pub last_pdf: [f32; N],
    pub light_samples: [f32; N],
    /// The words of the samplers.
    pub sampler: [[u32; N]; 4],
    /// The number of the path in the wavefront.
    pub index: [u32; N],
}

impl<const N: usize> PathLanes<N> {
    /// Path `i`, without its radiance; the last one if `i` is beyond the end.
    #[inline(always)]
    pub fn gather(&self, i: u32) -> Path {
        Path {
            subpath: Subpath {
                ray: Ray {
                    origin: self.rays.origin.gather(i),
                    direction: self.rays.direction.gather(i),
                    t_min: gather(&self.rays.t_min, i),
                    t_max: gather(&self.rays.t_max, i),
                },
                throughput: self.throughput.gather(i),
                eta: gather(&self.eta, i),
                position: self.position.gather(i),
                depth: gather(&self.depth, i),
                crossings: gather(&self.crossings, i),
            },
            radiance: Rgb::ZERO,
            last_pdf: gather(&self.last_pdf, i),
            light_samples: gather(&self.light_samples, i),
        }
    }

    /// Sets path `i < N`, except for its sampler and its index.
    #[inline(always)]
    pub fn set(&mut self, i: usize, path: &Path) {
        let subpath = &path.subpath;
        self.rays.set(i, &subpath.ray);
        self.throughput.set(i, subpath.throughput);
        self.eta[i] = subpath.eta;
        self.position.set(i, subpath.position);
        self.depth[i] = subpath.depth;
        self.crossings[i] = subpath.crossings;
        self.last_pdf[i] = path.last_pdf;
        self.light_samples[i] = path.light_samples;
    }

    /// The sampler of path `i`; the last one if `i` is beyond the end.
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

/// The paths of a queue: slot `k` of its segment belongs to path `entries[k]`.
#[derive(Clone, Copy)]
pub(super) struct QueuedPaths<'a, const N: usize> {
    pub paths: &'a PathLanes<N>,
    pub entries: &'a [u32; N],
    pub segment: Segment,
}

impl<const N: usize> QueuedPaths<'_, N> {
    /// The number in the wavefront of the path in slot `k < N`.
    #[inline(always)]
    pub fn index(&self, k: usize) -> usize {
        (gather(&self.paths.index, self.entries[k]) as usize).min(N - 1)
    }
}

/// A bounce's results: the paths on their next rays, and which of them continue.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct NextPathLanes<const N: usize> {
    pub paths: PathLanes<N>,
    /// 1 for paths that continue, 0 for those that have ended.
    pub continues: [u32; N],
}

multiversioned! {
    /// Copies the paths at the first `count` entries of `list` to the front of `to`.
    pub(super) fn compact<; const N: usize>(
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
            to.index[k] = gather(&from.index, i);
        }
    }
}
