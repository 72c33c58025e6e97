//! Rough conductor: microfacets that are conducting mirrors.
//!
//! `f = specular_reflectance F(wi.m) D(m) G1(wi) G1(wo) / (4 wi.z wo.z)`, `m` the half vector (Cook and Torrance 1982
//! in the form of Walter et al. 2007, equation 20), written with projected areas `A = w.z / G1`: `F D / (4 A A)`, which
//! has no pole. One-sided: nothing when `wi` or `wo` is below the horizon.
//!
//! Normals are sampled from those visible to `wi`; with [`lobe_flag::SAMPLE_ALL_NORMALS`] from `D(m) m.z`. Checked: the
//! density by chi-square, reciprocity, values against another renderer.

use super::fresnel::{fresnel_conductor, reflect};
use super::{BsdfSample, Lobe, event};
use crate::math::Rgb;
use crate::scene::lobe_flag;
use glam::{Vec2, Vec3};

/// BSDF without a cosine.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Rgb::ZERO;
    }
    let m = (wi + wo).normalize_or_zero();
    let cos_i = wi.dot(m);
    // Opposite directions in the horizon have a half vector of rounding errors, and no density.
    if cos_i <= 0.0 {
        return Rgb::ZERO;
    }
    let facets = lobe.microfacets();
    let area = facets.projected_area(wi) * facets.projected_area(wo);
    let f = 0.25 * facets.distribution(m) / area;
    lobe.specular_reflectance * fresnel_conductor(cos_i, lobe.eta, lobe.k) * f
}

/// Density of [`sample`] per solid angle.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return 0.0;
    }
    let m = (wi + wo).normalize_or_zero();
    let cos_i = wi.dot(m);
    if cos_i <= 0.0 {
        return 0.0;
    }
    pdf_of_normal(lobe, wi, m) * solid_angle_of_reflection(cos_i)
}

/// A direction reflected at a sampled normal; `u1` is not used.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample(lobe: &Lobe, wi: Vec3, _u1: f32, u2: Vec2) -> BsdfSample {
    if wi.z <= 0.0 {
        return BsdfSample::NONE;
    }
    let all = lobe.flags & lobe_flag::SAMPLE_ALL_NORMALS != 0;
    let facets = lobe.microfacets();
    let m = if all {
        facets.sample_normal(u2)
    } else {
        facets.sample_visible_normal(wi, u2)
    };
    at_normal(lobe, wi, m)
}

/// [`sample`] at the normal that it draws.
#[cfg(not(target_arch = "spirv"))]
#[inline(always)]
pub(super) fn sample_at_normal(lobe: &Lobe, wi: Vec3, m: Vec3) -> BsdfSample {
    let s = at_normal(lobe, wi, m);
    if wi.z <= 0.0 { BsdfSample::NONE } else { s }
}

/// The reflection of [`sample`] at its normal.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(super) fn at_normal(lobe: &Lobe, wi: Vec3, m: Vec3) -> BsdfSample {
    let all = lobe.flags & lobe_flag::SAMPLE_ALL_NORMALS != 0;
    let facets = lobe.microfacets();
    let cos_i = wi.dot(m);
    let wo = reflect(wi, m);
    let pdf = pdf_of_normal(lobe, wi, m) * solid_angle_of_reflection(cos_i);
    let masking_o = wo.z / facets.projected_area(wo);
    // f cos / pdf: D cancels, and with Smith's visible normals so does everything that belongs to wi.
    let weight = if all {
        masking_o * cos_i / (facets.projected_area(wi) * m.z)
    } else {
        masking_o * facets.visible_normal_weight(wi, m)
    };
    let s = BsdfSample {
        wo,
        weight: lobe.specular_reflectance * fresnel_conductor(cos_i, lobe.eta, lobe.k) * weight,
        pdf,
        eta: 1.0,
        event: event::GLOSSY | event::REFLECTION,
    };
    if cos_i > 0.0 && wo.z > 0.0 && pdf > 0.0 {
        s
    } else {
        BsdfSample::NONE
    }
}

/// Density per solid angle of the sampled normal.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn pdf_of_normal(lobe: &Lobe, wi: Vec3, m: Vec3) -> f32 {
    if lobe.flags & lobe_flag::SAMPLE_ALL_NORMALS != 0 {
        lobe.microfacets().normal_pdf(m)
    } else {
        lobe.microfacets().visible_normal_pdf(wi, m)
    }
}

/// Solid angle of half vectors per solid angle of `wo`, `1 / (4 |wi.m|)` (Walter et al. 2007, equation 14).
#[inline]
fn solid_angle_of_reflection(cos_i: f32) -> f32 {
    0.25 / cos_i
}
