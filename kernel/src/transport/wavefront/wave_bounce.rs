//! A bounce of a wavefront: rays are traced for all paths, then each queue is shaded.

use super::bsdf_variant;
use super::division::WaveDivision;
use super::fallback::Fallback;
use super::paths::{self, NextPathLanes, PathLanes};
use super::queues::{self, ShadingQueues, TracedPaths, queue_of};
use super::regularized::{RegularizedLanes, may_be_raised};
use super::shading::{Shaded, ShadingLanes, VariantQueue, VariantShading};
use super::shadow_rays::{self, ShadowRayLanes};
use crate::math::Rgb;
use crate::path::PathRules;
use crate::path::remainder::Remainder;
use crate::path::visibility::transmittance;
use crate::sampler::LaneSampler;
use crate::scene::{HitBatch, NONE, SceneView, Tables, Traverse, scene_flag};
use crate::simd::SimdLevel;
use crate::transport::bounce::{Rays, shade};
use crate::transport::settings::IntegratorSettings;
use bytemuck::Zeroable;
use core::marker::PhantomData;

/// What is kept of the paths beside their radiance.
pub(super) enum Mode<'a, 'd> {
    Plain,
    /// Parts by path expressions.
    Divided(&'a mut WaveDivision<'d>),
    /// Their regularisation.
    Regularized,
}

/// The paths of a wavefront in a bounce, in `N` slots.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct WaveState<const N: usize> {
    /// The paths that continue.
    pub paths: PathLanes<N>,
    hits: HitBatch<N>,
    queues: ShadingQueues<N>,
    /// Results of a bounce, by the slots of the queues.
    pub shading: ShadingLanes<N>,
    next: NextPathLanes<N>,
    shadow_rays: ShadowRayLanes<N>,
    /// Slots of the paths that continue, or of the shadow rays to be traced.
    list: [u32; N],
    /// The shadow rays without gaps.
    traced: ShadowRayLanes<N>,
    /// Radiance of each path, in the order in which the paths were added.
    pub radiance: [Rgb; N],
    /// See [`Remainder`].
    pub remainder: f32,
    /// Of paths whose connections are regularised.
    pub regularized: RegularizedLanes<N>,
}

impl<const N: usize> WaveState<N> {
    fn shade_escaped(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        mode: &mut Mode<'_, '_>,
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
        if let Mode::Divided(division) = mode {
            division.escaped(tables, &queued, &mut self.radiance);
        }
    }

    /// Gives the first `count` paths the densities by which the light that they have met is weighted. Few have met any.
    fn complete_densities(&mut self, simd: SimdLevel, tables: &Tables<'_>, count: usize) {
        let has_environment = tables.info.environment != NONE;
        let (own, queues, paths) = (&mut self.regularized, &self.queues, &mut self.paths);
        let count = count.min(N);
        own.find_waiting(&self.list[..count], |i| {
            queues.meets_light(i, has_environment)
        });
        macro_rules! complete {
            ($($variant:ident)*) => {$(
                self.shading.complete_densities::<{ bsdf_variant::$variant }>(
                    simd, tables.data, &self.list, own, paths,
                );
            )*};
        }
        complete!(CONDUCTOR DIELECTRIC THIN_DIELECTRIC PLASTIC);
        complete!(ROUGH_CONDUCTOR_BECKMANN ROUGH_CONDUCTOR_GGX ROUGH_DIELECTRIC_BECKMANN);
        complete!(ROUGH_DIELECTRIC_GGX ROUGH_PLASTIC_BECKMANN ROUGH_PLASTIC_GGX);
    }

    /// The bounce of the paths in the fallback queue.
    fn shade_one_by_one<S: LaneSampler, T: Traverse>(
        &mut self,
        view: &SceneView<'_, T>,
        rules: PathRules,
        mode: &mut Mode<'_, '_>,
    ) {
        let mut fallback = Fallback {
            queued: self.queues.queued(queues::FALLBACK, &self.paths),
            hits: &self.hits,
            keep: Remainder {
                scale: self.remainder,
            },
            shaded: Shaded {
                next: &mut self.next,
                shadow_rays: &mut self.shadow_rays,
                radiance: &mut self.radiance,
            },
        };
        match mode {
            Mode::Plain => fallback.shade::<S, T>(view, rules, None),
            Mode::Divided(division) => fallback.shade::<S, T>(view, rules, Some(division)),
            Mode::Regularized => {
                fallback.shade_regularized::<S, T>(view, rules, &mut self.regularized)
            }
        }
    }

    /// The bounce of the paths in both queues of a BSDF variant.
    fn shade_variant<S: LaneSampler, const VARIANT: u32>(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        rules: PathRules,
        mode: &mut Mode<'_, '_>,
    ) {
        for is_textured in [false, true] {
            let queue = queue_of(VARIANT, is_textured);
            let queued = self.queues.queued(queue, &self.paths);
            if queued.segment.count == 0 {
                continue;
            }
            let regularized = match mode {
                Mode::Regularized if may_be_raised(VARIANT) => Some(&mut self.regularized),
                Mode::Regularized => {
                    self.regularized.clear(queued.segment);
                    None
                }
                _ => None,
            };
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
                regularized,
                sampler: PhantomData,
            });
            if let Mode::Divided(division) = mode {
                division.shaded::<VARIANT, N>(
                    simd,
                    tables,
                    &queued,
                    &mut self.shading,
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
        mode: &mut Mode<'_, '_>,
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
            if let Mode::Plain = mode {
                self.traced
                    .accumulate(&self.hits, count, &mut self.radiance);
                return;
            }
            for j in 0..count.min(N) {
                if !self.hits.is_hit(j) {
                    self.add_direct(mode, j, self.traced.radiance.get(j));
                }
            }
            return;
        }
        for j in 0..count {
            let light = self.traced.radiance.get(j) * transmittance(view, self.traced.rays.get(j));
            self.add_direct(mode, j, light);
        }
    }

    /// Adds the light of a shadow ray that has been traced.
    fn add_direct(&mut self, mode: &mut Mode<'_, '_>, j: usize, light: Rgb) {
        let i = (self.traced.index[j] as usize).min(N - 1);
        if let Mode::Divided(division) = mode {
            division.add_direct(i, light);
            return;
        }
        self.radiance[i] += light;
        if let Mode::Regularized = mode {
            let slot = (self.list[j] as usize).min(N - 1);
            self.regularized.add_share(slot, i, light);
        }
    }

    /// Moves the paths that continue to the front; returns how many there are.
    pub fn compact(&mut self, simd: SimdLevel) -> usize {
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
pub(super) struct WavefrontBounce<'a, 'm, 'd, T: Traverse, S, const N: usize> {
    pub state: &'a mut WaveState<N>,
    pub simd: SimdLevel,
    pub view: &'a SceneView<'a, T>,
    pub settings: &'a IntegratorSettings,
    pub count: usize,
    pub mode: &'a mut Mode<'m, 'd>,
    pub sampler: PhantomData<S>,
}

impl<T: Traverse, S: LaneSampler, const N: usize> Rays for WavefrontBounce<'_, '_, '_, T, S, N> {
    fn trace(&mut self) {
        let (state, view) = (&mut *self.state, self.view);
        view.traverse
            .closest_hits(&state.paths.rays, self.count, &mut state.hits);
        let traced = TracedPaths {
            paths: &state.paths,
            hits: &state.hits,
            count: self.count,
            has_no_shiny_loops: matches!(self.mode, Mode::Regularized)
                && self.settings.regularization.radius > 0.0,
        };
        state
            .queues
            .sort(self.simd, &view.tables, self.settings, &traced);
        if let Mode::Regularized = self.mode {
            state.complete_densities(self.simd, &view.tables, self.count);
        }
    }

    fn trace_shadow_rays(&mut self) {
        self.state
            .trace_shadow_rays(self.simd, self.view, self.mode);
    }
}

impl<T: Traverse, S: LaneSampler, const N: usize> WavefrontBounce<'_, '_, '_, T, S, N> {
    /// All queues, one after the other.
    pub fn shade(&mut self) {
        let (simd, tables, rules) = (self.simd, &self.view.tables, self.settings.rules);
        let settings = self.settings;
        self.state.shade_escaped(simd, tables, settings, self.mode);
        self.state
            .shade_one_by_one::<S, T>(self.view, rules, self.mode);
        macro_rules! shade {
            ($($variant:ident)*) => {$(
                self.state.shade_variant::<S, { bsdf_variant::$variant }>(
                    simd, tables, rules, self.mode,
                );
            )*};
        }
        shade!(DIFFUSE ROUGH_DIFFUSE CONDUCTOR DIELECTRIC THIN_DIELECTRIC PLASTIC);
        shade!(ROUGH_CONDUCTOR_BECKMANN ROUGH_CONDUCTOR_GGX ROUGH_DIELECTRIC_BECKMANN);
        shade!(ROUGH_DIELECTRIC_GGX ROUGH_PLASTIC_BECKMANN ROUGH_PLASTIC_GGX);
    }
}
