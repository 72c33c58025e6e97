//! The bounce of the paths without loops over lanes, each as a single path takes it.

use super::paths::QueuedPaths;
use super::regularized::RegularizedLanes;
use super::shading::Shaded;
use crate::bsdf::Bsdf;
use crate::path::PathRules;
use crate::path::remainder::Remainder;
use crate::sampler::LaneSampler;
use crate::scene::{HitBatch, SceneView, Traverse};
use crate::transport::bounce::shade;
use crate::transport::connection::ShadowRay;
use crate::transport::path::{Path, SinglePath, step};
use crate::transport::regularized_path::{Adaptive, RegularizedPath};
use crate::transport::regularized_share::RegularizedShare;
use crate::transport::wavefront::WaveDivision;

/// The fallback queue.
pub(super) struct Fallback<'a, const N: usize> {
    pub queued: QueuedPaths<'a, N>,
    /// What the paths, by their own indices, have met.
    pub hits: &'a HitBatch<N>,
    pub keep: Remainder,
    pub shaded: Shaded<'a, N>,
}

impl<const N: usize> Fallback<'_, N> {
    /// Shades the paths and divides their light.
    #[inline(never)]
    pub fn shade<S: LaneSampler, T: Traverse>(
        &mut self,
        view: &SceneView<'_, T>,
        rules: PathRules,
        mut division: Option<&mut WaveDivision<'_>>,
    ) {
        let mut bsdf = Bsdf::BLACK;
        for k in self.queued.segment.occupied::<N>() {
            let i = self.queued.entries[k];
            let mut sampler = self.queued.paths.sampler::<S>(i);
            let path = self.queued.paths.gather(i);
            let mut driver = SinglePath::new(view, rules, &mut sampler, &mut bsdf, path);
            driver.hit = self.hits.get((i as usize).min(N - 1));
            let (direction, depth) = (path.subpath.ray.direction, path.subpath.depth);
            shade(&mut driver);
            if let Some(division) = &mut division {
                let expressions = division.expressions();
                let (divided, mixture, parts) = division.path(self.queued.index(k));
                divided.shaded(&expressions, mixture, &mut driver, direction, depth, parts);
            }
            let (path, shadow_ray, next) = (driver.path, driver.shadow_ray, driver.next);
            self.set(k, depth, &path, shadow_ray, next);
            self.shaded.next.paths.set_sampler(k, sampler);
        }
    }

    /// Shades paths whose connections are regularised.
    #[inline(never)]
    pub fn shade_regularized<S: LaneSampler, T: Traverse>(
        &mut self,
        view: &SceneView<'_, T>,
        rules: PathRules,
        own: &mut RegularizedLanes<N>,
    ) {
        let mut bsdf = Bsdf::BLACK;
        for k in self.queued.segment.occupied::<N>() {
            let i = self.queued.entries[k];
            let mut sampler = self.queued.paths.sampler::<S>(i);
            let path = self.queued.paths.gather(i);
            let depth = path.subpath.depth;
            let mut light = (ShadowRay::NONE, RegularizedShare::NONE);
            let mut single = SinglePath::new(view, rules, &mut sampler, &mut bsdf, path);
            single.hit = self.hits.get((i as usize).min(N - 1));
            // One emitter is sampled, hence there is one shadow ray.
            let set = |ray: &ShadowRay, share| light = (*ray, share);
            let regularization = own.of_path[self.queued.index(k)];
            let mut driver = RegularizedPath::new(single, regularization, Adaptive::START, set);
            shade(&mut driver);
            let (path, next) = (driver.single.path, driver.single.next);
            own.set_share(k, light.1);
            self.set(k, depth, &path, light.0, next);
            self.shaded.next.paths.set_sampler(k, sampler);
        }
    }

    /// The results of slot `k`, a path that had `depth` edges before, but for its sampler.
    fn set(&mut self, k: usize, depth: u32, path: &Path, shadow_ray: ShadowRay, next: u32) {
        let index = self.queued.index(k);
        let mut shadow_ray = shadow_ray;
        shadow_ray.radiance = self.keep.of(shadow_ray.radiance, depth + 2);
        let shaded = &mut self.shaded;
        shaded.radiance[index] += self.keep.of(path.radiance, depth + 1);
        shaded.shadow_rays.set(k, &shadow_ray);
        shaded.shadow_rays.index[k] = index as u32;
        shaded.next.continues[k] = u32::from(next != step::END);
        shaded.next.paths.set(k, path);
        shaded.next.paths.index[k] = index as u32;
    }
}
