//! The environment, in lanes: [`crate::scene::emitter::environment`].

use super::cdf_search::{SearchLanes, search};
use super::paths::QueuedPaths;
use super::random_numbers::NumberLanes;
use super::segment::Segment;
use super::textures::TextureLanes;
use crate::math::affine::transform_vector;
use crate::math::distribution::guided_range;
use crate::math::warp::{UNIFORM_SPHERE_PDF, square_to_uniform_sphere};
use crate::math::{Rgb, field, vec3};
use crate::scene::emitter::environment::{
    cell, columns, has_table, in_cell, pdf_of_cell, rows, to_texture, to_uv,
};
use crate::scene::{Emitter, NONE, Tables, emitter_kind};
use crate::simd::lanes::Vec3Lanes;
use crate::simd::{SimdLevel, multiversioned};
use crate::transport::settings::IntegratorSettings;
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};

/// Directions to the environment, and its radiance there, of up to `N` paths.
#[repr(C, align(64))]
#[derive(Zeroable)]
pub(super) struct EnvironmentLanes<const N: usize> {
    pub direction: Vec3Lanes<N>,
    /// The density of sampling the direction, without the choice of the emitter.
    pub pdf: [f32; N],
    pub radiance: Vec3Lanes<N>,
    /// Image coordinates, then those of the texture.
    uv: [[f32; N]; 2],
    /// The sampled rows of the table, and the random numbers rescaled within them.
    row: [u32; N],
    row_position: [f32; N],
}

/// Working memory of the lookups.
pub(super) struct Scratch<'a, const N: usize> {
    pub searches: &'a mut SearchLanes<N>,
    pub textures: &'a mut TextureLanes<N>,
}

/// The environment emitter.
#[inline]
fn environment<'a>(tables: &Tables<'a>) -> &'a Emitter {
    &tables.emitters[tables.info.environment as usize]
}

impl<const N: usize> EnvironmentLanes<N> {
    /// [`crate::scene::emitter::environment::sample`] at the slots of a segment.
    pub fn sample(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        numbers: &NumberLanes<N>,
        segment: Segment,
        scratch: Scratch<'_, N>,
    ) {
        let emitter = environment(tables);
        if has_table(emitter) {
            let searches = scratch.searches;
            begin_rows(simd, tables, emitter, segment, numbers, searches);
            search(simd, tables.data, segment, searches);
            finish_rows(simd, tables, segment, searches, self);
            begin_columns(simd, tables, emitter, segment, numbers, &self.row, searches);
            search(simd, tables.data, segment, searches);
            sample_cells(simd, tables, emitter, segment, searches, self);
        } else {
            sample_uniform_sphere(simd, emitter, segment, numbers, self);
        }
        self.look_up_radiance(simd, tables, segment, scratch.textures);
    }

    /// Radiance and density along the rays of paths that meet nothing.
    pub fn look_up(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        queued: &QueuedPaths<'_, N>,
        textures: &mut TextureLanes<N>,
    ) {
        let emitter = environment(tables);
        if has_table(emitter) {
            look_up_densities::<true, N>(simd, tables, emitter, queued, self);
        } else {
            look_up_densities::<false, N>(simd, tables, emitter, queued, self);
        }
        self.look_up_radiance(simd, tables, queued.segment, textures);
    }

    /// Radiance at the image coordinates.
    fn look_up_radiance(
        &mut self,
        simd: SimdLevel,
        tables: &Tables<'_>,
        segment: Segment,
        textures: &mut TextureLanes<N>,
    ) {
        let emitter = environment(tables);
        let value = vec3(emitter.radiance.value);
        if emitter.kind != emitter_kind::ENVIRONMENT || emitter.radiance.texture == NONE {
            for k in segment.padded::<N>() {
                self.radiance.set(k, value);
            }
            return;
        }
        transform_coordinates(
            simd,
            tables,
            emitter,
            segment,
            &mut self.uv,
            &mut textures.texture,
        );
        textures.look_up(simd, tables, segment, &self.uv, None);
        for k in segment.padded::<N>() {
            self.radiance.set(k, value * textures.value.get(k));
        }
    }
}

multiversioned! {
    /// Begins the searches for the rows of cells.
    fn begin_rows<; const N: usize>(
        tables: &Tables<'_>,
        emitter: &Emitter,
        segment: Segment,
        numbers: &NumberLanes<N>,
        searches: &mut SearchLanes<N>,
    ) {
        let (table, guide) = rows(emitter);
        for k in segment.padded::<N>() {
            let u = numbers.emitter_point(k).y;
            let (low, high) = guided_range(tables.data, guide, u);
            searches.set(k, table, u, low, high);
        }
    }

    /// Stores the rows that were found.
    fn finish_rows<; const N: usize>(
        tables: &Tables<'_>,
        segment: Segment,
        searches: &SearchLanes<N>,
        lanes: &mut EnvironmentLanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let (row, t, _) = searches.found(tables.data, k);
            lanes.row[k] = row;
            lanes.row_position[k] = t;
        }
    }

    /// Begins the searches for the cells in their rows.
    fn begin_columns<; const N: usize>(
        tables: &Tables<'_>,
        emitter: &Emitter,
        segment: Segment,
        numbers: &NumberLanes<N>,
        row: &[u32; N],
        searches: &mut SearchLanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let u = numbers.emitter_point(k).x;
            let (table, guide) = columns(emitter, row[k]);
            let (low, high) = guided_range(tables.data, guide, u);
            searches.set(k, table, u, low, high);
        }
    }

    /// Directions within the cells that were found.
    fn sample_cells<; const N: usize>(
        tables: &Tables<'_>,
        emitter: &Emitter,
        segment: Segment,
        searches: &SearchLanes<N>,
        lanes: &mut EnvironmentLanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let row = lanes.row[k];
            let (column, t, _) = searches.found(tables.data, k);
            let t = Vec2::new(t, lanes.row_position[k]);
            let (direction, uv) = in_cell(tables, emitter, [column, row], t);
            let pdf = pdf_of_cell(tables, emitter, column, row);
            lanes.direction.set(k, direction);
            lanes.pdf[k] = if direction == Vec3::ZERO { 0.0 } else { pdf };
            lanes.uv[0][k] = uv.x;
            lanes.uv[1][k] = uv.y;
        }
    }

    /// Uniformly distributed directions.
    fn sample_uniform_sphere<; const N: usize>(
        emitter: &Emitter,
        segment: Segment,
        numbers: &NumberLanes<N>,
        lanes: &mut EnvironmentLanes<N>,
    ) {
        for k in segment.padded::<N>() {
            let direction = square_to_uniform_sphere(numbers.emitter_point(k));
            let uv = to_uv(transform_vector(&emitter.to_local, direction));
            lanes.direction.set(k, direction);
            lanes.pdf[k] = UNIFORM_SPHERE_PDF;
            lanes.uv[0][k] = uv.x;
            lanes.uv[1][k] = uv.y;
        }
    }

    /// Image coordinates and densities of the directions of rays; the density is uniform without a table.
    fn look_up_densities<; const HAS_TABLE: bool, const N: usize>(
        tables: &Tables<'_>,
        emitter: &Emitter,
        queued: &QueuedPaths<'_, N>,
        lanes: &mut EnvironmentLanes<N>,
    ) {
        for k in queued.segment.padded::<N>() {
            let direction = queued.paths.rays.direction.gather(queued.entries[k]);
            let uv = to_uv(transform_vector(&emitter.to_local, direction));
            lanes.pdf[k] = if HAS_TABLE {
                let (column, row) = cell(emitter, uv);
                pdf_of_cell(tables, emitter, column, row)
            } else {
                UNIFORM_SPHERE_PDF
            };
            lanes.uv[0][k] = uv.x;
            lanes.uv[1][k] = uv.y;
        }
    }

    /// Transforms image coordinates to those of the texture, and requests its lookup.
    fn transform_coordinates<; const N: usize>(
        tables: &Tables<'_>,
        emitter: &Emitter,
        segment: Segment,
        coordinates: &mut [[f32; N]; 2],
        textures: &mut [u32; N],
    ) {
        for k in segment.padded::<N>() {
            let uv = Vec2::new(coordinates[0][k], coordinates[1][k]);
            let uv = to_texture(tables, emitter, uv);
            coordinates[0][k] = uv.x;
            coordinates[1][k] = uv.y;
            textures[k] = emitter.radiance.texture;
        }
    }

    /// What escaped paths gain from the environment.
    pub(super) fn weighted_radiance<; const N: usize>(
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        queued: &QueuedPaths<'_, N>,
        environment: &EnvironmentLanes<N>,
        gain: &mut Vec3Lanes<N>,
    ) {
        let selection_pdf = field(tables.emitters, tables.info.environment, |e| e.selection_pdf);
        for k in queued.segment.padded::<N>() {
            let mut path = queued.paths.gather(queued.entries[k]);
            path.add_weighted(environment.radiance.get(k), environment.pdf[k] * selection_pdf);
            let sees = path.subpath.sees_emitters(&settings.rules);
            gain.set(k, if sees { path.radiance } else { Rgb::ZERO });
        }
    }
}
