//! A bounce of paths that meet plain materials.

use super::bsdf_variant;
use super::emitter_samples::LightLanes;
use super::environment::Scratch;
use super::lobes::{self, LobeLanes};
use super::paths::PathLanes;
use super::queues::plain;
use super::segment::Segment;
use super::surfaces::{self, PointLanes};
use super::{ShadowRayLanes, Wavefront, bsdf_samples};
use crate::bsdf::lobe::is_delta;
use crate::bsdf::mixture;
use crate::sampler::LaneSampler;
use crate::scene::{NONE, Tables};
use crate::simd::lanes::gather;
use crate::simd::{SimdLevel, multiversioned};
use crate::transport::IntegratorSettings;
use crate::transport::connection::{Connection, SampleCounts, weighted_contribution};
use crate::transport::path::ShadowRay;

impl<S: LaneSampler, const N: usize> Wavefront<S, N> {
    /// The bounce of all paths that meet plain materials of a form.
    pub(super) fn plain<const VARIANT: u32>(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
    ) {
        for is_textured in [false, true] {
            let class = plain(VARIANT, is_textured) as usize;
            if self.classes.segments[class].count > 0 {
                self.plain_class::<VARIANT>(simd, tables, settings, class, is_textured);
            }
        }
    }

    fn plain_class<const VARIANT: u32>(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        class: usize,
        is_textured: bool,
    ) {
        let list = &self.classes.list;
        let (segment, spheres) = (self.classes.segments[class], self.classes.spheres[class]);
        let on_triangles = match (tables.normals.is_empty(), tables.uvs.is_empty()) {
            (false, false) => surfaces::on_triangles::<true, true, N>,
            (false, true) => surfaces::on_triangles::<true, false, N>,
            (true, false) => surfaces::on_triangles::<false, true, N>,
            (true, true) => surfaces::on_triangles::<false, false, N>,
        };
        on_triangles(
            simd,
            tables,
            &self.paths,
            &self.hits,
            list,
            segment,
            &mut self.points,
        );
        if spheres.count > 0 {
            let (paths, hits) = (&self.paths, &self.hits);
            surfaces::on_spheres(simd, tables, paths, hits, list, spheres, &mut self.points);
        }
        self.emission(tables, segment);
        lobes::look_up::<VARIANT, N>(simd, tables, &self.points, segment, &mut self.lobes);
        if is_textured {
            let (points, textures) = (&self.points, &mut self.textures);
            self.lobes
                .look_up_textures::<VARIANT>(simd, tables, points, segment, textures);
        }
        let list = &self.classes.list;
        draw::<S, N>(
            simd,
            &self.paths,
            list,
            segment,
            !is_delta(bsdf_variant::kind(VARIANT)),
            &mut self.next,
            &mut self.numbers,
        );
        if is_delta(bsdf_variant::kind(VARIANT)) {
            for k in segment.slots::<N>() {
                self.shadow_rays.radiance.x[k] = 0.0;
                self.shadow_rays.radiance.y[k] = 0.0;
                self.shadow_rays.radiance.z[k] = 0.0;
            }
        } else {
            self.lights.choose(
                simd,
                tables,
                &self.points,
                &self.numbers,
                segment,
                &mut self.environment,
                Scratch {
                    searches: &mut self.searches,
                    textures: &mut self.textures,
                },
            );
            weigh::<VARIANT, N>(
                simd,
                tables,
                &self.paths,
                list,
                &self.points,
                &self.lobes,
                &self.lights,
                segment,
                &mut self.shadow_rays,
            );
        }
        if bsdf_variant::is_rough(VARIANT) {
            self.normals
                .draw::<VARIANT>(simd, &self.lobes, &self.points, &self.numbers, segment);
        }
        bsdf_samples::sample::<VARIANT, N>(
            simd,
            tables.data,
            &self.points,
            &self.lobes,
            &self.normals,
            &self.numbers,
            segment,
            &mut self.samples,
        );
        bsdf_samples::scatter_along::<S, N>(
            simd,
            settings,
            &self.paths,
            list,
            &self.points,
            &self.samples,
            segment,
            &mut self.next,
            &mut self.continues,
        );
    }

    /// Light that the surfaces themselves emit.
    fn emission(&mut self, tables: &Tables<'_>, segment: Segment) {
        for k in segment.taken::<N>() {
            if self.points.emitter[k] != NONE {
                let i = self.classes.list[k];
                let mut path = self.paths.gather(i);
                path.add_emission(tables, &self.points.get(k));
                self.accumulate(i, path.radiance);
            }
        }
    }
}

multiversioned! {
    /// Takes the samplers of the paths, if `draws` the numbers that choose an emitter point, and those that choose a
    /// direction.
    fn draw<S: LaneSampler; const N: usize>(
        paths: &PathLanes<N>,
        list: &[u32; N],
        segment: Segment,
        draws: bool,
        next: &mut PathLanes<N>,
        numbers: &mut [[f32; N]; 6],
    ) {
        for k in segment.slots::<N>() {
            let i = list[k];
            let mut sampler = paths.sampler::<S>(i);
            if draws {
                numbers[0][k] = sampler.next_1d();
                let u = sampler.next_2d();
                numbers[1][k] = u.x;
                numbers[2][k] = u.y;
            }
            numbers[3][k] = sampler.next_1d();
            let u = sampler.next_2d();
            numbers[4][k] = u.x;
            numbers[5][k] = u.y;
            next.set_sampler(k, sampler);
            next.place[k] = gather(&paths.place, i);
        }
    }

    /// What the chosen emitter points add.
    fn weigh<; const VARIANT: u32, const N: usize>(
        tables: &Tables<'_>,
        paths: &PathLanes<N>,
        list: &[u32; N],
        points: &PointLanes<N>,
        lobes: &LobeLanes<N>,
        lights: &LightLanes<N>,
        segment: Segment,
        shadow_rays: &mut ShadowRayLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let i = list[k];
            let lobe = lobes.get::<VARIANT>(k);
            let (point, wi) = (points.get(k), points.wi.get(k));
            let light = lights.get(k);
            let wo = point.frame.to_local(light.direction);
            let (value, pdf) = mixture::plain::eval_cosine_pdf(&lobe, tables.data, wi, wo);
            let mut connection = weighted_contribution(&light, &point, SampleCounts::ONE, value, pdf);
            if !light.is_some() || value.max_element() <= 0.0 {
                connection = Connection::NONE;
            }
            let arrival = ShadowRay {
                connection,
                throughput: paths.throughput.gather(i),
            };
            shadow_rays.set(k, &arrival);
            shadow_rays.place[k] = gather(&paths.place, i);
        }
    }
}
