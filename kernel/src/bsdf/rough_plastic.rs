//! Diffuse base under a rough dielectric coating.
//!
//! f = F D G1(wi) G1(wo) / (4 cos_i cos_o) + T(cos_i) T(cos_o) / eta^2 * rho / (1 - rho F_int) / pi
//!
//! The first term is the microfacet reflection with separable Smith masking, F at the half vector. T is the rough
//! transmittance out of a table of [`super::rough_transmittance`], at one roughness or over all; without a table the smooth
//! boundary's 1 - F stands in (Tungsten's choice). F_int is the cosine-weighted mean of the share that is reflected back
//! inside; the base is that of [`plastic`], linear or nonlinear, absorption included.
//!
//! Densities per solid angle, one sample over both parts. The coating is chosen with probability proportional to
//! (1 - T(cos_i)) s against T(cos_i) d, s and d the mean reflectances. Invariants (tests): furnace at most 1, reciprocity,
//! samples follow the density, values and densities of an independent renderer.

use super::fresnel::reflect;
use super::{BsdfSample, Lobe, coat_reflection, event, plastic, rough_transmittance, weighted};
use crate::math::{Rgb, warp};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};

/// The BSDF, without a cosine.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn eval(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    let (base, coat) = base_and_coat(lobe, data, wi, wo);
    base + coat
}

/// The part of the base in [`eval`], and that of the coating.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn base_and_coat(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> (Rgb, Rgb) {
    let transmitted = transmitted_share(lobe, data, wi.z) * transmitted_share(lobe, data, wo.z);
    let absorbed = plastic::absorption(lobe, wi.z) * plastic::absorption(lobe, wo.z);
    let base = plastic::base(lobe) * absorbed * transmitted;
    // Evaluated before the test, so that loops over lanes stay without branches.
    let coat = coat_reflection::eval(lobe, wi, wo);
    if wi.z <= 0.0 || wo.z <= 0.0 {
        (Vec3::ZERO, Vec3::ZERO)
    } else {
        (base, coat)
    }
}

/// Density of [`sample`] per solid angle.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    let p = plastic::specular_probability(lobe, wi.z, 1.0 - transmitted_share(lobe, data, wi.z));
    let density = (1.0 - p) * wo.z * FRAC_1_PI + p * coat_reflection::pdf(lobe, wi, wo);
    if wi.z <= 0.0 || wo.z <= 0.0 {
        0.0
    } else {
        density
    }
}

/// A direction of the coating, reflected at the visible normal that `normal` draws, or of the base, drawn with `u2`; `u1`
/// chooses.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample(
    lobe: &Lobe,
    data: &[f32],
    wi: Vec3,
    u1: f32,
    u2: Vec2,
    normal: impl FnOnce() -> Vec3,
) -> BsdfSample {
    let p = plastic::specular_probability(lobe, wi.z, 1.0 - transmitted_share(lobe, data, wi.z));
    let s = if u1 < p {
        BsdfSample::towards(reflect(wi, normal()), event::REFLECTION | event::GLOSSY)
    } else {
        let wo = warp::square_to_cosine_hemisphere(u2);
        BsdfSample::towards(wo, event::REFLECTION | event::DIFFUSE)
    };
    let s = weighted!(s, pdf(lobe, data, wi, s.wo), eval(lobe, data, wi, s.wo));
    if wi.z <= 0.0 { BsdfSample::NONE } else { s }
}

/// Share of the light from cosine `cos` that passes the coating.
#[inline]
pub(crate) fn transmitted_share(lobe: &Lobe, data: &[f32], cos: f32) -> f32 {
    rough_transmittance::transmittance(
        data,
        lobe.table,
        lobe.table_rows,
        lobe.eta.x,
        lobe.alpha.x,
        cos,
    )
}
