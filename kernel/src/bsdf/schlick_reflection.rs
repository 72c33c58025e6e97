//! Microfacets that reflect with Schlick's approximation: the metal of the principled model, and its tinted highlight.
//!
//! `f = F(wi . h) D(h) G1(wi) G1(wo) / (4 wi.z wo.z)` as of [`super::rough_conductor`], with
//! `F(c) = R + (1 - R) (1 - c)^5` (Schlick 1994; Burley 2012, section 5.4). R is `reflectance`; with [`lobe_flag::TINTED`] it is the
//! hue of that colour times the reflectance ((eta - 1) / (eta + 1))^2 at normal incidence. All is scaled by
//! `specular_reflectance`. Normals are sampled by their visibility. Invariants (tests): reciprocity, values of an independent
//! renderer.

use super::coat_reflection::half_vector;
use super::fresnel::reflect;
use super::principled_diffuse::schlick_weight;
use super::sheen::hue;
use super::{BsdfSample, Lobe, event, weighted};
use crate::math::{Rgb, float};
use crate::scene::lobe_flag;
use glam::Vec3;

/// Reflectance at an incident cosine.
#[inline]
pub fn fresnel(lobe: &Lobe, cos: f32) -> Rgb {
    let normal = if lobe.flags & lobe_flag::TINTED != 0 {
        hue(lobe.reflectance) * float::sqr((lobe.eta.x - 1.0) / (lobe.eta.x + 1.0))
    } else {
        lobe.reflectance
    };
    let normal = normal.max(Vec3::ZERO).min(Vec3::ONE);
    lobe.specular_reflectance * normal.lerp(Vec3::ONE, schlick_weight(cos))
}

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    let h = half_vector(wi, wo);
    let cos_h = wi.dot(h);
    if wi.z <= 0.0 || wo.z <= 0.0 || cos_h <= 0.0 {
        return Vec3::ZERO;
    }
    let facets = lobe.microfacets();
    let area = facets.projected_area(wi) * facets.projected_area(wo);
    fresnel(lobe, cos_h) * (0.25 * facets.distribution(h) / area)
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    let h = half_vector(wi, wo);
    let cos_h = wi.dot(h);
    if wi.z <= 0.0 || wo.z <= 0.0 || cos_h <= 0.0 {
        return 0.0;
    }
    // Jacobian of the reflection at h: d omega_h / d omega_o = 1 / (4 wi . h).
    lobe.microfacets().visible_normal_pdf(wi, h) / (4.0 * cos_h)
}

/// The mirror image of `wi` at the visible normal `m`.
#[inline]
pub fn sample(lobe: &Lobe, wi: Vec3, m: Vec3) -> BsdfSample {
    let wo = reflect(wi, m);
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return BsdfSample::NONE;
    }
    let s = BsdfSample::towards(wo, event::REFLECTION | event::GLOSSY);
    weighted!(s, pdf(lobe, wi, wo), eval(lobe, wi, wo))
}
