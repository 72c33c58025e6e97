//! The table that [`super::measured`] reads, built on the host.
//!
//! | words | what |
//! |---|---|
//! | 12 | numbers of azimuths and elevations; 1 if isotropic plus 2 if colours are relative; symmetry; width and height of the grids of normals, areas, visible normals and values |
//! | n_phi + n_theta | the measured azimuths and elevations, ascending |
//! | 3 n_i | for every incidence the directional albedo, RGB |
//! | w h | D over the square of u_m |
//! | w h | sigma over that of u_i |
//! | n_phi n_theta (2 w h + h) | for every incident direction the density of visible normals over u_m: values, sums along rows, sums of rows |
//! | n_phi n_theta (2 w h + h) | the same of the luminance over the numbers |
//! | n_phi n_theta 3 w h | the colours over the numbers: a grid of red, of green and of blue |
//!
//! Densities are normalised so that their cells sum to one; where a measurement is zero everywhere they are even.

use super::measured::{HEADER, INCIDENCES, Layout, sample};
use super::measured_grid::Grid;
use super::{BsdfSample, Lobe};
use crate::math::float;
use crate::scene::lobe_kind;
use core::f32::consts::{FRAC_PI_2, TAU};
use glam::{Vec2, Vec3};

/// A grid of values, rows one after the other.
#[derive(Clone, Copy, Debug)]
pub struct Plane<'a> {
    /// Of one or several grids.
    pub values: &'a [f32],
    /// Values in a row, at least 2.
    pub width: usize,
    /// Rows, at least 2.
    pub height: usize,
}

/// A measurement, as files hold it.
#[derive(Clone, Copy, Debug)]
pub struct Measurement<'a> {
    /// Incident azimuths, ascending.
    pub azimuths: &'a [f32],
    /// Incident polar angles, ascending.
    pub elevations: &'a [f32],
    /// Whether azimuths count from that of wi.
    pub is_isotropic: bool,
    /// How many parts of the circle look alike: 1, 2 or 4.
    pub symmetry: u32,
    /// Whether colours are to be multiplied by D / (4 sigma).
    pub is_relative: bool,
    /// D.
    pub normals: Plane<'a>,
    /// sigma.
    pub areas: Plane<'a>,
    /// The density of visible normals, by azimuth and elevation.
    pub visible: Plane<'a>,
    /// The luminance, by azimuth and elevation.
    pub luminance: Plane<'a>,
    /// Colours, by azimuth and elevation, then red, green and blue, of the size of the luminance.
    pub colors: &'a [f32],
}

/// Words of the table.
pub const fn table_words(m: &Measurement<'_>) -> usize {
    let slices = m.azimuths.len() * m.elevations.len();
    let (visible, values) = (
        m.visible.width * m.visible.height,
        m.luminance.width * m.luminance.height,
    );
    HEADER
        + m.azimuths.len()
        + m.elevations.len()
        + 3 * INCIDENCES
        + m.normals.width * m.normals.height
        + m.areas.width * m.areas.height
        + slices * (2 * visible + m.visible.height)
        + slices * (2 * values + m.luminance.height)
        + slices * 3 * values
}

/// Fills a table of [`table_words`].
pub fn fill_table(m: &Measurement<'_>, table: &mut [f32]) {
    let kind = u32::from(m.is_isotropic) + 2 * u32::from(m.is_relative);
    let header = [
        m.azimuths.len(),
        m.elevations.len(),
        kind as usize,
        m.symmetry as usize,
        m.normals.width,
        m.normals.height,
        m.areas.width,
        m.areas.height,
        m.visible.width,
        m.visible.height,
        m.luminance.width,
        m.luminance.height,
    ];
    for (word, number) in table.iter_mut().zip(header) {
        *word = number as f32;
    }
    let mut at = HEADER;
    for axis in [m.azimuths, m.elevations] {
        table[at..at + axis.len()].copy_from_slice(axis);
        at += axis.len();
    }
    let layout = Layout::read(table, 0);
    copy(table, layout.normals.first, m.normals.values);
    copy(table, layout.areas.first, m.areas.values);
    for (grid, plane) in [(layout.visible, m.visible), (layout.values, m.luminance)] {
        for slice in 0..layout.azimuths * layout.elevations {
            let values = &plane.values[slice * grid.len()..(slice + 1) * grid.len()];
            let first = grid.first + slice * grid.density_words();
            fill_density(
                &grid,
                values,
                &mut table[first..first + grid.density_words()],
            );
        }
    }
    copy(table, layout.colors(), m.colors);
    fill_albedos(&layout, table);
}

fn copy(table: &mut [f32], first: usize, values: &[f32]) {
    table[first..first + values.len()].copy_from_slice(values);
}

/// Values, sums along rows and sums of rows of one density.
fn fill_density(grid: &Grid, values: &[f32], words: &mut [f32]) {
    let (width, height) = (grid.width, grid.height);
    let sum_of = |values: &dyn Fn(usize) -> f64| {
        let row = |y: usize| -> f64 {
            (0..width - 1)
                .map(|x| 0.5 * (values(y * width + x) + values(y * width + x + 1)))
                .sum()
        };
        (0..height - 1)
            .map(|y| 0.5 * (row(y) + row(y + 1)))
            .sum::<f64>()
    };
    let measured = |i: usize| f64::from(values[i].max(0.0));
    let total = sum_of(&measured);
    let even = 1.0 / ((width - 1) * (height - 1)) as f64;
    let value = |i: usize| {
        if total > 0.0 {
            measured(i) / total
        } else {
            even
        }
    };
    let (mut below, mut previous) = (0.0, 0.0);
    for y in 0..height {
        let mut along = 0.0;
        for x in 0..width {
            let i = y * width + x;
            words[i] = value(i) as f32;
            if x > 0 {
                along += 0.5 * (value(i - 1) + value(i));
            }
            words[grid.len() + i] = along as f32;
        }
        if y > 0 {
            below += 0.5 * (previous + along);
        }
        previous = along;
        words[2 * grid.len() + y] = below as f32;
    }
}

/// Numbers of samples along both axes, and azimuths, for the albedo of an incidence.
const ALBEDO_SAMPLES: u32 = 16;
const ALBEDO_AZIMUTHS: u32 = 4;

/// Estimates the albedos with the samples that a renderer takes.
fn fill_albedos(layout: &Layout, table: &mut [f32]) {
    let lobe = Lobe {
        kind: lobe_kind::MEASURED,
        table: 0,
        ..Lobe::NONE
    };
    for incidence in 0..INCIDENCES {
        let theta = (incidence as f32 + 0.5) / INCIDENCES as f32 * FRAC_PI_2;
        let (sin, cos) = float::sin_cos(theta);
        let mut sum = Vec3::ZERO;
        for k in 0..ALBEDO_SAMPLES * ALBEDO_SAMPLES * ALBEDO_AZIMUTHS {
            let (azimuth, i) = (k % ALBEDO_AZIMUTHS, k / ALBEDO_AZIMUTHS);
            let (s, c) = float::sin_cos(TAU * (azimuth as f32 + 0.3) / ALBEDO_AZIMUTHS as f32);
            let (x, y) = (i % ALBEDO_SAMPLES, i / ALBEDO_SAMPLES);
            let u = Vec2::new(x as f32 + 0.5, y as f32 + 0.5) / ALBEDO_SAMPLES as f32;
            let found: BsdfSample = sample(&lobe, table, Vec3::new(sin * c, sin * s, cos), 0.5, u);
            if found.pdf > 0.0 {
                sum += found.weight;
            }
        }
        let mean = sum / (ALBEDO_SAMPLES * ALBEDO_SAMPLES * ALBEDO_AZIMUTHS) as f32;
        let at = layout.albedos() + 3 * incidence;
        copy(table, at, &mean.to_array());
    }
}
