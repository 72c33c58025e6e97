//! Shading of the queues that belong to BSDF variants: each stage of [`crate::transport::bounce`] as loops over lanes.

use super::bsdf_samples::{self, SampleLanes};
use super::bsdf_variant;
use super::cdf_search::SearchLanes;
use super::diffuse_shares::DiffuseShareLanes;
use super::emitter_samples::{EmitterSampleLanes, References};
use super::environment::{EnvironmentLanes, Scratch};
use super::lobes::{self, LobeLanes};
use super::microfacet_normals::NormalLanes;
use super::paths::{NextPathLanes, PathLanes, QueuedPaths};
use super::random_numbers::{self, NumberLanes};
use super::regularized::{self, RegularizedLanes};
use super::scattering::ScatteringInputs;
use super::segment::Segment;
use super::shadow_rays::ShadowRayLanes;
use super::surfaces::{self, PointLanes};
use super::textures::TextureLanes;
use crate::bsdf::lobe::is_delta;
use crate::bsdf::mixture;
use crate::math::Rgb;
use crate::path::PathRules;
use crate::path::remainder::Remainder;
use crate::regularize::plain_lobe;
use crate::sampler::LaneSampler;
use crate::scene::{HitBatch, NONE, Tables};
use crate::simd::lanes::{Vec3Lanes, gather};
use crate::simd::{SimdLevel, multiversioned};
use crate::transport::bounce::Shading;
use crate::transport::connection::{SampleCounts, ShadowRay, weighted_contribution};
use crate::transport::settings::IntegratorSettings;
use bytemuck::Zeroable;
use core::marker::PhantomData;
use glam::Vec3;

/// What shading keeps between its loops, by slot.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct ShadingLanes<const N: usize> {
    pub(super) points: PointLanes<N>,
    pub(super) lobes: LobeLanes<N>,
    numbers: NumberLanes<N>,
    normals: NormalLanes<N>,
    pub(super) samples: SampleLanes<N>,
    pub(super) lights: EmitterSampleLanes<N>,
    environment: EnvironmentLanes<N>,
    searches: SearchLanes<N>,
    textures: TextureLanes<N>,
    gain: Vec3Lanes<N>,
    /// Set while light is divided by path expressions.
    pub(super) diffuse_shares: DiffuseShareLanes<N>,
}

/// A queue of a BSDF variant.
#[derive(Clone, Copy)]
pub(super) struct VariantQueue<'a, const N: usize> {
    pub queued: QueuedPaths<'a, N>,
    /// What the paths, by their own indices, have met.
    pub hits: &'a HitBatch<N>,
    /// The part of the segment whose paths are at spheres; the rest is at triangles.
    pub spheres: Segment,
    pub is_textured: bool,
}

/// What a bounce makes of a queue, by slot.
pub(super) struct Shaded<'a, const N: usize> {
    pub next: &'a mut NextPathLanes<N>,
    pub shadow_rays: &'a mut ShadowRayLanes<N>,
    /// Radiance of all paths, by their numbers in the wavefront.
    pub radiance: &'a mut [Rgb; N],
}

impl<const N: usize> ShadingLanes<N> {
    /// Searches, for the camera rays.
    pub fn searches(&mut self) -> &mut SearchLanes<N> {
        &mut self.searches
    }

    /// Adds the environment's radiance to escaped paths.
    pub fn shade_escaped(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        queued: &QueuedPaths<'_, N>,
        keep: Remainder,
        radiance: &mut [Rgb; N],
    ) {
        self.environment
            .look_up(simd, tables, queued, &mut self.textures);
        let (environment, gain) = (&self.environment, &mut self.gain);
        super::environment::weighted_radiance(simd, tables, settings, queued, environment, gain);
        for k in queued.segment.occupied::<N>() {
            let depth = gather(&queued.paths.depth, queued.entries[k]);
            radiance[queued.index(k)] += keep.of(self.gain.get(k), depth + 1);
        }
    }

    fn look_up_surfaces(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        queue: &VariantQueue<'_, N>,
    ) {
        let on_triangles = match (tables.normals.is_empty(), tables.uvs.is_empty()) {
            (false, false) => surfaces::on_triangles::<true, true, N>,
            (false, true) => surfaces::on_triangles::<true, false, N>,
            (true, false) => surfaces::on_triangles::<false, true, N>,
            (true, true) => surfaces::on_triangles::<false, false, N>,
        };
        let (queued, hits) = (&queue.queued, queue.hits);
        on_triangles(simd, tables, queued, hits, &mut self.points);
        if queue.spheres.count > 0 {
            surfaces::on_spheres(simd, tables, queued, hits, queue.spheres, &mut self.points);
        }
    }

    /// Gives the paths of a variant p_hat of the directions in which they left the last bounce, where light that they have met is
    /// weighted by it; `slots` are theirs in that bounce, whose lanes are still as they were.
    pub fn complete_densities<const VARIANT: u32>(
        &mut self,
        simd: SimdLevel,
        data: &[f32],
        slots: &[u32; N],
        own: &mut RegularizedLanes<N>,
        paths: &mut PathLanes<N>,
    ) {
        let count = own.list_waiting(VARIANT, slots);
        if count == 0 {
            return;
        }
        let inputs = ScatteringInputs {
            points: &self.points,
            lobes: &self.lobes,
            numbers: &self.numbers,
            segment: Segment { first: 0, count },
        };
        let (tau, slots, p_hat) = (&own.thresholds.tau, &own.slots, &mut own.p_hat);
        let samples = &self.samples;
        regularized::find_densities::<VARIANT, N>(simd, data, &inputs, samples, tau, slots, p_hat);
        own.set_densities(count, paths);
    }

    /// Adds the emission of the surfaces, weighted against emitter samples. Few paths meet an emitter: slot by slot.
    fn add_emission(
        &mut self,
        tables: &Tables<'_>,
        queued: &QueuedPaths<'_, N>,
        keep: Remainder,
        radiance: &mut [Rgb; N],
    ) {
        for k in queued.segment.occupied::<N>() {
            if self.points.emitter[k] != NONE {
                let mut path = queued.paths.gather(queued.entries[k]);
                path.add_emission(tables, &self.points.get(k));
                radiance[queued.index(k)] += keep.of(path.radiance, path.subpath.depth + 1);
            }
        }
    }
}

/// The stages of the paths in the queue of a BSDF variant.
pub(super) struct VariantShading<'a, S, const VARIANT: u32, const N: usize> {
    pub simd: SimdLevel,
    pub tables: &'a Tables<'a>,
    pub rules: PathRules,
    pub keep: Remainder,
    pub lanes: &'a mut ShadingLanes<N>,
    pub queue: VariantQueue<'a, N>,
    pub shaded: Shaded<'a, N>,
    /// Where connections to lobes of the variant are regularised.
    pub regularized: Option<&'a mut RegularizedLanes<N>>,
    pub sampler: PhantomData<S>,
}

impl<S, const VARIANT: u32, const N: usize> VariantShading<'_, S, VARIANT, N> {
    /// Whether none of the lobes has a value.
    fn is_unlit(&self) -> bool {
        is_delta(bsdf_variant::kind(VARIANT)) && self.regularized.is_none()
    }
}

impl<S: LaneSampler, const VARIANT: u32, const N: usize> Shading
    for VariantShading<'_, S, VARIANT, N>
{
    fn arrive(&mut self) {
        let (simd, tables, queued) = (self.simd, self.tables, &self.queue.queued);
        let lanes = &mut *self.lanes;
        lanes.look_up_surfaces(simd, tables, &self.queue);
        lanes.add_emission(tables, queued, self.keep, self.shaded.radiance);
        let segment = queued.segment;
        lobes::look_up::<VARIANT, N>(simd, tables, &lanes.points, segment, &mut lanes.lobes);
        if self.queue.is_textured {
            let (points, textures) = (&lanes.points, &mut lanes.textures);
            lanes
                .lobes
                .look_up_textures::<VARIANT>(simd, tables, points, segment, textures);
        }
        if let Some(own) = &mut self.regularized {
            let (lobes, thresholds) = (&lanes.lobes, &mut own.thresholds);
            regularized::find_thresholds::<VARIANT, N>(
                simd,
                queued,
                lobes,
                &own.of_path,
                thresholds,
            );
        }
    }

    /// Draws the numbers of the whole bounce, too.
    fn sample_emitter(&mut self) {
        let is_unlit = self.is_unlit();
        let (simd, queued) = (self.simd, &self.queue.queued);
        let lanes = &mut *self.lanes;
        let (next, numbers) = (&mut self.shaded.next.paths, &mut lanes.numbers);
        if is_unlit {
            random_numbers::draw::<S, false, N>(simd, queued, next, numbers);
            return;
        }
        match &self.regularized {
            Some(own) if is_delta(bsdf_variant::kind(VARIANT)) => {
                let is_lit = &own.thresholds.is_raised;
                random_numbers::draw_where_lit::<S, N>(simd, queued, is_lit, next, numbers);
            }
            _ => random_numbers::draw::<S, true, N>(simd, queued, next, numbers),
        }
        let at = References {
            points: &lanes.points,
            numbers: &lanes.numbers,
            segment: queued.segment,
        };
        let scratch = Scratch {
            searches: &mut lanes.searches,
            textures: &mut lanes.textures,
        };
        lanes
            .lights
            .sample(simd, self.tables, &at, &mut lanes.environment, scratch);
    }

    fn evaluate_emitter(&mut self) {
        let is_unlit = self.is_unlit();
        let queued = &self.queue.queued;
        let shadow_rays = &mut *self.shaded.shadow_rays;
        if is_unlit {
            shadow_rays.clear(queued.segment);
            return;
        }
        let lit = LitSurfaces {
            points: &self.lanes.points,
            lobes: &self.lanes.lobes,
            lights: &self.lanes.lights,
        };
        let (simd, tables, keep) = (self.simd, self.tables, self.keep);
        if let Some(own) = &mut self.regularized {
            own.set_shares(queued.segment);
            let tau = &own.thresholds.tau;
            evaluate_lights_below::<VARIANT, N>(simd, tables, queued, &lit, tau, keep, shadow_rays);
        } else {
            evaluate_lights::<VARIANT, N>(simd, tables, queued, &lit, keep, shadow_rays);
        }
    }

    fn sample_bsdf(&mut self) {
        let inputs = ScatteringInputs {
            points: &self.lanes.points,
            lobes: &self.lanes.lobes,
            numbers: &self.lanes.numbers,
            segment: self.queue.queued.segment,
        };
        if bsdf_variant::is_rough(VARIANT) {
            self.lanes.normals.sample::<VARIANT>(self.simd, &inputs);
        }
        let (normals, samples) = (&self.lanes.normals, &mut self.lanes.samples);
        bsdf_samples::sample::<VARIANT, N>(self.simd, self.tables.data, &inputs, normals, samples);
    }

    /// Variants have one lobe.
    fn mix_lobes(&mut self) {}

    fn scatter(&mut self) {
        let (points, samples) = (&self.lanes.points, &self.lanes.samples);
        let (queued, next) = (&self.queue.queued, &mut *self.shaded.next);
        bsdf_samples::continue_along::<S, N>(self.simd, &self.rules, queued, points, samples, next);
        if let Some(own) = &mut self.regularized {
            let (thresholds, pending) = (&own.thresholds, &mut own.pending);
            let segment = queued.segment;
            regularized::set_pending::<VARIANT, N>(
                self.simd, segment, samples, thresholds, pending,
            );
        }
    }
}

/// Surfaces and the emitter samples that light them.
#[derive(Clone, Copy)]
struct LitSurfaces<'a, const N: usize> {
    points: &'a PointLanes<N>,
    lobes: &'a LobeLanes<N>,
    lights: &'a EmitterSampleLanes<N>,
}

/// Sets the shadow ray of slot `k` of `queued`, where the lobe times the cosine is `value` towards its emitter sample, with the
/// density `pdf`.
#[inline(always)]
fn set_shadow_ray<const N: usize>(
    queued: &QueuedPaths<'_, N>,
    lit: &LitSurfaces<'_, N>,
    (k, value, pdf): (usize, Rgb, f32),
    keep: Remainder,
    shadow_rays: &mut ShadowRayLanes<N>,
) {
    let i = queued.entries[k];
    let light = lit.lights.get(k);
    let point = lit.points.get(k);
    let mut shadow_ray = weighted_contribution(&light, &point, SampleCounts::ONE, value, pdf);
    if !light.is_some() || value.max_element() <= 0.0 {
        shadow_ray = ShadowRay::NONE;
    }
    let radiance = queued.paths.throughput.gather(i) * shadow_ray.radiance;
    shadow_ray.radiance = keep.of(radiance, gather(&queued.paths.depth, i) + 2);
    shadow_rays.set(k, &shadow_ray);
    shadow_rays.index[k] = gather(&queued.paths.index, i);
}

impl<const N: usize> LitSurfaces<'_, N> {
    /// The directions of slot `k`, back along the path and towards the emitter sample.
    #[inline(always)]
    fn directions(&self, k: usize) -> (Vec3, Vec3) {
        let direction = self.lights.get(k).direction;
        (
            self.points.wi.get(k),
            self.points.get(k).frame.to_local(direction),
        )
    }
}

multiversioned! {
    /// Evaluates the lobes towards the emitter samples and weights the result against BSDF samples.
    fn evaluate_lights<; const VARIANT: u32, const N: usize>(
        tables: &Tables<'_>,
        queued: &QueuedPaths<'_, N>,
        lit: &LitSurfaces<'_, N>,
        keep: Remainder,
        shadow_rays: &mut ShadowRayLanes<N>,
    ) {
        for k in queued.segment.padded::<N>() {
            let (wi, wo) = lit.directions(k);
            let lobe = lit.lobes.get::<VARIANT>(k);
            let (value, pdf) = mixture::plain::eval_cosine_pdf(&lobe, tables.data, wi, wo);
            set_shadow_ray(queued, lit, (k, value, pdf), keep, shadow_rays);
        }
    }

    /// [`evaluate_lights`] with the lobes below tau.
    fn evaluate_lights_below<; const VARIANT: u32, const N: usize>(
        tables: &Tables<'_>,
        queued: &QueuedPaths<'_, N>,
        lit: &LitSurfaces<'_, N>,
        tau: &[f32; N],
        keep: Remainder,
        shadow_rays: &mut ShadowRayLanes<N>,
    ) {
        for k in queued.segment.padded::<N>() {
            let (wi, wo) = lit.directions(k);
            let lobe = lit.lobes.get::<VARIANT>(k);
            let (value, pdf) = plain_lobe::eval_cosine_pdf(&lobe, tables.data, wi, wo, tau[k]);
            set_shadow_ray(queued, lit, (k, value, pdf), keep, shadow_rays);
        }
    }
}
