//! Light from infinity: a constant, or an image over the sphere of directions.
//!
//! Directions in the emitter's frame map to the image by latitude and longitude with +y up:
//! `u = atan2(x, -z) / (2 pi)` wrapped to [0, 1), `v = theta / pi` with theta from +y. Columns are centred at
//! `(i + 1/2) / w` and wrap around; the first and the last row lie on the poles, `v = j / (h - 1)` (the orientation and
//! the rows of Mitsuba 3; numbers in the tests). Between texels the radiance is bilinear in (u, v).
//!
//! The sampling table has one cell per patch between four texel centres: w columns, h - 1 rows, weighted by the mean
//! luminance of the four corners, which is the exact mean of the bilinear patch, times the exact solid angle of its
//! row. Inside a cell directions are uniform in solid angle, so the density is `pmf / (delta_phi delta_cos)`: without
//! a singularity at the poles, and positive wherever the radiance is.
//!
//! Invariants (tests): the density integrates to one; the sampled density is the stated one; lookups agree with an
//! independent renderer. The emitter's frame is a rotation or a reflection; scales are divided out.

use super::direct_sample::DirectSample;
use crate::math::affine::transform_vector;
use crate::math::distribution::{GUIDE_WORDS, cdf_pmf, sample_cdf_guided};
use crate::math::warp::{UNIFORM_SPHERE_PDF, square_to_uniform_sphere};
use crate::math::{Rgb, element, float, vec3};
use crate::scene::texture::eval_uv;
use crate::scene::{Emitter, NONE, Tables, emitter_kind, features, texture_kind};
use core::f32::consts::{FRAC_1_PI, PI, TAU};
use glam::{Vec2, Vec3};

/// The radiance that arrives from a unit `direction` (away from the scene); zero without an environment.
pub fn environment_radiance(tables: &Tables<'_>, direction: Vec3) -> Rgb {
    let index = tables.info.environment;
    if !tables.has(features::ENVIRONMENT) || index == NONE {
        return Vec3::ZERO;
    }
    let emitter = &tables.emitters[index as usize];
    if emitter.kind != emitter_kind::ENVIRONMENT {
        return vec3(emitter.radiance.value);
    }
    radiance_at(
        tables,
        emitter,
        to_uv(transform_vector(&emitter.to_local, direction)),
    )
}

/// [`environment_radiance`] and [`pdf_environment`] of the same direction.
pub fn environment_radiance_and_pdf(tables: &Tables<'_>, direction: Vec3) -> (Rgb, f32) {
    let index = tables.info.environment;
    if !tables.has(features::ENVIRONMENT) || index == NONE {
        return (Vec3::ZERO, 0.0);
    }
    let emitter = &tables.emitters[index as usize];
    if emitter.kind != emitter_kind::ENVIRONMENT {
        let pdf = UNIFORM_SPHERE_PDF * emitter.selection_pdf;
        return (vec3(emitter.radiance.value), pdf);
    }
    let uv = to_uv(transform_vector(&emitter.to_local, direction));
    let pdf = if has_table(emitter) {
        let (column, row) = cell(emitter, uv);
        pdf_of_cell(tables, emitter, column, row)
    } else {
        UNIFORM_SPHERE_PDF
    };
    (
        radiance_at(tables, emitter, uv),
        pdf * emitter.selection_pdf,
    )
}

/// The density per solid angle with which [`super::sample_direct`] chooses `direction` by the environment, the choice
/// of the emitter included.
pub fn pdf_environment(tables: &Tables<'_>, direction: Vec3) -> f32 {
    let index = tables.info.environment;
    if !tables.has(features::ENVIRONMENT) || index == NONE {
        return 0.0;
    }
    pdf(tables, index, direction) * tables.emitters[index as usize].selection_pdf
}

/// The density per solid angle with which [`sample`] chooses a `direction` (away from the scene), without the choice of the
/// emitter.
pub fn pdf(tables: &Tables<'_>, emitter: u32, direction: Vec3) -> f32 {
    let emitter = &tables.emitters[emitter as usize];
    if !has_table(emitter) {
        return UNIFORM_SPHERE_PDF;
    }
    let uv = to_uv(transform_vector(&emitter.to_local, direction));
    let (column, row) = cell(emitter, uv);
    pdf_of_cell(tables, emitter, column, row)
}

/// Samples a direction; `pdf` does not hold the probability of choosing the emitter.
pub fn sample(tables: &Tables<'_>, emitter: u32, u: Vec2) -> DirectSample {
    let record = &tables.emitters[emitter as usize];
    let mut result = DirectSample {
        distance: f32::MAX,
        emitter,
        ..DirectSample::NONE
    };
    if !has_table(record) {
        result.direction = square_to_uniform_sphere(u);
        result.pdf = UNIFORM_SPHERE_PDF;
        result.radiance = if record.kind == emitter_kind::ENVIRONMENT {
            let local = transform_vector(&record.to_local, result.direction);
            radiance_at(tables, record, to_uv(local))
        } else {
            vec3(record.radiance.value)
        };
        return result;
    }
    let (table, guide) = rows(record);
    let (row, t_row, _) = sample_cdf_guided(tables.data, table, guide, u.y);
    let (table, guide) = columns(record, row);
    let (column, t_column, _) = sample_cdf_guided(tables.data, table, guide, u.x);
    let (direction, uv) = in_cell(tables, record, [column, row], Vec2::new(t_column, t_row));
    if direction == Vec3::ZERO {
        return DirectSample::NONE;
    }
    result.direction = direction;
    result.pdf = pdf_of_cell(tables, record, column, row);
    result.radiance = radiance_at(tables, record, uv);
    result
}

/// The table that chooses a row of cells, and its guide.
#[inline]
pub(crate) fn rows(emitter: &Emitter) -> (u32, u32) {
    let (w, h) = (emitter.width, emitter.height);
    (emitter.distribution, emitter.distribution + h + w * h)
}

/// The table that chooses a cell of a row, and its guide.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn columns(emitter: &Emitter, row: u32) -> (u32, u32) {
    let (w, h) = (emitter.width, emitter.height);
    let table = emitter.distribution;
    (
        table + h + row * w,
        table + h + w * h + (1 + row) * GUIDE_WORDS,
    )
}

/// The direction and the image coordinates at a position in a cell, of a column and a row; zero where the emitter's frame
/// is none.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn in_cell(
    tables: &Tables<'_>,
    record: &Emitter,
    [column, row]: [u32; 2],
    t: Vec2,
) -> (Vec3, Vec2) {
    let (w, h) = (record.width, record.height);
    // Uniform in the cosine between the row's edges, as the complement 1 - cos from the nearer pole.
    let upper = row * 2 < h;
    let below = h.saturating_sub(row);
    let near = if upper { row } else { below };
    let far = if upper {
        row + 1
    } else {
        below.saturating_sub(1)
    };
    let (k_near, k_far) = (
        one_minus_cos(tables, record, near),
        one_minus_cos(tables, record, far),
    );
    let k = float::lerp(k_near, k_far, t.y);
    let sin_theta = float::safe_sqrt(k * (2.0 - k));
    let cos_theta = if upper { 1.0 - k } else { k - 1.0 };
    // Cells lie between column centres.
    let across = (column as f32 + 0.5 + t.x) / w as f32;
    let phi = TAU * across;
    let (sin_phi, cos_phi) = float::sin_cos(phi);
    let local = Vec3::new(sin_phi * sin_theta, cos_theta, -cos_phi * sin_theta);
    let direction = transform_vector(&record.to_world, local);
    let length = direction.length();
    let uv = Vec2::new(
        if across >= 1.0 { across - 1.0 } else { across },
        float::atan2(sin_theta, cos_theta) * FRAC_1_PI,
    );
    if length > 0.0 {
        (direction / length, uv)
    } else {
        (Vec3::ZERO, uv)
    }
}

/// Whether there is something better than uniform directions.
#[inline]
pub(crate) fn has_table(emitter: &Emitter) -> bool {
    emitter.kind == emitter_kind::ENVIRONMENT
        && emitter.distribution != NONE
        && emitter.width > 0
        && emitter.height > 0
}

/// 1 - cos of the polar angle `pi row / h`, for `row` up to h / 2 (rounded up); read from the table.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn one_minus_cos(tables: &Tables<'_>, emitter: &Emitter, row: u32) -> f32 {
    element(tables.data, caps(emitter) + row)
}

/// Where the table holds 1 - cos of the edges of the rows, then the factors of the rows in [`pdf_of_cell`].
#[inline]
fn caps(emitter: &Emitter) -> u32 {
    let (w, h) = (emitter.width, emitter.height);
    emitter.distribution + h + w * h + (h + 1) * GUIDE_WORDS
}

/// Image coordinates in [0, 1]^2 of a direction in the emitter's frame, of any length.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn to_uv(local: Vec3) -> Vec2 {
    let u = float::atan2(local.x, -local.z) * (0.5 * FRAC_1_PI);
    let across = float::sqrt(local.x * local.x + local.z * local.z);
    // As precise at the poles as elsewhere, which an arc cosine is not.
    let v = float::atan2(across, local.y) * FRAC_1_PI;
    Vec2::new(if u < 0.0 { u + 1.0 } else { u }, v)
}

/// Radiance at image coordinates.
#[inline]
fn radiance_at(tables: &Tables<'_>, emitter: &Emitter, uv: Vec2) -> Rgb {
    let value = vec3(emitter.radiance.value);
    let texture = emitter.radiance.texture;
    if texture == NONE {
        return value;
    }
    value * eval_uv(tables, texture, to_texture(tables, emitter, uv))
}

/// Coordinates of the radiance's texture, which there is, at image coordinates.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn to_texture(tables: &Tables<'_>, emitter: &Emitter, uv: Vec2) -> Vec2 {
    let record = &tables.textures[emitter.radiance.texture as usize];
    let v = if record.kind == texture_kind::BITMAP {
        // Rows on the poles, where a texture's rows are centred inside the square.
        let h = record.data[2] as f32;
        (uv.y * (h - 1.0) + 0.5) / h
    } else {
        uv.y
    };
    Vec2::new(uv.x, v)
}

/// Column and row of the table's cell at image coordinates.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn cell(emitter: &Emitter, uv: Vec2) -> (u32, u32) {
    let (w, h) = (emitter.width as f32, emitter.height as f32);
    let x = uv.x * w - 0.5;
    let x = if x < 0.0 { x + w } else { x };
    (
        float::to_index(x.max(0.0).min(w - 1.0)),
        float::to_index((uv.y * h).max(0.0).min(h - 1.0)),
    )
}

/// Density per solid angle inside a cell, the choice of the emitter not included.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn pdf_of_cell(tables: &Tables<'_>, emitter: &Emitter, column: u32, row: u32) -> f32 {
    let (w, h) = (emitter.width, emitter.height);
    let factor = element(tables.data, caps(emitter) + h + 1 + row);
    factor * cdf_pmf(tables.data, emitter.distribution + h + row * w, column)
}

/// cos of the row's upper edge minus cos of its lower edge: `2 sin(middle) sin(half height)`.
#[cfg(not(target_arch = "spirv"))]
fn row_height(row: u32, h: u32) -> f32 {
    let half = 0.5 * PI / h as f32;
    2.0 * float::sin((2 * row + 1) as f32 * half) * float::sin(half)
}

/// Columns and rows of the table for an image of `width` by `height` texels.
pub fn environment_table_size(width: u32, height: u32) -> (u32, u32) {
    (
        if width > 0 { width } else { 1 },
        if height > 1 { height - 1 } else { 1 },
    )
}

/// Words in `data` of a table of `width` columns and `height` rows: cumulative rows, cumulative cells of each row, the
/// guides of the rows and of each row's cells, 1 - cos of the rows' edges, factors of the densities.
pub fn environment_table_words(width: u32, height: u32) -> u32 {
    height + width * height + (height + 1) * GUIDE_WORDS + 2 * height + 1
}

/// Luminance of the lookup at a corner of the cells.
#[cfg(not(target_arch = "spirv"))]
fn corner(tables: &Tables<'_>, emitter: &Emitter, column: u32, row: u32) -> f32 {
    let x = ((column % emitter.width) as f32 + 0.5) / emitter.width as f32;
    let y = row as f32 / emitter.height as f32;
    let l = crate::math::luminance(radiance_at(tables, emitter, Vec2::new(x, y)));
    if l > 0.0 { l.min(f32::MAX) } else { 0.0 }
}

/// Fills the sampling table of an environment whose `radiance`, `width` and `height` are set, `out` having
/// [`environment_table_words`] words; returns the integral of luminance over solid angle.
///
/// Runs on the host only: it visits the whole image and sums in `f64`.
#[cfg(not(target_arch = "spirv"))]
pub fn fill_environment_distribution(
    tables: &Tables<'_>,
    emitter: &Emitter,
    out: &mut [f32],
) -> f64 {
    use crate::math::distribution::{fill_cdf, fill_guide};
    let (w, h) = (emitter.width as usize, emitter.height as usize);
    let (rows, rest) = out.split_at_mut(h);
    let (cells, rest) = rest.split_at_mut(w * h);
    let (guides, rest) = rest.split_at_mut((h + 1) * GUIDE_WORDS as usize);
    let (caps, factors) = rest.split_at_mut(h + 1);
    let mut integral = 0.0;
    // Every corner is looked up once: a row of cells holds its upper corners until they are replaced by the weights.
    for (k, value) in cells.iter_mut().enumerate() {
        *value = corner(tables, emitter, (k % w) as u32, (k / w) as u32);
    }
    for j in 0..h {
        let (line, below) = cells[j * w..].split_at_mut(w);
        let lower = |i: usize| {
            if j + 1 < h {
                below[i]
            } else {
                corner(tables, emitter, i as u32, h as u32)
            }
        };
        let (first, first_lower) = (line[0], lower(0));
        let mut left = first_lower;
        for i in 0..w {
            let (upper_right, right) = if i + 1 < w {
                (line[i + 1], lower(i + 1))
            } else {
                (first, first_lower)
            };
            line[i] = 0.25 * line[i] + 0.25 * upper_right + 0.25 * left + 0.25 * right;
            left = right;
        }
        let height = f64::from(row_height(j as u32, emitter.height));
        let row = fill_cdf(line) * height / w as f64;
        rows[j] = row.min(f64::from(f32::MAX)) as f32;
        integral += row * core::f64::consts::TAU;
    }
    fill_cdf(rows);
    let (row_guide, cell_guides) = guides.split_at_mut(GUIDE_WORDS as usize);
    fill_guide(rows, row_guide);
    for (line, guide) in cells
        .chunks(w)
        .zip(cell_guides.chunks_mut(GUIDE_WORDS as usize))
    {
        fill_guide(line, guide);
    }
    for (j, cap) in caps.iter_mut().enumerate() {
        *cap = 2.0 * float::sqr(float::sin(0.5 * PI * (j as f32 / h as f32)));
    }
    for j in 0..h {
        let row = j as u32;
        factors[j] = cdf_pmf(rows, 0, row) * w as f32 / (TAU * row_height(row, emitter.height));
    }
    integral
}

/// See [`super::power`].
#[cfg(not(target_arch = "spirv"))]
pub(super) fn power(tables: &Tables<'_>, emitter: &Emitter) -> f64 {
    let pi = core::f64::consts::PI;
    let mut integral = 0.0;
    if emitter.kind == emitter_kind::ENVIRONMENT && emitter.width > 0 && emitter.height > 0 {
        for row in 0..emitter.height {
            let mut sum = 0.0;
            for column in 0..emitter.width {
                sum += 0.5 * f64::from(corner(tables, emitter, column, row))
                    + 0.5 * f64::from(corner(tables, emitter, column, row + 1));
            }
            integral += sum * f64::from(row_height(row, emitter.height));
        }
        integral *= 2.0 * pi / f64::from(emitter.width);
    } else {
        integral = 4.0 * pi * f64::from(crate::math::luminance(vec3(emitter.radiance.value)));
    }
    integral * pi * f64::from(tables.info.radius) * f64::from(tables.info.radius)
}
