//! The driver of a wavefront: rays are traced for all paths, then each queue is shaded, bounce by bounce.

use super::bsdf_variant;
use super::camera_rays::FilmLanes;
use super::division::WaveDivision;
use super::paths::{self, NextPathLanes, PathLanes};
use super::queues::{self, ShadingQueues, TracedPaths, queue_of};
use super::shading::{Shaded, ShadingLanes, VariantQueue, VariantShading};
use super::shadow_rays::{self, ShadowRayLanes};
use crate::bsdf::Bsdf;
use crate::math::Rgb;
use crate::path::PathRules;
use crate::path::remainder::Remainder;
use crate::path::visibility::transmittance;
use crate::sampler::LaneSampler;
use crate::scene::{HitBatch, NONE, SceneView, Tables, Traverse, scene_flag};
use crate::simd::SimdLevel;
use crate::transport::bounce::{Rays, bounce, shade};
use crate::transport::path::{SinglePath, step};
use crate::transport::settings::IntegratorSettings;
use bytemuck::Zeroable;
use core::marker::PhantomData;

/// A wavefront of paths in `N` slots, of which [`Wavefront::CAPACITY`] are sure to find one; zeros are an empty wavefront.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub struct Wavefront<S, const N: usize> {
    count: u32,
    film: FilmLanes<N>,
    /// The paths that continue.
    paths: PathLanes<N>,
    hits: HitBatch<N>,
    queues: ShadingQueues<N>,
    /// Results of a bounce, by the slots of the queues.
    shading: ShadingLanes<N>,
    next: NextPathLanes<N>,
    shadow_rays: ShadowRayLanes<N>,
    /// Slots of the paths that continue, or of the shadow rays to be traced.
    list: [u32; N],
    /// The shadow rays without gaps.
    traced: ShadowRayLanes<N>,
    /// Radiance of each path, in the order in which the paths were added.
    radiance: [Rgb; N],
    /// See [`Remainder`].
    remainder: f32,
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
        self.remainder = remainder.scale;
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
            self.paths.set_sampler(first + i as usize, sampler(i));
        }
        let added = first..first + count as usize;
        self.film.pixel[0][added.clone()].fill(pixel[0]);
        self.film.pixel[1][added].fill(pixel[1]);
        self.count += count;
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
        self.run_divided(simd, view, settings, None)
    }

    /// [`Wavefront::run`] that also divides the light of the paths; where nothing counts but the paths of the first
    /// expression, what is returned is that part.
    pub fn run_divided<T: Traverse>(
        &mut self,
        simd: SimdLevel,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        mut division: Option<&mut WaveDivision<'_>>,
    ) -> &[Rgb] {
        let count = self.count as usize;
        self.count = 0;
        let searches = self.shading.searches();
        self.film
            .generate::<S>(simd, &view.tables, count, searches, &mut self.paths);
        self.radiance[..count].fill(Rgb::ZERO);
        if let Some(division) = &mut division {
            division.begin(count);
        }
        let mut active = if settings.rules.max_depth > 0 {
            count
        } else {
            0
        };
        while active > 0 {
            let mut driver = WavefrontBounce {
                wavefront: self,
                simd,
                view,
                settings,
                count: active,
                division: division.as_deref_mut(),
            };
            bounce(&mut driver, WavefrontBounce::shade);
            active = self.compact(simd);
        }
        for k in 0..count {
            self.radiance[k] *= self.film.weight[k];
            if let Some(division) = &mut division {
                self.radiance[k] = division.finish(k, self.film.weight[k]);
            }
        }
        &self.radiance[..count]
    }

    fn shade_escaped(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        division: Option<&mut WaveDivision<'_>>,
    ) {
        let queued = self.queues.queued(queues::ESCAPED, &self.paths);
        if tables.info.environment == NONE || queued.segment.count == 0 {
            return;
        }
        let keep = Remainder {
            scale: self.remainder,
        };
        self.shading
            .shade_escaped(simd, tables, settings, &queued, keep, &mut self.radiance);
        if let Some(division) = division {
            division.escaped(tables, &queued, &mut self.radiance);
        }
    }

    /// The bounce of the paths in the fallback queue, each as a single path takes it.
    #[inline(never)]
    fn shade_one_by_one<T: Traverse>(
        &mut self,
        view: &SceneView<'_, T>,
        rules: PathRules,
        mut division: Option<&mut WaveDivision<'_>>,
    ) {
        let mut bsdf = Bsdf::BLACK;
        let keep = Remainder {
            scale: self.remainder,
        };
        let queued = self.queues.queued(queues::FALLBACK, &self.paths);
        for k in queued.segment.occupied::<N>() {
            let i = queued.entries[k];
            let index = queued.index(k);
            let mut sampler = self.paths.sampler::<S>(i);
            let path = self.paths.gather(i);
            let mut driver = SinglePath::new(view, rules, &mut sampler, &mut bsdf, path);
            driver.hit = self.hits.get((i as usize).min(N - 1));
            let (direction, depth) = (path.subpath.ray.direction, path.subpath.depth);
            shade(&mut driver);
            if let Some(division) = &mut division {
                let expressions = division.expressions;
                let (divided, mixture, parts) = division.path(index);
                divided.shaded(&expressions, mixture, &mut driver, direction, depth, parts);
            }
            let (path, mut shadow_ray) = (driver.path, driver.shadow_ray);
            shadow_ray.radiance = keep.of(shadow_ray.radiance, depth + 2);
            let continues = driver.next != step::END;
            self.radiance[index] += keep.of(path.radiance, depth + 1);
            self.shadow_rays.set(k, &shadow_ray);
            self.shadow_rays.index[k] = index as u32;
            self.next.continues[k] = u32::from(continues);
            self.next.paths.set(k, &path);
            self.next.paths.set_sampler(k, sampler);
            self.next.paths.index[k] = index as u32;
        }
    }

    /// The bounce of the paths in both queues of a BSDF variant.
    fn shade_variant<const VARIANT: u32>(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        rules: PathRules,
        mut division: Option<&mut WaveDivision<'_>>,
    ) {
        for is_textured in [false, true] {
            let queue = queue_of(VARIANT, is_textured);
            let queued = self.queues.queued(queue, &self.paths);
            if queued.segment.count == 0 {
                continue;
            }
            shade(&mut VariantShading::<S, VARIANT, N> {
                simd,
                tables,
                rules,
                keep: Remainder {
                    scale: self.remainder,
                },
                lanes: &mut self.shading,
                queue: VariantQueue {
                    queued,
                    hits: &self.hits,
                    spheres: self.queues.spheres[queue],
                    is_textured,
                },
                shaded: Shaded {
                    next: &mut self.next,
                    shadow_rays: &mut self.shadow_rays,
                    radiance: &mut self.radiance,
                },
                sampler: PhantomData,
            });
            if let Some(division) = &mut division {
                division.shaded::<VARIANT, N>(
                    tables,
                    &queued,
                    &self.shading,
                    &mut self.next,
                    &mut self.shadow_rays,
                    &mut self.radiance,
                );
            }
        }
    }

    /// Adds the emitter samples that are visible.
    fn trace_shadow_rays<T: Traverse>(
        &mut self,
        simd: SimdLevel,
        view: &SceneView<'_, T>,
        mut division: Option<&mut WaveDivision<'_>>,
    ) {
        let mut count = 0;
        for queue in queues::FALLBACK..queues::COUNT {
            let segment = self.queues.segments[queue];
            count = self.shadow_rays.list_lit(segment, &mut self.list, count);
        }
        if count == 0 {
            return;
        }
        shadow_rays::compact(simd, &self.shadow_rays, &self.list, count, &mut self.traced);
        if view.tables.info.flags & scene_flag::HAS_NULL == 0 {
            view.traverse
                .are_occluded(&self.traced.rays, count, &mut self.hits);
            if let Some(division) = division {
                for j in (0..count.min(N)).filter(|j| !self.hits.is_hit(*j)) {
                    let i = (self.traced.index[j] as usize).min(N - 1);
                    division.add_direct(i, self.traced.radiance.get(j));
                }
                return;
            }
            self.traced
                .accumulate(&self.hits, count, &mut self.radiance);
            return;
        }
        for j in 0..count {
            let light = self.traced.radiance.get(j) * transmittance(view, self.traced.rays.get(j));
            let i = (self.traced.index[j] as usize).min(N - 1);
            match &mut division {
                Some(division) => division.add_direct(i, light),
                None => self.radiance[i] += light,
            }
        }
    }

    /// Moves the paths that continue to the front; returns how many there are.
    fn compact(&mut self, simd: SimdLevel) -> usize {
        let mut count = 0;
        for queue in queues::FALLBACK..queues::COUNT {
            for k in self.queues.segments[queue].occupied::<N>() {
                if count < N {
                    self.list[count] = k as u32;
                }
                count += usize::from(self.next.continues[k] != 0);
            }
        }
        let count = count.min(N);
        paths::compact(simd, &self.next.paths, &self.list, count, &mut self.paths);
        count
    }
}

/// The first `count` paths of a wavefront in a bounce.
struct WavefrontBounce<'a, 'd, T: Traverse, S, const N: usize> {
    wavefront: &'a mut Wavefront<S, N>,
    simd: SimdLevel,
    view: &'a SceneView<'a, T>,
    settings: &'a IntegratorSettings,
    count: usize,
    division: Option<&'a mut WaveDivision<'d>>,
}

impl<T: Traverse, S: LaneSampler, const N: usize> Rays for WavefrontBounce<'_, '_, T, S, N> {
    fn trace(&mut self) {
        let (wavefront, view) = (&mut *self.wavefront, self.view);
        view.traverse
            .closest_hits(&wavefront.paths.rays, self.count, &mut wavefront.hits);
        let traced = TracedPaths {
            paths: &wavefront.paths,
            hits: &wavefront.hits,
            count: self.count,
        };
        wavefront
            .queues
            .sort(self.simd, &view.tables, self.settings, &traced);
    }

    fn trace_shadow_rays(&mut self) {
        let division = self.division.as_deref_mut();
        self.wavefront
            .trace_shadow_rays(self.simd, self.view, division);
    }
}

impl<T: Traverse, S: LaneSampler, const N: usize> WavefrontBounce<'_, '_, T, S, N> {
    /// All queues, one after the other.
    fn shade(&mut self) {
        let (simd, tables, rules) = (self.simd, &self.view.tables, self.settings.rules);
        let settings = self.settings;
        self.wavefront
            .shade_escaped(simd, tables, settings, self.division.as_deref_mut());
        self.wavefront
            .shade_one_by_one(self.view, rules, self.division.as_deref_mut());
        macro_rules! shade {
            ($($variant:ident)*) => {$(
                self.wavefront.shade_variant::<{ bsdf_variant::$variant }>(
                    simd, tables, rules, self.division.as_deref_mut(),
                );
            )*};
        }
        shade!(DIFFUSE ROUGH_DIFFUSE CONDUCTOR DIELECTRIC THIN_DIELECTRIC PLASTIC);
        shade!(ROUGH_CONDUCTOR_BECKMANN ROUGH_CONDUCTOR_GGX ROUGH_DIELECTRIC_BECKMANN);
        shade!(ROUGH_DIELECTRIC_GGX ROUGH_PLASTIC_BECKMANN ROUGH_PLASTIC_GGX);
    }
}
