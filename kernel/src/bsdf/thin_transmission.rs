//! Transmission through a thin sheet with rough sides: the reflection of microfacets, mirrored to the other side.
//!
//! Burley 2015, "Extending the Disney BRDF to a BSDF with Integrated Subsurface Scattering", section 5 (the thin model): a sheet
//! bends light back to where it came from, so that what is left is a blur about the direction straight on,
//!
//!   f = T (1 - F(wi . h)) D(h) G1(wi) G1(wo') / (4 |cos_i cos_o|),
//!
//! wo' the mirror image of wo on the side of wi, h the half vector of wi and wo', F Fresnel's reflectance of the index eta. T is
//! `specular_transmittance`. Both sides look alike. What is reflected is a lobe of its own. Normals are sampled by their
//! visibility; densities per solid angle. Invariants (tests): reciprocity, at most T in the furnace, values of an independent
//! renderer, which cuts off pairs whose wo is not behind the facet; there is no such cut in the paper or here.

use super::coat_reflection::half_vector;
use super::fresnel::{fresnel_dielectric, reflect};
use super::{BsdfSample, Lobe, event, weighted};
use crate::math::{Rgb, float};
use glam::Vec3;

/// A direction, mirrored to the upper side.
#[inline]
pub(super) fn to_upper_hemisphere(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, float::abs(w.z))
}

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z * wo.z >= 0.0 {
        return Vec3::ZERO;
    }
    eval_reflected(lobe, to_upper_hemisphere(wi), to_upper_hemisphere(wo))
}

/// The BSDF of two directions that were mirrored to the upper side.
#[inline]
fn eval_reflected(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    let h = half_vector(wi, wo);
    let cos_h = wi.dot(h);
    if wo.z <= 0.0 || cos_h <= 0.0 {
        return Vec3::ZERO;
    }
    let facets = lobe.microfacets();
    let area = facets.projected_area(wi) * facets.projected_area(wo);
    let passed = 1.0 - fresnel_dielectric(cos_h, lobe.eta.x).0;
    lobe.specular_transmittance * (0.25 * passed * facets.distribution(h) / area)
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    if wi.z * wo.z >= 0.0 {
        return 0.0;
    }
    pdf_reflected(lobe, to_upper_hemisphere(wi), to_upper_hemisphere(wo))
}

/// The density of two directions that were mirrored to the upper side.
#[inline]
fn pdf_reflected(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    let h = half_vector(wi, wo);
    let cos_h = wi.dot(h);
    if wo.z <= 0.0 || cos_h <= 0.0 {
        return 0.0;
    }
    // Jacobian of the reflection at h: d omega_h / d omega_o = 1 / (4 wi . h).
    lobe.microfacets().visible_normal_pdf(wi, h) / (4.0 * cos_h)
}

/// The reflection at a normal `m` that is visible from `wi` or, below the surface, from its opposite, on the other side.
#[inline]
pub fn sample(lobe: &Lobe, wi: Vec3, m: Vec3) -> BsdfSample {
    // The distribution is symmetric: turned by half a circle, normals that -wi sees are normals that the mirror image sees.
    let m = if wi.z < 0.0 {
        Vec3::new(-m.x, -m.y, m.z)
    } else {
        m
    };
    let above = to_upper_hemisphere(wi);
    let wo = reflect(above, m);
    if wi.z == 0.0 || wo.z <= 0.0 {
        return BsdfSample::NONE;
    }
    let s = BsdfSample::towards(wo, event::TRANSMISSION | event::GLOSSY);
    let s = weighted!(
        s,
        pdf_reflected(lobe, above, wo),
        eval_reflected(lobe, above, wo)
    );
    BsdfSample {
        wo: Vec3::new(wo.x, wo.y, float::with_sign_of(wo.z, -wi.z)),
        ..s
    }
}
