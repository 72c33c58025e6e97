//! Reflection at the surface of a coat, smooth or rough: a dielectric boundary whose transmitted light belongs to other
//! lobes ([`super::coat`]).
//!
//! Smooth: a discrete mirror direction with reflectance F(cos_i). Rough: f = F(wi . h) D(h) / (4 A(wi) A(wo)) with the
//! projected areas A = cos / G1 of separable Smith masking; normals are sampled by their visibility.
//!
//! Densities per solid angle on the side of the normal; `lobe.eta.x` is interior over exterior. Checked with the lobes of
//! [`super::rough_plastic`], of which it is the coating alone.

use super::fresnel::{fresnel_dielectric, reflect};
use super::{BsdfSample, Lobe, event, weighted};
use crate::math::{Rgb, float};
use crate::scene::lobe_kind;
use glam::Vec3;

/// The rough reflection, without a cosine.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    let h = half_vector(wi, wo);
    let facets = lobe.microfacets();
    let d = facets.distribution(h);
    let cos_h = wi.dot(h);
    // G1(w) / cos as one over the projected area, which has no pole at grazing angles.
    let area = facets.projected_area(wi) * facets.projected_area(wo);
    let reflected = fresnel_dielectric(cos_h, lobe.eta.x).0;
    let value = lobe.specular_reflectance * (0.25 * reflected * d / area);
    // Opposite directions in the horizon have a half vector of rounding errors, and no density.
    let is_dark = wi.z <= 0.0 || wo.z <= 0.0 || d <= 0.0 || cos_h <= 0.0;
    if is_dark || lobe.kind == lobe_kind::COAT {
        Vec3::ZERO
    } else {
        value
    }
}

/// Density of the rough reflection of [`sample`] per solid angle.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    let h = half_vector(wi, wo);
    let cos_h = wi.dot(h);
    // Jacobian of the reflection at h: d omega_h / d omega_o = 1 / (4 wi . h).
    let density = lobe.microfacets().visible_normal_pdf(wi, h) / (4.0 * cos_h);
    let is_dark = wi.z <= 0.0 || wo.z <= 0.0 || cos_h <= 0.0;
    if is_dark || lobe.kind == lobe_kind::COAT {
        0.0
    } else {
        density
    }
}

/// The rough reflection at a visible normal `m`.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample(lobe: &Lobe, wi: Vec3, m: Vec3) -> BsdfSample {
    if wi.z <= 0.0 {
        return BsdfSample::NONE;
    }
    let s = BsdfSample::towards(reflect(wi, m), event::REFLECTION | event::GLOSSY);
    weighted!(s, pdf(lobe, wi, s.wo), eval(lobe, wi, s.wo))
}

/// The mirror direction of a smooth coat.
#[inline]
pub fn sample_smooth(lobe: &Lobe, wi: Vec3) -> BsdfSample {
    if wi.z <= 0.0 {
        return BsdfSample::NONE;
    }
    BsdfSample {
        wo: Vec3::new(-wi.x, -wi.y, wi.z),
        weight: lobe.specular_reflectance * fresnel_dielectric(wi.z, lobe.eta.x).0,
        pdf: 1.0,
        eta: 1.0,
        event: event::REFLECTION | event::DELTA,
    }
}

/// Unit half vector of two directions on the same side.
#[inline]
pub(super) fn half_vector(wi: Vec3, wo: Vec3) -> Vec3 {
    let h = wi + wo;
    h * (1.0 / float::sqrt(h.length_squared().max(1e-30)))
}
