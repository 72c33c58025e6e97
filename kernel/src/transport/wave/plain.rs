//! A bounce of paths that meet plain materials.

use super::classes::plain;
use super::environment::Scratch;
use super::lights::LightLanes;
use super::lobes::{self, LobeLanes};
use super::paths::PathLanes;
use super::points::{self, PointLanes};
use super::segment::Segment;
use super::{ArrivalLanes, Wave, samples};
use crate::bsdf::lobe::is_delta;
use crate::bsdf::mixture;
use crate::math::lanes::pick;
use crate::math::vectors::{Vectors, over_lanes};
use crate::sampler::LaneSampler;
use crate::scene::lobe_form as form;
use crate::scene::{NONE, Tables};
use crate::transport::IntegratorSettings;
use crate::transport::connection::{Connection, SampleCounts, reflected};
use crate::transport::path::Arrival;

impl<S: LaneSampler, const N: usize> Wave<S, N> {
    /// The bounce of all paths that meet plain materials of a form.
    pub(super) fn plain<const FORM: u32>(
        &mut self,
        vectors: Vectors,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
    ) {
        for is_textured in [false, true] {
            let class = plain(FORM, is_textured) as usize;
            if self.classes.segments[class].count > 0 {
                self.plain_class::<FORM>(vectors, tables, settings, class, is_textured);
            }
        }
    }

    fn plain_class<const FORM: u32>(
        &mut self,
        vectors: Vectors,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        class: usize,
        is_textured: bool,
    ) {
        let list = &self.classes.list;
        let (segment, spheres) = (self.classes.segments[class], self.classes.spheres[class]);
        let on_triangles = match (tables.normals.is_empty(), tables.uvs.is_empty()) {
            (false, false) => points::on_triangles::<true, true, N>,
            (false, true) => points::on_triangles::<true, false, N>,
            (true, false) => points::on_triangles::<false, true, N>,
            (true, true) => points::on_triangles::<false, false, N>,
        };
        on_triangles(
            vectors,
            tables,
            &self.paths,
            &self.hits,
            list,
            segment,
            &mut self.points,
        );
        if spheres.count > 0 {
            let (paths, hits) = (&self.paths, &self.hits);
            points::on_spheres(
                vectors,
                tables,
                paths,
                hits,
                list,
                spheres,
                &mut self.points,
            );
        }
        self.emission(tables, segment);
        lobes::look_up::<FORM, N>(vectors, tables, &self.points, segment, &mut self.lobes);
        if is_textured {
            let (points, textures) = (&self.points, &mut self.textures);
            self.lobes
                .look_up_textures::<FORM>(vectors, tables, points, segment, textures);
        }
        let list = &self.classes.list;
        draw::<S, N>(
            vectors,
            &self.paths,
            list,
            segment,
            !is_delta(form::kind(FORM)),
            &mut self.next,
            &mut self.numbers,
        );
        if is_delta(form::kind(FORM)) {
            for k in segment.slots::<N>() {
                self.arrivals.radiance.x[k] = 0.0;
                self.arrivals.radiance.y[k] = 0.0;
                self.arrivals.radiance.z[k] = 0.0;
            }
        } else {
            self.lights.choose(
                vectors,
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
            weigh::<FORM, N>(
                vectors,
                tables,
                &self.paths,
                list,
                &self.points,
                &self.lobes,
                &self.lights,
                segment,
                &mut self.arrivals,
            );
        }
        if form::is_rough(FORM) {
            self.normals
                .draw::<FORM>(vectors, &self.lobes, &self.points, &self.numbers, segment);
        }
        samples::sample::<FORM, N>(
            vectors,
            tables.data,
            &self.points,
            &self.lobes,
            &self.normals,
            &self.numbers,
            segment,
            &mut self.samples,
        );
        samples::leave::<S, N>(
            vectors,
            settings,
            &self.paths,
            list,
            &self.points,
            &self.samples,
            segment,
            &mut self.next,
            &mut self.goes_on,
        );
    }

    /// Light that the surfaces themselves emit.
    fn emission(&mut self, tables: &Tables<'_>, segment: Segment) {
        for k in segment.taken::<N>() {
            if self.points.emitter[k] != NONE {
                let i = self.classes.list[k];
                let mut path = self.paths.pick(i);
                path.gather(tables, &self.points.get(k));
                self.gather(i, path.radiance);
            }
        }
    }
}

over_lanes! {
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
            next.place[k] = pick(&paths.place, i);
        }
    }

    /// What the chosen emitter points add.
    fn weigh<; const FORM: u32, const N: usize>(
        tables: &Tables<'_>,
        paths: &PathLanes<N>,
        list: &[u32; N],
        points: &PointLanes<N>,
        lobes: &LobeLanes<N>,
        lights: &LightLanes<N>,
        segment: Segment,
        arrivals: &mut ArrivalLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let i = list[k];
            let lobe = lobes.get::<FORM>(k);
            let (point, wi) = (points.get(k), points.wi.get(k));
            let light = lights.get(k);
            let wo = point.frame.to_local(light.direction);
            let (value, pdf) = mixture::plain::eval_cosine_pdf(&lobe, tables.data, wi, wo);
            let mut connection = reflected(&light, &point, SampleCounts::ONE, value, pdf);
            if !light.is_some() || value.max_element() <= 0.0 {
                connection = Connection::NONE;
            }
            let arrival = Arrival {
                connection,
                throughput: paths.throughput.pick(i),
            };
            arrivals.set(k, &arrival);
            arrivals.place[k] = pick(&paths.place, i);
        }
    }
}
