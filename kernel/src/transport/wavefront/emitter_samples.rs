//! Emitter points that light many surface points, side by side.
//!
//! Emitters of a form, such as meshes without textures, have a loop of their own over all slots, which leaves those of
//! other forms alone: few scenes have more than two.

use super::cdf_search::{SearchLanes, search};
use super::environment::{EnvironmentLanes, Scratch};
use super::segment::Segment;
use super::surfaces::PointLanes;
use crate::math::{field, vec3};
use crate::scene::emitter::{self, DirectSample, on_sphere, on_triangle, select_emitter};
use crate::scene::{NONE, SurfacePoint, Tables, emitter_kind, quadric_kind};
use crate::simd::lanes::Vec3Lanes;
use crate::simd::{SimdLevel, multiversioned};
use bytemuck::Zeroable;
use glam::Vec2;

/// Forms of emitters, as bits.
mod form {
    /// Any, sampled one after the other.
    pub const OTHER: u32 = 1;
    /// A mesh without a texture.
    pub const MESH: u32 = 2;
    /// A sphere without a texture.
    pub const SPHERE: u32 = 4;
    /// The environment.
    pub const ENVIRONMENT: u32 = 8;
}

/// The most emitters among which the choice is a comparison with each.
const MAX_COMPARED: usize = 24;

/// The chosen emitter points of up to `N` paths.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct LightLanes<const N: usize> {
    direction: Vec3Lanes<N>,
    distance: [f32; N],
    target: Vec3Lanes<N>,
    radiance: Vec3Lanes<N>,
    pdf: [f32; N],
    is_delta: [u32; N],
    emitter: [u32; N],
    form: [u32; N],
}

impl<const N: usize> LightLanes<N> {
    /// The sample at slot `k < N`.
    #[inline(always)]
    pub fn get(&self, k: usize) -> DirectSample {
        DirectSample {
            direction: self.direction.get(k),
            distance: self.distance[k],
            target: self.target.get(k),
            radiance: self.radiance.get(k),
            pdf: self.pdf[k],
            is_delta: self.is_delta[k] != 0,
            emitter: self.emitter[k],
        }
    }

    /// Sets slot `k < N` but for its emitter.
    #[inline(always)]
    fn set(&mut self, k: usize, light: &DirectSample) {
        self.direction.set(k, light.direction);
        self.distance[k] = light.distance;
        self.target.set(k, light.target);
        self.radiance.set(k, light.radiance);
        self.pdf[k] = light.pdf;
        self.is_delta[k] = light.is_delta as u32;
    }

    /// [`emitter::sample_direct`] at the points of a segment; `numbers` hold what chooses the emitter, then its point.
    pub fn choose(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        points: &PointLanes<N>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
        environment: &mut EnvironmentLanes<N>,
        scratch: Scratch<'_, N>,
    ) {
        if tables.emitters.len() > MAX_COMPARED {
            for k in segment.taken::<N>() {
                self.emitter[k] = select_emitter(tables, numbers[0][k]);
            }
        } else {
            compare(simd, tables, numbers, segment, &mut self.emitter);
        }
        let mut forms = 0;
        tell_forms(
            simd,
            tables,
            segment,
            &self.emitter,
            &mut self.form,
            &mut forms,
        );
        if forms & form::MESH != 0 {
            let searches = &mut *scratch.searches;
            begin_meshes(
                simd,
                tables,
                numbers,
                segment,
                &self.emitter,
                &self.form,
                searches,
            );
            search(simd, tables.data, segment, searches);
            let finish = match tables.normals {
                [] => finish_meshes::<false, N>,
                _ => finish_meshes::<true, N>,
            };
            finish(simd, tables, points, numbers, segment, searches, self);
        }
        if forms & form::SPHERE != 0 {
            spheres(simd, tables, points, numbers, segment, self);
        }
        if forms & form::ENVIRONMENT != 0 {
            environment.sample(simd, tables, numbers, segment, scratch);
            shine(simd, tables, segment, environment, self);
        }
        if forms & form::OTHER != 0 {
            self.others(tables, points, numbers, segment);
        }
    }

    /// Samples those that have no loop of their own.
    #[inline(never)]
    fn others(
        &mut self,
        tables: &Tables<'_>,
        points: &PointLanes<N>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
    ) {
        for k in segment.taken::<N>() {
            if self.form[k] == form::OTHER {
                let emitter = self.emitter[k];
                let u = Vec2::new(numbers[1][k], numbers[2][k]);
                let position = points.get(k).position;
                let mut light = emitter::sample_emitter(tables, emitter, position, u);
                light.pdf *= tables.emitters[emitter as usize].selection_pdf;
                self.set(k, &light);
            }
        }
    }
}

multiversioned! {
    /// [`select_emitter`] by comparison with all of them.
    fn compare<; const N: usize>(
        tables: &Tables<'_>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
        chosen: &mut [u32; N],
    ) {
        for k in segment.slots::<N>() {
            chosen[k] = 0;
        }
        for i in 1..tables.emitters.len() {
            // The first emitter whose cumulative probability is above u, or the last.
            let before = tables.emitters[i - 1].selection_cdf;
            for k in segment.slots::<N>() {
                chosen[k] += (before <= numbers[0][k]) as u32;
            }
        }
        for k in segment.slots::<N>() {
            let pdf = field(tables.emitters, chosen[k], |e| e.selection_pdf);
            chosen[k] = if pdf > 0.0 { chosen[k] } else { NONE };
        }
    }

    /// The form of each emitter, and all of them together.
    fn tell_forms<; const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        chosen: &[u32; N],
        forms: &mut [u32; N],
        all: &mut u32,
    ) {
        let mut found = 0;
        for k in segment.slots::<N>() {
            let i = chosen[k];
            let shape = field(tables.emitters, i, |e| e.shape);
            let is_area = (field(tables.emitters, i, |e| e.kind) == emitter_kind::AREA)
                & (field(tables.emitters, i, |e| e.radiance.texture) == NONE)
                & (shape != NONE);
            // Only one of two tables holds the shape at its first primitive.
            let first = field(tables.shapes, shape, |s| s.first_primitive);
            let is_quadric = (first < tables.quadrics.len() as u32)
                & (field(tables.quadrics, first, |q| q.shape) == shape);
            let is_sphere =
                is_quadric & (field(tables.quadrics, first, |q| q.kind) == quadric_kind::SPHERE);
            let of_area = if is_sphere {
                form::SPHERE
            } else if is_quadric {
                form::OTHER
            } else {
                form::MESH
            };
            let form = if is_area { of_area } else { form::OTHER };
            let is_environment = i == tables.info.environment;
            let form = if is_environment { form::ENVIRONMENT } else { form };
            // Nothing was chosen in the dark.
            let form = if i == NONE { form::MESH } else { form };
            forms[k] = form;
            found |= form;
        }
        *all = found;
    }

    /// Searches for a triangle of each mesh.
    fn begin_meshes<; const N: usize>(
        tables: &Tables<'_>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
        chosen: &[u32; N],
        forms: &[u32; N],
        searches: &mut SearchLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let i = chosen[k];
            let shape = field(tables.emitters, i, |e| e.shape);
            let count = field(tables.shapes, shape, |s| s.primitive_count);
            let last = if forms[k] == form::MESH { count.saturating_sub(1) } else { 0 };
            let table = field(tables.emitters, i, |e| e.distribution);
            searches.set(k, table, numbers[1][k], 0, last);
        }
    }

    /// Points of the triangles that were found; without `NORMALS` if no mesh has them.
    fn finish_meshes<; const NORMALS: bool, const N: usize>(
        tables: &Tables<'_>,
        points: &PointLanes<N>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
        searches: &SearchLanes<N>,
        lights: &mut LightLanes<N>,
    ) {
        let tables = &Tables {
            normals: if NORMALS { tables.normals } else { &[] },
            uvs: &[],
            ..*tables
        };
        for k in segment.slots::<N>() {
            let i = lights.emitter[k];
            let shape = field(tables.emitters, i, |e| e.shape);
            let first = field(tables.shapes, shape, |s| s.first_primitive);
            let (triangle, u, pmf) = searches.found(tables.data, k);
            let u = Vec2::new(u, numbers[2][k]);
            let reference = points.get(k).position;
            let (sample, point) = on_triangle(tables, first + triangle, pmf, reference, u);
            let light = shining(tables, i, sample, &point);
            if lights.form[k] == form::MESH {
                lights.set(k, &light);
            }
        }
    }

    /// Points of spheres.
    fn spheres<; const N: usize>(
        tables: &Tables<'_>,
        points: &PointLanes<N>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
        lights: &mut LightLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let i = lights.emitter[k];
            let shape = field(tables.emitters, i, |e| e.shape);
            let index = field(tables.shapes, shape, |s| s.first_primitive);
            let u = Vec2::new(numbers[1][k], numbers[2][k]);
            let (sample, point) = on_sphere(tables, index, points.get(k).position, u);
            let light = shining(tables, i, sample, &point);
            if lights.form[k] == form::SPHERE {
                lights.set(k, &light);
            }
        }
    }

    /// Directions of the environment.
    fn shine<; const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        environment: &EnvironmentLanes<N>,
        lights: &mut LightLanes<N>,
    ) {
        let selection_pdf = field(tables.emitters, tables.info.environment, |e| e.selection_pdf);
        for k in segment.slots::<N>() {
            let light = DirectSample {
                direction: environment.direction.get(k),
                distance: f32::MAX,
                radiance: environment.radiance.get(k),
                pdf: environment.pdf[k] * selection_pdf,
                ..DirectSample::NONE
            };
            if lights.form[k] == form::ENVIRONMENT {
                lights.set(k, &light);
            }
        }
    }
}

/// A point of an emitter without a texture, with its light.
#[inline(always)]
fn shining(
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
