//! Plain metals below tau: the value and both densities p_hat of one look at the distribution.
//!
//! With `d = D_hat(m) / 4` and the areas A_hat of the raised roughness, `f_hat = F d / (A_hat(wi) A_hat(wo))`; the visible normals
//! of the lobe itself weight by `p_hat(wo) = d / A_hat(wi) * A(wo) / A_hat(wo)`, A its own areas (see
//! [`super::regularized_bsdf`]). Most of the time of regularised connections goes to this function where much is metal.

use super::bounds;
use super::regularized_bsdf::{alpha_hat, own_area};
use crate::bsdf::fresnel::fresnel_conductor;
use crate::bsdf::microfacet::Microfacets;
use crate::bsdf::{BsdfValue, Lobe, lobe};
use crate::scene::{distribution as kinds, lobe_kind};
use glam::{Vec2, Vec3};

/// Whether [`eval_both`] applies: a metal without layers whose normals are sampled as Smith's visible ones.
#[inline]
pub(super) fn is_plain_metal(lobe: &Lobe) -> bool {
    let is_smooth = lobe.kind == lobe_kind::CONDUCTOR;
    let is_rough = lobe.kind == lobe_kind::ROUGH_CONDUCTOR
        && (lobe.distribution == kinds::BECKMANN || lobe.distribution == kinds::GGX)
        && !lobe.samples_all_normals();
    (is_smooth || is_rough) && lobe::is_plain(lobe)
}

/// f_hat without a cosine, which is the same for exchanged directions, and p_hat of wo for wi and of wi for wo.
pub(super) fn eval_both(lobe: &Lobe, wi: Vec3, wo: Vec3, tau: f32) -> BsdfValue {
    if !lobe::is_active(lobe.flags, wi) || !(wi.z * wo.z > 0.0) {
        return BsdfValue::ZERO;
    }
    let flip = lobe::is_flipped(lobe, wi);
    let (wi, wo) = (lobe::mirrored(flip, wi), lobe::mirrored(flip, wo));
    let m = (wi + wo).normalize_or_zero();
    let cos_i = wi.dot(m);
    if wi.z <= 0.0 || cos_i <= 0.0 {
        return BsdfValue::ZERO;
    }
    let raised = alpha_hat(lobe, false, tau);
    let facets = if lobe.kind == lobe_kind::CONDUCTOR {
        let distribution = super::regularized_bsdf::distribution_of(lobe);
        Microfacets::new(distribution, Vec2::splat(raised), lobe.exponent)
    } else {
        let alpha = bounds::raise(lobe.alpha, raised);
        Microfacets::new(lobe.distribution, alpha, lobe.exponent)
    };
    let d = 0.25 * facets.distribution(m);
    let f = d / (facets.projected_area(wi) * facets.projected_area(wo));
    BsdfValue {
        value: lobe.specular_reflectance * fresnel_conductor(cos_i, lobe.eta, lobe.k) * f,
        pdf: f * own_area(lobe, wo),
        pdf_reverse: f * own_area(lobe, wi),
    }
}
