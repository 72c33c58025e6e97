//! [`super::regularized_bsdf`] of one plain lobe, without coats, perturbed frame or mixing factors. Inlined and without
//! branches on the roughness, so that loops over lanes which know the kind compile to the code of its rough model alone.
//!
//! Invariant (tests): the numbers are those of a material of that lobe alone, to the bit. Hosts only, as lanes are.

use super::both_ways::is_lobe_raised;
use super::regularized_bsdf::{alpha_hat, density_of, roughened, thin_cones};
use crate::bsdf::{Lobe, lobe, mixture};
use crate::math::Rgb;
use crate::scene::lobe_kind;
use glam::Vec3;

/// f_hat |cos| and p_hat; f |cos| and p of a lobe that is not raised.
#[inline(always)]
pub fn eval_cosine_pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3, tau: f32) -> (Rgb, f32) {
    let is_raised = is_lobe_raised(lobe, tau);
    let (f, p_hat) = if lobe.kind == lobe_kind::THIN_DIELECTRIC {
        thin_dielectric(lobe, wi, wo, tau)
    } else {
        let transmission = wi.z * wo.z < 0.0;
        let alpha = alpha_hat(lobe, transmission, tau);
        let regularized = roughened(lobe, alpha);
        let (f, p) = mixture::plain::eval_cosine_pdf(&regularized, data, wi, wo);
        let pair = lobe::pair_to_plain_model(lobe, wi, wo);
        let p_hat = density_of(lobe, &regularized, data, pair, 1.0, p);
        let p_hat = if p > 0.0 { p_hat } else { 0.0 };
        (f, if is_raised { p_hat } else { p })
    };
    // What is specular and not raised, a boundary of equal indices, has neither value nor density.
    let is_some = is_raised | !lobe::is_delta(lobe.kind);
    if is_some {
        (f, p_hat)
    } else {
        (Rgb::ZERO, 0.0)
    }
}

#[inline(always)]
fn thin_dielectric(lobe: &Lobe, wi: Vec3, wo: Vec3, tau: f32) -> (Rgb, f32) {
    let [inner, outer] = lobe::pair_to_plain_model(lobe, wi, wo);
    let (colour, p) = thin_cones(lobe, inner, outer, tau);
    let is_valid =
        lobe::is_active(lobe.flags, wi) & (inner.z * inner.z > 0.0) & (outer.z * outer.z > 0.0);
    if is_valid {
        (Rgb::ZERO + colour * p, p)
    } else {
        (Rgb::ZERO, 0.0)
    }
}
