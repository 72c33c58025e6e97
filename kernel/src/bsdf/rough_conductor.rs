//! Rough conductor: microfacets that are conducting mirrors.
//!
//! `f = specular_reflectance F(wi.m) D(m) G1(wi) G1(wo) / (4 wi.z wo.z)`, `m` the half vector (Cook and Torrance 1982
//! in the form of Walter et al. 2007, equation 20), written with projected areas `A = w.z / G1`: `F D / (4 A A)`, which
//! has no pole. One-sided: nothing when `wi` or `wo` is below the horizon.
//!
//! Normals are sampled from those visible to `wi`; with [`SAMPLE_ALL_NORMALS`](crate::scene::lobe_flag::SAMPLE_ALL_NORMALS) from `D(m) m.z`. Checked: the
//! density by chi-square, reciprocity, values against another renderer.

use super::fresnel::{fresnel_conductor, reflect};
use super::{BsdfSample, Lobe, event};
use crate::math::Rgb;
use glam::Vec3;

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

/// [`eval`], which is the same for exchanged directions, and the [`pdf`] of wo for wi and of wi for wo, all of one look at
/// the distribution.
#[inline]
pub fn eval_pdf_both(lobe: &Lobe, wi: Vec3, wo: Vec3) -> (Rgb, f32, f32) {
    let facets = lobe.microfacets();
    if lobe.samples_all_normals() || !facets.has_smith_normals() {
        return (eval(lobe, wi, wo), pdf(lobe, wi, wo), pdf(lobe, wo, wi));
    }
    let m = (wi + wo).normalize_or_zero();
    let cos_i = wi.dot(m);
    if wi.z <= 0.0 || wo.z <= 0.0 || cos_i <= 0.0 {
        return (Rgb::ZERO, 0.0, 0.0);
    }
    // Visible normals have the density D cos / A, and the reflection 1 / (4 cos) of that.
    let d = 0.25 * facets.distribution(m);
    let (area_i, area_o) = (facets.projected_area(wi), facets.projected_area(wo));
    let fresnel = fresnel_conductor(cos_i, lobe.eta, lobe.k);
    let f = lobe.specular_reflectance * fresnel * (d / (area_i * area_o));
    (f, d / area_i, d / area_o)
}

/// The reflection at a sampled microfacet normal `m`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample(lobe: &Lobe, wi: Vec3, m: Vec3) -> BsdfSample {
    let all = lobe.samples_all_normals();
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
    if wi.z > 0.0 && cos_i > 0.0 && wo.z > 0.0 && pdf > 0.0 {
        s
    } else {
        BsdfSample::NONE
    }
}

/// Density per solid angle of the sampled normal.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn pdf_of_normal(lobe: &Lobe, wi: Vec3, m: Vec3) -> f32 {
    if lobe.samples_all_normals() {
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
