//! A synthetic measurement: a glossy lobe over a diffuse one, tabulated as a MERL file would be.

use super::lobes::{Case, white};
use glam::Vec3;
use halflight_kernel::bsdf::merl::HEADER;
use halflight_kernel::bsdf::merl_table::{fill_header, fill_sampling, table_words};
use halflight_kernel::scene::lobe_kind;
use std::f32::consts::{FRAC_PI_2, PI};

/// Numbers of cells.
pub const CELLS: [usize; 3] = [40, 18, 24];

/// theta_h, theta_d, phi_d at the centre of a cell.
pub fn centre(h: usize, d: usize, p: usize) -> Vec3 {
    let x = (h as f32 + 0.5) / CELLS[0] as f32;
    Vec3::new(
        x * x * FRAC_PI_2,
        (d as f32 + 0.5) / CELLS[1] as f32 * FRAC_PI_2,
        (p as f32 + 0.5) / CELLS[2] as f32 * PI,
    )
}

/// The reflectance: GGX of roughness 0.3, brighter at grazing difference angles, over a coloured base that varies a
/// little with phi_d.
pub fn reflectance(angles: Vec3) -> Vec3 {
    let cos2 = angles.x.cos().powi(2);
    let d = 0.09 / (PI * (cos2 * (0.09 - 1.0) + 1.0).powi(2));
    let fresnel = 0.2 + 0.4 * (1.0 - angles.y.cos()).powi(5);
    let base = Vec3::new(0.1, 0.05, 0.02) * (1.0 + 0.3 * (2.0 * angles.z).cos());
    Vec3::splat(0.25 * d * fresnel) + base
}

/// The table of a function of the angles.
pub fn table_of(f: impl Fn(Vec3) -> Vec3) -> Vec<f32> {
    let mut table = vec![0.0; table_words(CELLS)];
    fill_header(CELLS, &mut table);
    let mut at = HEADER;
    for h in 0..CELLS[0] {
        for d in 0..CELLS[1] {
            for p in 0..CELLS[2] {
                table[at..at + 3].copy_from_slice(&f(centre(h, d, p)).to_array());
                at += 3;
            }
        }
    }
    fill_sampling(&mut table);
    table
}

/// The lobe over [`reflectance`].
pub fn measured_case() -> Case {
    let mut lobe = white(lobe_kind::MERL);
    lobe.table = 0;
    Case {
        name: "measured".into(),
        lobe,
        data: table_of(reflectance),
    }
}
