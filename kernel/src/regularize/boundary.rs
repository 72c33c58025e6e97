//! Plain metals and glass below tau: the value and both densities p_hat of one look at the distribution.
//!
//! The value f_hat is that of the raised roughness, whose projected areas are A_hat. The visible normals of the lobe itself weight by
//! its own areas A (see [`super::regularized_bsdf`]): `p_hat(wo) = f_hat A(wo)` without colour and with Fresnel's share, times
//! the squared relative index where light is refracted, and `f_hat A(wi)` for wi where wo is known. Most of the time of regularised
//! connections goes to this function where much is metal or glass.

use super::bounds;
use super::regularized_bsdf::{alpha_hat, distribution_of, is_index_matched, own_area};
use crate::bsdf::fresnel::fresnel_conductor;
use crate::bsdf::microfacet::Microfacets;
use crate::bsdf::rough_dielectric::boundary_value;
use crate::bsdf::{BsdfValue, Lobe, lobe};
use crate::math::float::abs;
use crate::scene::{distribution as kinds, lobe_kind};
use glam::{Vec2, Vec3};

/// Whether the lobe has no layers, and normals that are sampled as Smith's visible ones or none.
#[inline]
fn is_plain(lobe: &Lobe) -> bool {
    let is_smooth = lobe.kind == lobe_kind::CONDUCTOR || lobe.kind == lobe_kind::DIELECTRIC;
    let is_smith = lobe.distribution == kinds::BECKMANN || lobe.distribution == kinds::GGX;
    (is_smooth || is_smith && !lobe.samples_all_normals()) && lobe::is_plain(lobe)
}

/// Whether [`metal_both`] applies.
#[inline]
pub(super) fn is_plain_metal(lobe: &Lobe) -> bool {
    let is_metal = lobe.kind == lobe_kind::CONDUCTOR || lobe.kind == lobe_kind::ROUGH_CONDUCTOR;
    is_metal && is_plain(lobe)
}

/// Whether [`glass_both`] applies.
#[inline]
pub(super) fn is_plain_glass(lobe: &Lobe) -> bool {
    let is_glass = lobe.kind == lobe_kind::DIELECTRIC || lobe.kind == lobe_kind::ROUGH_DIELECTRIC;
    is_glass && is_plain(lobe) && !is_index_matched(lobe)
}

/// The microfacets of the lobe below tau.
#[inline]
fn raised_facets(lobe: &Lobe, transmission: bool, tau: f32) -> Microfacets {
    let raised = alpha_hat(lobe, transmission, tau);
    let is_smooth = lobe.kind == lobe_kind::CONDUCTOR || lobe.kind == lobe_kind::DIELECTRIC;
    let alpha = if is_smooth {
        Vec2::splat(raised)
    } else {
        bounds::raise(lobe.alpha, raised)
    };
    Microfacets::new(distribution_of(lobe), alpha, lobe.exponent)
}

/// f_hat |cos| of a metal, or f_hat(wo, wi) |cos wi| if `is_exchanged`, and p_hat of wo for wi and of wi for wo.
pub(super) fn metal_both(
    lobe: &Lobe,
    wi: Vec3,
    wo: Vec3,
    is_exchanged: bool,
    tau: f32,
) -> BsdfValue {
    if !lobe::is_active(lobe.flags, wi) || !(wi.z * wo.z > 0.0) {
        return BsdfValue::ZERO;
    }
    let [wi, wo] = lobe::pair_to_plain_model(lobe, wi, wo);
    let m = (wi + wo).normalize_or_zero();
    let cos_i = wi.dot(m);
    if wi.z <= 0.0 || cos_i <= 0.0 {
        return BsdfValue::ZERO;
    }
    let facets = raised_facets(lobe, false, tau);
    let f = 0.25 * facets.distribution(m) / (facets.projected_area(wi) * facets.projected_area(wo));
    let cosine = if is_exchanged { wi.z } else { wo.z };
    let fresnel = fresnel_conductor(cos_i, lobe.eta, lobe.k);
    BsdfValue {
        value: lobe.specular_reflectance * fresnel * (f * cosine),
        pdf: f * own_area(lobe, wo),
        pdf_reverse: f * own_area(lobe, wi),
    }
}

/// [`metal_both`] of glass that exists on the sides of both directions.
pub(super) fn glass_both(
    lobe: &Lobe,
    wi: Vec3,
    wo: Vec3,
    is_exchanged: bool,
    tau: f32,
) -> BsdfValue {
    if !lobe::is_active(lobe.flags, wi) || wo.z == 0.0 {
        return BsdfValue::ZERO;
    }
    let [wi, wo] = lobe::pair_to_plain_model(lobe, wi, wo);
    let facets = raised_facets(lobe, wi.z * wo.z < 0.0, tau);
    let boundary = boundary_value(lobe, &facets, wi, wo);
    let colour = if boundary.reflection {
        lobe.specular_reflectance
    } else {
        lobe.specular_transmittance
    };
    let (f, exchanged) = (boundary.value, boundary.exchanged);
    BsdfValue {
        value: colour
            * if is_exchanged {
                f * exchanged * abs(wi.z)
            } else {
                f * abs(wo.z)
            },
        pdf: f * exchanged * own_area(lobe, wo),
        pdf_reverse: f * own_area(lobe, wi),
    }
}
