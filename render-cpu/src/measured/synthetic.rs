//! Synthetic measurements: rough nickel in the format of the MERL database, brushed copper in that of the RGL database.
//!
//! Holzschuch et al. 2016 show the local roughness of measured nickel: a narrow peak, long tails around it, and a nearly flat
//! rest far away. Files of the database cannot be part of this project, so three lobes imitate it: GGX of roughness 0.08,
//! Beckmann of roughness 0.35, both with the metal's Fresnel reflectance, and a hundredth of diffuse reflection.

use super::merl::Merl;
use super::rgl::Rgl;
use super::tensor_file::{TensorError, file_of};
use crate::scene::ior;
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::fresnel::{fresnel_conductor, reflect};
use halflight_kernel::bsdf::measured::half_vector_at;
use halflight_kernel::bsdf::merl::directions;
use halflight_kernel::bsdf::{Lobe, rough_conductor};
use halflight_kernel::math::luminance;
use halflight_kernel::scene::{distribution, lobe_kind};
use std::f32::consts::{FRAC_1_PI, FRAC_PI_2, PI};

/// Shares of the narrow and of the wide lobe.
const SHARES: [f32; 2] = [0.7, 0.3];
/// Albedo of the flat rest.
const DIFFUSE: f32 = 0.01;

/// The file of the nickel.
pub fn nickel() -> Vec<u8> {
    let index = ior::conductor("Ni").unwrap_or(ior::Conductor::PERFECT_MIRROR);
    let lobe = |kind: u32, alpha: f32| Lobe {
        kind: lobe_kind::ROUGH_CONDUCTOR,
        distribution: kind,
        alpha: Vec2::splat(alpha),
        specular_reflectance: Vec3::ONE,
        eta: Vec3::from(index.eta),
        k: Vec3::from(index.k),
        ..Lobe::NONE
    };
    let (narrow, wide) = (
        lobe(distribution::GGX, 0.08),
        lobe(distribution::BECKMANN, 0.35),
    );
    Merl::file_of(|angles| {
        let (wi, wo) = directions(angles);
        if wi.z <= 0.0 || wo.z <= 0.0 {
            return None;
        }
        let peak = rough_conductor::eval(&narrow, wi, wo) * SHARES[0]
            + rough_conductor::eval(&wide, wi, wo) * SHARES[1];
        Some(peak + Vec3::splat(DIFFUSE * FRAC_1_PI))
    })
}

/// Widths of the facets of brushed metal, along and across its grooves.
pub const BRUSHED: Vec2 = Vec2::new(0.18, 0.4);

/// Values along an axis of the grids over half vectors, and over the numbers that choose them.
const NORMALS: usize = 48;
const NUMBERS: usize = 16;

/// Copper of microfacets, brushed along x.
pub fn brushed_metal() -> Lobe {
    let index = ior::conductor("Cu").unwrap_or(ior::Conductor::PERFECT_MIRROR);
    Lobe {
        kind: lobe_kind::ROUGH_CONDUCTOR,
        distribution: distribution::GGX,
        alpha: BRUSHED,
        specular_reflectance: Vec3::ONE,
        eta: Vec3::from(index.eta),
        k: Vec3::from(index.k),
        ..Lobe::NONE
    }
}

/// A file in the format of the RGL database that holds [`brushed_metal`]: an anisotropic material, a quarter of whose incident
/// azimuths is measured.
///
/// # Errors
/// When its own reader refuses it.
pub fn brushed() -> Result<Vec<u8>, TensorError> {
    let facets = brushed_metal().microfacets();
    let azimuths: Vec<f32> = (0..5).map(|i| -PI + i as f32 * (PI / 8.0)).collect();
    let elevations: Vec<f32> = (0..10).map(|i| i as f32 * 0.165).collect();
    let nodes = |count: usize| {
        (0..count * count).map(move |i| {
            let (x, y) = (i % count, i / count);
            Vec2::new(x as f32, y as f32) / (count - 1) as f32
        })
    };
    let direction = |theta: f32, phi: f32| {
        Vec3::new(
            theta.sin() * phi.cos(),
            theta.sin() * phi.sin(),
            theta.cos(),
        )
    };
    let of_square = |u: Vec2| direction(u.x * u.x * FRAC_PI_2, (2.0 * u.y - 1.0) * PI);
    let normals: Vec<f32> = nodes(NORMALS)
        .map(|u| facets.distribution(of_square(u)))
        .collect();
    let areas: Vec<f32> = nodes(NORMALS)
        .map(|u| facets.projected_area(of_square(u)))
        .collect();
    let incident: Vec<(f32, f32)> = azimuths
        .iter()
        .flat_map(|phi| elevations.iter().map(|theta| (*phi, *theta)))
        .collect();
    let mut visible = Vec::new();
    for &(phi, theta) in &incident {
        let wi = direction(theta, phi);
        visible.extend(nodes(NORMALS).map(|u| {
            let m = of_square(u);
            let solid_angle = 2.0 * PI * PI * u.x * (u.x * u.x * FRAC_PI_2).sin();
            facets.visible_normal_pdf(wi, m) * solid_angle
        }));
    }
    let count = incident.len() * NUMBERS * NUMBERS;
    let file = |luminance: &[f32], colors: &[f32]| {
        let directions = [azimuths.len(), elevations.len()];
        let [p, t] = directions;
        file_of(
            &[
                ("phi_i", &[p], &azimuths),
                ("theta_i", &[t], &elevations),
                ("ndf", &[NORMALS, NORMALS], &normals),
                ("sigma", &[NORMALS, NORMALS], &areas),
                ("vndf", &[p, t, NORMALS, NORMALS], &visible),
                ("luminance", &[p, t, NUMBERS, NUMBERS], luminance),
                ("rgb", &[p, t, 3, NUMBERS, NUMBERS], colors),
            ],
            &[
                ("jacobian", &[1]),
                ("description", b"brushed copper, synthetic"),
            ],
        )
    };
    // Which half vector a number stands for is known once the densities are: from a table without colours.
    let table = Rgl::read(&file(&vec![1.0; count], &vec![1.0; 3 * count]))?.table();
    let metal = brushed_metal();
    let (mut light, mut colors) = (Vec::new(), Vec::new());
    for &(phi, theta) in &incident {
        let wi = direction(theta, phi);
        let values: Vec<Vec3> = nodes(NUMBERS)
            .map(|numbers| {
                let m = half_vector_at(&table, phi, theta, numbers);
                let wo = reflect(wi, m);
                if wi.dot(m) <= 0.0 || wo.z <= 0.0 {
                    return Vec3::ZERO;
                }
                // f cos_o without D / (4 sigma): Fresnel's factor and the masking of wo.
                let passed = wo.z / facets.projected_area(wo);
                fresnel_conductor(wi.dot(m), metal.eta, metal.k) * passed
            })
            .collect();
        light.extend(values.iter().map(|v| luminance(*v)));
        for channel in 0..3 {
            colors.extend(values.iter().map(|v| v[channel]));
        }
    }
    Ok(file(&light, &colors))
}
