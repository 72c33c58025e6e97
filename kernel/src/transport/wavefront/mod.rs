//! Many paths side by side: one bounce of each before the next of any.
//!
//! Paths that take the same way through the code (the same kind of surface, the same scattering model) are sorted
//! together, and each step of [`super::path`] is a loop over them, over structures of arrays ([`crate::simd::lanes`]): the
//! functions are those of single paths, and a compiler makes them functions of vectors (Laine, Karras and Aila 2013,
//! "Megakernels Considered Harmful", on lanes instead of threads). Rays are traced for all at once. What has no loop of its
//! own takes the way of a single path.
//!
//! Invariant (tests): the results are those of single paths, to the bit.

mod bsdf_samples;
pub mod bsdf_variant;
mod camera_rays;
mod cdf_search;
mod emitter_samples;
mod environment;
mod lobes;
mod microfacet_normals;
mod paths;
mod queues;
mod segment;
mod shading;
mod shadow_rays;
mod surfaces;
mod textures;

use super::IntegratorSettings;
use super::path::{ShadowRay, step};
use crate::bsdf::Bsdf;
use crate::math::Rgb;
use crate::path::visibility::transmittance;
use crate::sampler::LaneSampler;
use crate::scene::{HitBatch, NONE, SceneView, Tables, Traverse, scene_flag};
use crate::simd::SimdLevel;
use crate::simd::lanes::Vec3Lanes;
use bsdf_samples::SampleLanes;
use bytemuck::Zeroable;
use camera_rays::FilmLanes;
use cdf_search::SearchLanes;
use core::marker::PhantomData;
use emitter_samples::LightLanes;
use environment::EnvironmentLanes;
use lobes::LobeLanes;
use microfacet_normals::NormalLanes;
use paths::PathLanes;
use queues::{Classes, ESCAPING, GENERAL};
use shadow_rays::ShadowRayLanes;
use surfaces::PointLanes;
use textures::TextureLanes;

/// Paths in `N` slots, of which [`Wavefront::CAPACITY`] paths are sure to find one; zeros are a wave without paths.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub struct Wavefront<S, const N: usize> {
    count: u32,
    film: FilmLanes<N>,
    /// Paths that go on, in order.
    paths: PathLanes<N>,
    hits: HitBatch<N>,
    classes: Classes<N>,
    /// What follows has its slots in the order of the classes.
    points: PointLanes<N>,
    lobes: LobeLanes<N>,
    lights: LightLanes<N>,
    /// Three that choose an emitter point, three that choose a direction.
    numbers: [[f32; N]; 6],
    normals: NormalLanes<N>,
    searches: SearchLanes<N>,
    textures: TextureLanes<N>,
    environment: EnvironmentLanes<N>,
    gathered: Vec3Lanes<N>,
    samples: SampleLanes<N>,
    shadow_rays: ShadowRayLanes<N>,
    next: PathLanes<N>,
    continues: [u32; N],
    /// Slots of paths that go on, or of light that arrives.
    list: [u32; N],
    lit: ShadowRayLanes<N>,
    /// What each path has gathered, in the order in which they were added.
    radiance: [Rgb; N],
    sampler: PhantomData<S>,
}

impl<S: LaneSampler, const N: usize> Wavefront<S, N> {
    /// Paths that surely find a slot each.
    pub const CAPACITY: usize = Classes::<N>::capacity();

    /// Whether there is no room for another.
    pub fn is_full(&self) -> bool {
        self.count as usize >= Self::CAPACITY
    }

    /// Adds a sample of the pixel at absolute film coordinates, if there is room; the sampler's numbers are those of
    /// [`super::sample_pixel`].
    pub fn push(&mut self, pixel: [u32; 2], sampler: S) {
        self.push_samples(pixel, 1, |_| sampler);
    }

    /// Adds samples 0, 1, ... of a pixel with the samplers of their numbers, as many of `count` as there is room for; how many
    /// that are.
    #[inline]
    pub fn push_samples(&mut self, pixel: [u32; 2], count: u32, sampler: impl Fn(u32) -> S) -> u32 {
        let first = (self.count as usize).min(Self::CAPACITY);
        let count = count.min((Self::CAPACITY - first) as u32);
        for i in 0..count {
            self.paths.set_sampler(first + i as usize, sampler(i));
        }
        let places = first..first + count as usize;
        self.film.pixel[0][places.clone()].fill(pixel[0]);
        self.film.pixel[1][places].fill(pixel[1]);
        self.count += count;
        count
    }

    /// Traces the paths to their ends. Returns [`super::sample_pixel`] of each, in the order in which they were added, and
    /// leaves the wave empty.
    pub fn run<T: Traverse>(
        &mut self,
        simd: SimdLevel,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
    ) -> &[Rgb] {
        let count = self.count as usize;
        self.count = 0;
        self.film.generate::<S>(
            simd,
            &view.tables,
            count,
            &mut self.searches,
            &mut self.paths,
        );
        self.radiance[..count].fill(Rgb::ZERO);
        let mut active = if settings.max_depth > 0 { count } else { 0 };
        while active > 0 {
            active = self.bounce(simd, view, settings, active);
        }
        for k in 0..count {
            self.radiance[k] *= self.film.weight[k];
        }
        &self.radiance[..count]
    }

    /// One bounce of the first `count` paths; returns how many go on.
    fn bounce<T: Traverse>(
        &mut self,
        simd: SimdLevel,
        view: &SceneView<'_, T>,
        settings: &IntegratorSettings,
        count: usize,
    ) -> usize {
        let tables = &view.tables;
        view.traverse
            .closest_hits(&self.paths.rays, count, &mut self.hits);
        self.classes
            .sort(simd, tables, settings, &self.paths, &self.hits, count);
        if tables.info.environment != NONE {
            self.escape(simd, tables, settings);
        }
        self.general(tables, settings);
        macro_rules! plain {
            ($($variant:ident)*) => {$(
                self.plain::<{ bsdf_variant::$variant }>(simd, tables, settings);
            )*};
        }
        plain!(DIFFUSE ROUGH_DIFFUSE CONDUCTOR DIELECTRIC THIN_DIELECTRIC PLASTIC);
        plain!(ROUGH_CONDUCTOR_BECKMANN ROUGH_CONDUCTOR_GGX ROUGH_DIELECTRIC_BECKMANN);
        plain!(ROUGH_DIELECTRIC_GGX ROUGH_PLASTIC_BECKMANN ROUGH_PLASTIC_GGX);
        self.gather_light(simd, view);
        self.advance(simd)
    }

    /// Light from infinity.
    fn escape(&mut self, simd: SimdLevel, tables: &Tables<'_>, settings: &IntegratorSettings) {
        let segment = self.classes.segments[ESCAPING as usize];
        if segment.count == 0 {
            return;
        }
        let (paths, list) = (&self.paths, &self.classes.list);
        self.environment
            .look_at(simd, tables, paths, list, segment, &mut self.textures);
        let selection_pdf = tables.emitters[tables.info.environment as usize].selection_pdf;
        let (seen, gathered) = (&self.environment, &mut self.gathered);
        environment::add_radiance(
            simd,
            settings,
            paths,
            list,
            segment,
            selection_pdf,
            seen,
            gathered,
        );
        for k in segment.taken::<N>() {
            self.accumulate(self.classes.list[k], self.gathered.get(k));
        }
    }

    /// Adds to what path `i` has gathered.
    fn accumulate(&mut self, i: u32, radiance: Rgb) {
        let place = (self.paths.place[(i as usize).min(N - 1)] as usize).min(N - 1);
        self.radiance[place] += radiance;
    }

    /// Paths that take the way of a single one.
    #[inline(never)]
    fn general(&mut self, tables: &Tables<'_>, settings: &IntegratorSettings) {
        let mut bsdf = Bsdf::BLACK;
        let mut light = ShadowRay::NONE;
        for k in self.classes.segments[GENERAL as usize].taken::<N>() {
            let i = self.classes.list[k];
            let mut path = self.paths.gather(i);
            let mut sampler = self.paths.sampler::<S>(i);
            let hit = self.hits.get((i as usize).min(N - 1));
            let next = path.bounce(tables, settings, &mut sampler, &hit, &mut bsdf, &mut light);
            self.accumulate(i, path.radiance);
            self.shadow_rays.set(k, &light);
            self.continues[k] = u32::from(next != step::END);
            self.next.set(k, &path);
            self.next.set_sampler(k, sampler);
            let place = self.paths.place[(i as usize).min(N - 1)];
            self.next.place[k] = place;
            self.shadow_rays.place[k] = place;
        }
    }

    /// Gathers the light of emitters that is not in a shadow.
    fn gather_light<T: Traverse>(&mut self, simd: SimdLevel, view: &SceneView<'_, T>) {
        let mut count = 0;
        for class in GENERAL as usize..queues::CLASSES {
            let segment = self.classes.segments[class];
            count = self.shadow_rays.list_lit(segment, &mut self.list, count);
        }
        if count == 0 {
            return;
        }
        shadow_rays::take(simd, &self.shadow_rays, &self.list, count, &mut self.lit);
        if view.tables.info.flags & scene_flag::HAS_NULL == 0 {
            view.traverse
                .are_occluded(&self.lit.rays, count, &mut self.hits);
            self.lit.accumulate(&self.hits, count, &mut self.radiance);
            return;
        }
        for j in 0..count {
            let light = self.lit.radiance.get(j) * transmittance(view, self.lit.rays.get(j));
            let place = (self.lit.place[j] as usize).min(N - 1);
            self.radiance[place] += light;
        }
    }

    /// Makes the paths that go on the first ones; returns how many there are.
    fn advance(&mut self, simd: SimdLevel) -> usize {
        let mut count = 0;
        for class in GENERAL as usize..queues::CLASSES {
            for k in self.classes.segments[class].taken::<N>() {
                if count < N {
                    self.list[count] = k as u32;
                }
                count += usize::from(self.continues[k] != 0);
            }
        }
        let count = count.min(N);
        paths::take(simd, &self.next, &self.list, count, &mut self.paths);
        count
    }
}
