//! Emitter samples, in lanes.
//!
//! Emitters are divided into classes by the code that samples them, such as meshes without textures. Each class has a loop
//! over all slots that discards its result in slots of other classes: few scenes have emitters of more than two.

use super::cdf_search::{SearchLanes, search};
use super::environment::{EnvironmentLanes, Scratch};
use super::random_numbers::NumberLanes;
use super::segment::Segment;
use super::surfaces::PointLanes;
use crate::math::{field, vec3};
use crate::scene::emitter::{self, DirectSample, on_sphere, on_triangle, select_emitter};
use crate::scene::{NONE, SurfacePoint, Tables, emitter_kind, quadric_kind};
use crate::simd::lanes::Vec3Lanes;
use crate::simd::{SimdLevel, multiversioned};
use bytemuck::Zeroable;
use glam::Vec2;

/// Classes of emitters, as bits.
mod class {
    /// Any, sampled slot by slot.
    pub const OTHER: u32 = 1;
    /// A mesh without a texture.
    pub const MESH: u32 = 2;
    /// A sphere without a texture.
    pub const SPHERE: u32 = 4;
    /// The environment.
    pub const ENVIRONMENT: u32 = 8;
}

/// The most emitters that are selected among by comparison with the cumulative probability of each.
const MAX_COMPARED: usize = 24;

/// Emitter samples of up to `N` paths.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct EmitterSampleLanes<const N: usize> {
    direction: Vec3Lanes<N>,
    distance: [f32; N],
    target: Vec3Lanes<N>,
    radiance: Vec3Lanes<N>,
    pdf: [f32; N],
    is_delta: [u32; N],
    pub emitter: [u32; N],
    /// One of [`class`].
    class: [u32; N],
}

/// The surface points that are lit, and the random numbers of their emitter samples.
#[derive(Clone, Copy)]
pub(super) struct References<'a, const N: usize> {
    pub points: &'a PointLanes<N>,
    pub numbers: &'a NumberLanes<N>,
    pub segment: Segment,
}

impl<const N: usize> EmitterSampleLanes<N> {
    /// The sample at slot `k < N`.
    #[inline(always)]
    pub fn get(&self, k: usize) -> DirectSample {
        DirectSample {
            direction: self.direction.get(k),
            distance: self.distance[k],
            target: self.target.get(k),
            radiance: self.radiance.get(k),
            pdf: self.pdf[k],
            is_delta: self.is_delta[k],
            emitter: self.emitter[k],
        }
    }

    /// Sets slot `k < N`, except for its emitter.
    #[inline(always)]
    fn set(&mut self, k: usize, light: &DirectSample) {
        self.direction.set(k, light.direction);
        self.distance[k] = light.distance;
        self.target.set(k, light.target);
        self.radiance.set(k, light.radiance);
        self.pdf[k] = light.pdf;
        self.is_delta[k] = light.is_delta;
    }

    /// [`emitter::sample_direct`] at the surface points of a segment.
    pub fn sample(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        at: &References<'_, N>,
        environment: &mut EnvironmentLanes<N>,
        scratch: Scratch<'_, N>,
    ) {
        if tables.emitters.len() > MAX_COMPARED {
            for k in at.segment.occupied::<N>() {
                self.emitter[k] = select_emitter(tables, at.numbers.emitter[k]);
            }
        } else {
            select_by_comparison(simd, tables, at, &mut self.emitter);
        }
        let mut classes = 0;
        let (emitters, class) = (&self.emitter, &mut self.class);
        classify(simd, tables, at.segment, emitters, class, &mut classes);
        if classes & class::MESH != 0 {
            let searches = &mut *scratch.searches;
            begin_triangle_search(simd, tables, at, self, searches);
            search(simd, tables.data, at.segment, searches);
            let sample_triangles = match tables.normals {
                [] => sample_triangles::<false, N>,
                _ => sample_triangles::<true, N>,
            };
            sample_triangles(simd, tables, at, searches, self);
        }
        if classes & class::SPHERE != 0 {
            sample_spheres(simd, tables, at, self);
        }
        if classes & class::ENVIRONMENT != 0 {
            environment.sample(simd, tables, at.numbers, at.segment, scratch);
            set_environment(simd, tables, at.segment, environment, self);
        }
        if classes & class::OTHER != 0 {
            self.sample_others(tables, at);
        }
    }

    /// Samples emitters of no other class, slot by slot.
    #[inline(never)]
    fn sample_others(&mut self, tables: &Tables<'_>, at: &References<'_, N>) {
        for k in at.segment.occupied::<N>() {
            if self.class[k] == class::OTHER {
                let emitter = self.emitter[k];
                let u = at.numbers.emitter_point(k);
                let position = at.points.get(k).position;
                let mut light = emitter::sample_emitter(tables, emitter, position, u);
                light.pdf *= tables.emitters[emitter as usize].selection_pdf;
                self.set(k, &light);
            }
        }
    }
}

multiversioned! {
    /// [`select_emitter`] by comparison with all of them.
    fn select_by_comparison<; const N: usize>(
        tables: &Tables<'_>,
        at: &References<'_, N>,
        chosen: &mut [u32; N],
    ) {
        for k in at.segment.padded::<N>() {
            chosen[k] = 0;
        }
        for i in 1..tables.emitters.len() {
            // The first emitter whose cumulative probability is above u, or the last.
            let before = tables.emitters[i - 1].selection_cdf;
            for k in at.segment.padded::<N>() {
                chosen[k] += (before <= at.numbers.emitter[k]) as u32;
            }
        }
        for k in at.segment.padded::<N>() {
            let pdf = field(tables.emitters, chosen[k], |e| e.selection_pdf);
            chosen[k] = if pdf > 0.0 { chosen[k] } else { NONE };
        }
    }

    /// The class of each selected emitter, and the union of all.
    fn classify<; const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        chosen: &[u32; N],
        classes: &mut [u32; N],
        all: &mut u32,
    ) {
        let mut found = 0;
        for k in segment.padded::<N>() {
            let i = chosen[k];
            let shape = field(tables.emitters, i, |e| e.shape);
            let is_area = (field(tables.emitters, i, |e| e.kind) == emitter_kind::AREA)
                & (field(tables.emitters, i, |e| e.radiance.texture) == NONE)
                & (shape != NONE);
            // The first primitive of a shape is an index into the triangles or into the quadrics; only one of them names the shape.
            let first = field(tables.shapes, shape, |s| s.first_primitive);
            let is_quadric = (first < tables.quadrics.len() as u32)
                & (field(tables.quadrics, first, |q| q.shape) == shape);
            let is_sphere =
                is_quadric & (field(tables.quadrics, first, |q| q.kind) == quadric_kind::SPHERE);
            let of_area = if is_sphere {
                class::SPHERE
            } else if is_quadric {
                class::OTHER
            } else {
                class::MESH
            };
            let class = if is_area { of_area } else { class::OTHER };
            let is_environment = i == tables.info.environment;
            let class = if is_environment { class::ENVIRONMENT } else { class };
            // Without emitters: a mesh of no triangles, whose samples are empty.
            let class = if i == NONE { class::MESH } else { class };
            classes[k] = class;
            found |= class;
        }
        *all = found;
    }

    /// Begins the search for a triangle of each mesh.
    fn begin_triangle_search<; const N: usize>(
        tables: &Tables<'_>,
        at: &References<'_, N>,
        samples: &EmitterSampleLanes<N>,
        searches: &mut SearchLanes<N>,
    ) {
        for k in at.segment.padded::<N>() {
            let i = samples.emitter[k];
            let shape = field(tables.emitters, i, |e| e.shape);
            let count = field(tables.shapes, shape, |s| s.primitive_count);
            let last = if samples.class[k] == class::MESH { count.saturating_sub(1) } else { 0 };
            let table = field(tables.emitters, i, |e| e.distribution);
            searches.set(k, table, at.numbers.emitter_point(k).x, 0, last);
        }
    }

    /// Points on the triangles that were found; without `NORMALS` if no mesh has them.
    fn sample_triangles<; const NORMALS: bool, const N: usize>(
        tables: &Tables<'_>,
        at: &References<'_, N>,
        searches: &SearchLanes<N>,
        samples: &mut EmitterSampleLanes<N>,
    ) {
        let tables = &Tables {
            normals: if NORMALS { tables.normals } else { &[] },
            uvs: &[],
            ..*tables
        };
        for k in at.segment.padded::<N>() {
            let i = samples.emitter[k];
            let shape = field(tables.emitters, i, |e| e.shape);
            let first = field(tables.shapes, shape, |s| s.first_primitive);
            let (triangle, u, pmf) = searches.found(tables.data, k);
            let u = Vec2::new(u, at.numbers.emitter_point(k).y);
            let reference = at.points.get(k).position;
            let (sample, point) = on_triangle(tables, first + triangle, pmf, reference, u);
            let light = with_emission(tables, i, sample, &point);
            if samples.class[k] == class::MESH {
                samples.set(k, &light);
            }
        }
    }

    /// Points on spheres.
    fn sample_spheres<; const N: usize>(
        tables: &Tables<'_>,
        at: &References<'_, N>,
        samples: &mut EmitterSampleLanes<N>,
    ) {
        for k in at.segment.padded::<N>() {
            let i = samples.emitter[k];
            let shape = field(tables.emitters, i, |e| e.shape);
            let index = field(tables.shapes, shape, |s| s.first_primitive);
            let u = at.numbers.emitter_point(k);
            let (sample, point) = on_sphere(tables, index, at.points.get(k).position, u);
            let light = with_emission(tables, i, sample, &point);
            if samples.class[k] == class::SPHERE {
                samples.set(k, &light);
            }
        }
    }

    /// Samples of the environment.
    fn set_environment<; const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        environment: &EnvironmentLanes<N>,
        samples: &mut EmitterSampleLanes<N>,
    ) {
        let selection_pdf = field(tables.emitters, tables.info.environment, |e| e.selection_pdf);
        for k in segment.padded::<N>() {
            let light = DirectSample {
                direction: environment.direction.get(k),
                distance: f32::MAX,
                radiance: environment.radiance.get(k),
                pdf: environment.pdf[k] * selection_pdf,
                ..DirectSample::NONE
            };
            if samples.class[k] == class::ENVIRONMENT {
                samples.set(k, &light);
            }
        }
    }
}

/// A sampled point of an emitter without a texture, completed by what it emits.
#[inline(always)]
fn with_emission(
    tables: &Tables<'_>,
    emitter: u32,
    sample: DirectSample,
    point: &SurfacePoint,
) -> DirectSample {
    if !(sample.pdf > 0.0) {
        return DirectSample::NONE;
    }
    let mut light = sample;
    light.target = point.offset_position(-light.direction);
    if point.frame.n.dot(-light.direction) > 0.0 {
        light.radiance = vec3(field(tables.emitters, emitter, |e| e.radiance.value));
    }
    light.pdf *= field(tables.emitters, emitter, |e| e.selection_pdf);
    light
}
