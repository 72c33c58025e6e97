//! Light from infinity, side by side: [`crate::scene::emitter::environment`].

use super::cdf_search::{SearchLanes, search};
use super::paths::PathLanes;
use super::segment::Segment;
use super::textures::TextureLanes;
use crate::math::affine::transform_vector;
use crate::math::distribution::guided_range;
use crate::math::warp::{UNIFORM_SPHERE_PDF, square_to_uniform_sphere};
use crate::math::{Rgb, vec3};
use crate::scene::emitter::environment::{
    cell, columns, has_table, in_cell, pdf_of_cell, rows, to_texture, to_uv,
};
use crate::scene::{Emitter, NONE, Tables, emitter_kind};
use crate::simd::lanes::Vec3Lanes;
use crate::simd::{SimdLevel, multiversioned};
use crate::transport::IntegratorSettings;
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};

/// Directions towards the environment of up to `N` paths, and what comes from there.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct EnvironmentLanes<const N: usize> {
    pub direction: Vec3Lanes<N>,
    /// The density of choosing the direction, the choice of the emitter not included.
    pub pdf: [f32; N],
    pub radiance: Vec3Lanes<N>,
    /// Image coordinates, then those of the texture.
    uv: [[f32; N]; 2],
    row: [u32; N],
    t_row: [f32; N],
}

/// Room that lookups take.
pub(super) struct Scratch<'a, const N: usize> {
    pub searches: &'a mut SearchLanes<N>,
    pub textures: &'a mut TextureLanes<N>,
}

impl<const N: usize> EnvironmentLanes<N> {
    /// [`crate::scene::emitter::environment::sample`] of the environment with the second and the third of the `numbers`.
    pub fn sample(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        numbers: &[[f32; N]; 6],
        segment: Segment,
        scratch: Scratch<'_, N>,
    ) {
        let emitter = &tables.emitters[tables.info.environment as usize];
        let (x, y) = (&numbers[1], &numbers[2]);
        if has_table(emitter) {
            let searches = scratch.searches;
            begin_rows(simd, tables.data, emitter, segment, y, searches);
            search(simd, tables.data, segment, searches);
            let (row, t_row) = (&mut self.row, &mut self.t_row);
            begin_columns(simd, tables.data, emitter, segment, x, searches, row, t_row);
            search(simd, tables.data, segment, searches);
            aim(simd, tables, emitter, segment, searches, self);
        } else {
            evenly(simd, emitter, segment, x, y, self);
        }
        self.look_up(simd, tables, emitter, segment, scratch.textures);
    }

    /// Radiance and density of the directions of the paths of `list`, which meet nothing.
    pub fn look_at(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        paths: &PathLanes<N>,
        list: &[u32; N],
        segment: Segment,
        textures: &mut TextureLanes<N>,
    ) {
        let emitter = &tables.emitters[tables.info.environment as usize];
        let (pdf, uv) = (&mut self.pdf, &mut self.uv);
        if has_table(emitter) {
            find::<true, N>(simd, tables, emitter, paths, list, segment, pdf, uv);
        } else {
            find::<false, N>(simd, tables, emitter, paths, list, segment, pdf, uv);
        }
        self.look_up(simd, tables, emitter, segment, textures);
    }

    /// Radiance at the image coordinates.
    fn look_up(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        emitter: &Emitter,
        segment: Segment,
        textures: &mut TextureLanes<N>,
    ) {
        let texture = emitter.radiance.texture;
        let value = vec3(emitter.radiance.value);
        if emitter.kind != emitter_kind::ENVIRONMENT || texture == NONE {
            for k in segment.slots::<N>() {
                self.radiance.set(k, value);
            }
            return;
        }
        ask(
            simd,
            tables,
            emitter,
            segment,
            &mut self.uv,
            &mut textures.texture,
        );
        textures.look_up(simd, tables, segment, &self.uv, None);
        for k in segment.slots::<N>() {
            self.radiance.set(k, value * textures.value.get(k));
        }
    }
}

multiversioned! {
    /// Begins to search for the rows of cells.
    fn begin_rows<; const N: usize>(
        data: &[f32],
        emitter: &Emitter,
        segment: Segment,
        numbers: &[f32; N],
        searches: &mut SearchLanes<N>,
    ) {
        let (table, guide) = rows(emitter);
        for k in segment.slots::<N>() {
            let (low, high) = guided_range(data, guide, numbers[k]);
            searches.set(k, table, numbers[k], low, high);
        }
    }

    /// Keeps the rows, and begins to search for the cells.
    fn begin_columns<; const N: usize>(
        data: &[f32],
        emitter: &Emitter,
        segment: Segment,
        numbers: &[f32; N],
        searches: &mut SearchLanes<N>,
        chosen: &mut [u32; N],
        position: &mut [f32; N],
    ) {
        for k in segment.slots::<N>() {
            let (row, t, _) = searches.found(data, k);
            chosen[k] = row;
            position[k] = t;
            let (table, guide) = columns(emitter, row);
            let (low, high) = guided_range(data, guide, numbers[k]);
            searches.set(k, table, numbers[k], low, high);
        }
    }

    /// Directions in the cells.
    fn aim<; const N: usize>(
        tables: &Tables<'_>,
        emitter: &Emitter,
        segment: Segment,
        searches: &SearchLanes<N>,
        lanes: &mut EnvironmentLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let row = lanes.row[k];
            let (column, t, _) = searches.found(tables.data, k);
            let t = Vec2::new(t, lanes.t_row[k]);
            let (direction, uv) = in_cell(tables, emitter, [column, row], t);
            let pdf = pdf_of_cell(tables, emitter, column, row);
            lanes.direction.set(k, direction);
            lanes.pdf[k] = if direction == Vec3::ZERO { 0.0 } else { pdf };
            lanes.uv[0][k] = uv.x;
            lanes.uv[1][k] = uv.y;
        }
    }

    /// Uniform directions.
    fn evenly<; const N: usize>(
        emitter: &Emitter,
        segment: Segment,
        x: &[f32; N],
        y: &[f32; N],
        lanes: &mut EnvironmentLanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let direction = square_to_uniform_sphere(Vec2::new(x[k], y[k]));
            let uv = to_uv(transform_vector(&emitter.to_local, direction));
            lanes.direction.set(k, direction);
            lanes.pdf[k] = UNIFORM_SPHERE_PDF;
            lanes.uv[0][k] = uv.x;
            lanes.uv[1][k] = uv.y;
        }
    }

    /// Image coordinates and densities of the paths' directions, which are uniform without a table.
    fn find<; const HAS_TABLE: bool, const N: usize>(
        tables: &Tables<'_>,
        emitter: &Emitter,
        paths: &PathLanes<N>,
        list: &[u32; N],
        segment: Segment,
        pdf: &mut [f32; N],
        coordinates: &mut [[f32; N]; 2],
    ) {
        for k in segment.slots::<N>() {
            let direction = paths.rays.direction.gather(list[k]);
            let uv = to_uv(transform_vector(&emitter.to_local, direction));
            pdf[k] = if HAS_TABLE {
                let (column, row) = cell(emitter, uv);
                pdf_of_cell(tables, emitter, column, row)
            } else {
                UNIFORM_SPHERE_PDF
            };
            coordinates[0][k] = uv.x;
            coordinates[1][k] = uv.y;
        }
    }

    /// The texture and its coordinates.
    fn ask<; const N: usize>(
        tables: &Tables<'_>,
        emitter: &Emitter,
        segment: Segment,
        coordinates: &mut [[f32; N]; 2],
        textures: &mut [u32; N],
    ) {
        for k in segment.slots::<N>() {
            let uv = Vec2::new(coordinates[0][k], coordinates[1][k]);
            let uv = to_texture(tables, emitter, uv);
            coordinates[0][k] = uv.x;
            coordinates[1][k] = uv.y;
            textures[k] = emitter.radiance.texture;
        }
    }

    /// What the paths gather from where they look at.
    pub(super) fn add_radiance<; const N: usize>(
        settings: &IntegratorSettings,
        paths: &PathLanes<N>,
        list: &[u32; N],
        segment: Segment,
        selection_pdf: f32,
        seen: &EnvironmentLanes<N>,
        gathered: &mut Vec3Lanes<N>,
    ) {
        for k in segment.slots::<N>() {
            let mut path = paths.gather(list[k]);
            path.add_weighted(seen.radiance.get(k), seen.pdf[k] * selection_pdf);
            let sees = path.sees_emitters(settings);
            gathered.set(k, if sees { path.radiance } else { Rgb::ZERO });
        }
    }
}
