//! A whole material below tau: its value, and the densities p_hat of both directions that weights of all strategies need.
//!
//! As [`crate::bsdf::reverse`] does for the model itself: the value is f_hat(wi, wo) |cos wo| or, on light walks,
//! f_hat(wo, wi) |cos wi|, and the material is looked up a second time where the lobes for wi are not those for wo. Lobe by
//! lobe see [`super::regularized_bsdf`]. A material of which no lobe would be raised is not regularised at all, so that its
//! numbers are those of the model to the bit ([`is_raised`]).
//!
//! Invariants (tests): the two densities are exchanged with the directions; without a raised lobe all is as it was.

use super::bandwidth::TAU_MAX;
use super::boundary::{glass_both, is_plain_glass, is_plain_metal, metal_both};
use super::regularized_bsdf::{
    alpha_hat, density, eval_cosine_pdf, mixture_eval_cosine_pdf, regularized_lobe,
};
use crate::bsdf::{Bsdf, BsdfValue, Lobe, lobe, mode};
use crate::scene::{SurfacePoint, Tables, lobe_kind};
use glam::Vec3;

/// Whether the lobe has another value below `tau` for some pair of directions.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn is_lobe_raised(lobe: &Lobe, tau: f32) -> bool {
    if lobe.kind == lobe_kind::THIN_DIELECTRIC {
        return true;
    }
    let reflected = alpha_hat(lobe, false, tau);
    let alpha = if lobe::is_opaque(lobe.kind) {
        reflected
    } else {
        reflected.max(alpha_hat(lobe, true, tau))
    };
    if lobe::is_delta(lobe.kind) || lobe.kind == lobe_kind::PLASTIC {
        return alpha > 0.0;
    }
    alpha > lobe.alpha.min_element()
}

/// Whether any lobe has another value below `tau`.
#[inline]
pub fn is_raised(bsdf: &Bsdf, tau: f32) -> bool {
    if !(tau < TAU_MAX) {
        return false;
    }
    for i in 0..bsdf.lobe_count() {
        if is_lobe_raised(bsdf.lobe_at(i), tau) {
            return true;
        }
    }
    false
}

/// [`Bsdf::eval_cosine_pdf_both`] below `tau`: f_hat |cos| and p_hat. The densities are undefined where the value is zero.
pub fn eval_cosine_pdf_both(
    bsdf: &Bsdf,
    tables: &Tables<'_>,
    point: &SurfacePoint,
    wi: Vec3,
    wo: Vec3,
    is_exchanged: bool,
    tau: f32,
) -> BsdfValue {
    if bsdf.lobe_count() == 1 && is_plain_metal(bsdf.lobe_at(0)) {
        let only = bsdf.lobe_at(0);
        let both = metal_both(only, wi, wo, is_exchanged, tau);
        return BsdfValue {
            value: both.value * only.weight,
            ..both
        };
    }
    let mut both = BsdfValue::ZERO;
    if !bsdf.holds_reverse(tables, point, wi, wo) {
        let reverse = Bsdf::at(tables, point, wo, mode::RADIANCE);
        let forward = mixture_eval_cosine_pdf(bsdf, tables.data, wi, wo, tau);
        let backward = mixture_eval_cosine_pdf(&reverse, tables.data, wo, wi, tau);
        return BsdfValue {
            value: if is_exchanged { backward.0 } else { forward.0 },
            pdf: forward.1,
            pdf_reverse: backward.1,
        };
    }
    let count = bsdf.lobe_count();
    let mut sum = 0.0;
    for i in 0..count {
        let lobe = bsdf.lobe_at(i);
        let own = lobe_both(lobe, tables.data, wi, wo, is_exchanged, tau);
        let selection = if count == 1 {
            1.0
        } else {
            lobe::selection_weight(lobe, tables.data, wo)
        };
        both.value += own.value * lobe.weight;
        both.pdf += own.pdf * bsdf.selection(i);
        both.pdf_reverse += own.pdf_reverse * selection;
        sum += selection;
    }
    if sum > 0.0 {
        both.pdf_reverse /= sum;
        both
    } else {
        BsdfValue::ZERO
    }
}

/// f_hat |cos| of one lobe, not yet multiplied by its weight, and p_hat of both directions.
fn lobe_both(
    lobe: &Lobe,
    data: &[f32],
    wi: Vec3,
    wo: Vec3,
    is_exchanged: bool,
    tau: f32,
) -> BsdfValue {
    if is_plain_metal(lobe) {
        return metal_both(lobe, wi, wo, is_exchanged, tau);
    }
    if is_plain_glass(lobe) {
        return glass_both(lobe, wi, wo, is_exchanged, tau);
    }
    if lobe.kind == lobe_kind::THIN_DIELECTRIC {
        let forward = eval_cosine_pdf(lobe, data, wi, wo, tau);
        let backward = eval_cosine_pdf(lobe, data, wo, wi, tau);
        return BsdfValue {
            value: if is_exchanged { backward.0 } else { forward.0 },
            pdf: forward.1,
            pdf_reverse: backward.1,
        };
    }
    // The same for both directions, whose pair is reflection or refraction either way.
    let regularized = regularized_lobe(lobe, wi.z * wo.z < 0.0, tau);
    let (known, sampled) = if is_exchanged { (wo, wi) } else { (wi, wo) };
    let (value, first) = lobe::eval_cosine_pdf(&regularized, data, known, sampled);
    let second = lobe::pdf(&regularized, data, sampled, known);
    let first = density(lobe, &regularized, data, [known, sampled], first);
    let second = density(lobe, &regularized, data, [sampled, known], second);
    let (pdf, pdf_reverse) = if is_exchanged {
        (second, first)
    } else {
        (first, second)
    };
    BsdfValue {
        value,
        pdf,
        pdf_reverse,
    }
}
