//! The table that [`super::merl`] reads, built on the host.
//!
//! | words | what |
//! |---|---|
//! | 4 | numbers of cells in theta_h, theta_d, phi_d, and of incidences |
//! | 3 n_h n_d n_p | values, RGB of each cell, phi_d fastest |
//! | n_i n_h | for every incidence the cumulative probabilities of the theta_h cells, the last one 1 |
//! | 3 n_i | for every incidence the directional albedo, RGB |
//!
//! Incidences are cells uniform in theta_i, represented by their centres. The probability of a theta_h cell is its share of the
//! luminance that is reflected from there: the integral over the cell's half vectors of f cos_o 4 (wi . h), by the midpoint
//! rule. Where nothing is reflected the distribution is uniform over the cells.

use super::fresnel::reflect;
use super::merl::{HEADER, Layout, cell_edges, cell_solid_angle, half_difference_angles, lookup};
use crate::math::{float, luminance};
use core::f32::consts::{FRAC_PI_2, TAU};
use glam::Vec3;

/// Cells in theta_i.
pub const INCIDENCES: usize = 32;

/// Nodes of the quadrature within a cell of theta_h, and in phi_h.
const POLAR: usize = 3;
const AZIMUTH: usize = 64;

/// Words of the table for a number of cells in theta_h, theta_d and phi_d.
pub const fn table_words(cells: [usize; 3]) -> usize {
    HEADER + 3 * cells[0] * cells[1] * cells[2] + INCIDENCES * cells[0] + 3 * INCIDENCES
}

/// Writes the header; the values follow it, and then [`fill_sampling`].
pub fn fill_header(cells: [usize; 3], table: &mut [f32]) {
    for axis in 0..3 {
        table[axis] = cells[axis] as f32;
    }
    table[3] = INCIDENCES as f32;
}

/// Derives distributions and albedos from the values of a table.
pub fn fill_sampling(table: &mut [f32]) {
    let layout = Layout::read(table, 0);
    let n = layout.cells[0];
    for incidence in 0..layout.incidences {
        let theta = (incidence as f32 + 0.5) / layout.incidences as f32 * FRAC_PI_2;
        let (sin, cos) = float::sin_cos(theta);
        let wi = Vec3::new(sin, 0.0, cos);
        let row = layout.distributions() + incidence * n;
        let mut total = Vec3::ZERO;
        let mut cumulative = 0.0;
        for h in 0..n {
            let reflected = reflected_from(table, wi, n, h);
            total += reflected;
            cumulative += luminance(reflected);
            table[row + h] = cumulative;
        }
        for h in 0..n {
            table[row + h] = if cumulative > 0.0 {
                (table[row + h] / cumulative).min(1.0)
            } else {
                (h + 1) as f32 / n as f32
            };
        }
        table[row + n - 1] = 1.0;
        let at = layout.albedos() + 3 * incidence;
        for c in 0..3 {
            table[at + c] = total[c];
        }
    }
}

/// Light reflected by the half vectors of cell `h`.
fn reflected_from(table: &[f32], wi: Vec3, n: usize, h: usize) -> Vec3 {
    let (theta_0, theta_1) = cell_edges(n, h);
    let mut sum = Vec3::ZERO;
    for i in 0..POLAR {
        let theta = float::lerp(theta_0, theta_1, (i as f32 + 0.5) / POLAR as f32);
        let (sin, cos) = float::sin_cos(theta);
        for j in 0..AZIMUTH {
            let (sin_phi, cos_phi) = float::sin_cos(TAU * (j as f32 + 0.5) / AZIMUTH as f32);
            let m = Vec3::new(sin * cos_phi, sin * sin_phi, cos);
            let cos_h = wi.dot(m);
            let wo = reflect(wi, m);
            if cos_h <= 0.0 || wo.z <= 0.0 {
                continue;
            }
            let value = lookup(table, 0, half_difference_angles(wi, wo));
            // Nodes are uniform in theta, the measure is that of the solid angle.
            sum += value * (4.0 * cos_h * wo.z * sin);
        }
    }
    let weights: f32 = (0..POLAR)
        .map(|i| {
            let theta = float::lerp(theta_0, theta_1, (i as f32 + 0.5) / POLAR as f32);
            float::sin(theta) * AZIMUTH as f32
        })
        .sum();
    sum * (cell_solid_angle(n, h) / weights)
}
