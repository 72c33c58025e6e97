//! Diffuse base under a smooth dielectric coating.
//!
//! Light is reflected at the coating (a discrete direction, Fresnel F) or enters it, scatters diffusely and leaves, with
//! all internal reflections summed up:
//!
//! f = F(wi) delta / |cos| + (1 - F(wi)) (1 - F(wo)) / eta^2 * rho / (1 - rho F_int) / pi
//!
//! eta = interior over exterior, F_int the internal reflectance under diffuse illumination. That is the nonlinear form
//! ([`lobe_flag::NONLINEAR`]), whose furnace with rho = 1 returns all light; the default form leaves rho out of the
//! denominator, which keeps the colour but is brighter than physical for dark bases: rho is then the total albedo of
//! the base. A coating that absorbs multiplies the diffuse part by exp(-tau (1 / cos'_i + 1 / cos'_o)), tau its optical
//! depth and cos' the refracted cosines, inside; light that is reflected internally is not absorbed further.
//! Source: Pharr and Hanrahan 1993 give the series, Mitsuba and Tungsten this closed form.
//!
//! Densities are per solid angle on the side of the normal, discrete for the coating. The coating is chosen with
//! probability F s / (F s + (1 - F) d), s and d the mean reflectances of both parts after absorption. Invariants (tests): the furnace
//! of the nonlinear form at rho = 1 is 1; the diffuse part is reciprocal.

use super::fresnel::fresnel_dielectric;
use super::{BsdfSample, Lobe, coat, event};
use crate::math::{Rgb, warp};
use crate::scene::lobe_flag;
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};

/// The diffuse part, without a cosine.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    let transmitted_in = 1.0 - fresnel_dielectric(wi.z, lobe.eta.x).0;
    let transmitted_out = 1.0 - fresnel_dielectric(wo.z, lobe.eta.x).0;
    base(lobe)
        * absorption(lobe, wi.z)
        * absorption(lobe, wo.z)
        * (transmitted_in * transmitted_out)
}

/// Density of the diffuse part of [`sample`] per solid angle.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return 0.0;
    }
    let reflected = fresnel_dielectric(wi.z, lobe.eta.x).0;
    (1.0 - specular_probability(lobe, wi.z, reflected)) * wo.z * FRAC_1_PI
}

/// The mirror direction or a cosine-distributed one; `u1` chooses.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample(lobe: &Lobe, wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    if wi.z <= 0.0 {
        return BsdfSample::NONE;
    }
    let reflected = fresnel_dielectric(wi.z, lobe.eta.x).0;
    let p = specular_probability(lobe, wi.z, reflected);
    if u1 < p {
        return BsdfSample {
            wo: Vec3::new(-wi.x, -wi.y, wi.z),
            weight: lobe.specular_reflectance * (reflected / p),
            pdf: p,
            eta: 1.0,
            event: event::REFLECTION | event::DELTA,
        };
    }
    let wo = warp::square_to_cosine_hemisphere(u2);
    let transmitted_out = 1.0 - fresnel_dielectric(wo.z, lobe.eta.x).0;
    let pdf = (1.0 - p) * wo.z * FRAC_1_PI;
    if pdf <= 0.0 {
        return BsdfSample::NONE;
    }
    let value = base(lobe)
        * absorption(lobe, wi.z)
        * absorption(lobe, wo.z)
        * ((1.0 - reflected) * transmitted_out);
    BsdfSample {
        wo,
        weight: value * (wo.z / pdf),
        pdf,
        eta: 1.0,
        event: event::REFLECTION | event::DIFFUSE,
    }
}

/// Radiance factor of the base between the two passages of the boundary: rho / (1 - rho F_int) / (pi eta^2).
#[inline]
pub fn base(lobe: &Lobe) -> Rgb {
    let rho = lobe.reflectance;
    let internal = lobe.internal_reflectance;
    let kept = if lobe.flags & lobe_flag::NONLINEAR != 0 {
        Vec3::ONE - rho * internal
    } else {
        Vec3::splat(1.0 - internal)
    };
    // Internal reflectance is below one for every finite index; the bound keeps a wrong record finite.
    let kept = kept.max(Vec3::splat(1e-4));
    rho / kept * (FRAC_1_PI / (lobe.eta.x * lobe.eta.x))
}

/// Share of the light that the coating leaves on one passage, from the cosine `cos` outside.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn absorption(lobe: &Lobe, cos: f32) -> Rgb {
    if lobe.optical_depth == Vec3::ZERO {
        return Vec3::ONE;
    }
    let inside = -fresnel_dielectric(cos, lobe.eta.x).1;
    // Total reflection: nothing enters.
    if inside <= 0.0 {
        return Vec3::ZERO;
    }
    coat::absorption(lobe.optical_depth, inside)
}

/// Probability of sampling the coating for `wi` at cosine `cos` when it reflects the share `reflected`. The absorption on
/// the outgoing side is estimated along the normal.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn specular_probability(lobe: &Lobe, cos: f32, reflected: f32) -> f32 {
    let specular = reflected * lobe.specular_reflectance.element_sum();
    let below = lobe.reflectance * absorption(lobe, cos) * absorption(lobe, 1.0);
    let diffuse = (1.0 - reflected) * below.element_sum();
    let sum = specular + diffuse;
    if sum <= 0.0 {
        return 0.0;
    }
    specular / sum
}
