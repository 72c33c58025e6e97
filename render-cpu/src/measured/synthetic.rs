//! A synthetic measurement that looks like rough nickel.
//!
//! Holzschuch et al. 2016 show the local roughness of measured nickel: a narrow peak, long tails around it, and a nearly flat
//! rest far away. Files of the database cannot be part of this project, so three lobes imitate it: GGX of roughness 0.08,
//! Beckmann of roughness 0.35, both with the metal's Fresnel reflectance, and a hundredth of diffuse reflection.

use super::merl::Merl;
use crate::scene::ior;
use glam::{Vec2, Vec3};
use halflight_kernel::bsdf::merl::directions;
use halflight_kernel::bsdf::{Lobe, rough_conductor};
use halflight_kernel::scene::{distribution, lobe_kind};
use std::f32::consts::FRAC_1_PI;

/// Shares of the narrow and of the wide lobe.
const SHARES: [f32; 2] = [0.7, 0.3];
/// Albedo of the flat rest.
const DIFFUSE: f32 = 0.01;

/// The file.
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
