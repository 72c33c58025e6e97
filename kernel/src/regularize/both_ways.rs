//! A whole material below tau: its value, and the densities p_hat of both directions that weights of all strategies need.
//!
//! As [`crate::bsdf::reverse`] does for the model itself: the value is f_hat(wi, wo) |cos wo| or, on light walks,
//! f_hat(wo, wi) |cos wi|, and the material is looked up a second time where the lobes for wi are not those for wo. Lobe by
//! lobe see [`super::regularized_bsdf`]. A material of which no lobe would be raised is not regularised at all, so that its
//! numbers are those of the model to the bit ([`is_raised`]).
//!
//! Invariants (tests): the two densities are exchanged with the directions; without a raised lobe all is as it was.

use super::bandwidth::TAU_MAX;
use super::regularized_bsdf::{alpha_hat, mixture_eval_cosine_pdf};
use crate::bsdf::{Bsdf, BsdfValue, Lobe, lobe, mode};
use crate::math::Rgb;
use crate::scene::{SurfacePoint, Tables, lobe_kind};
use glam::Vec3;

/// Whether the lobe has another value below `tau` for some pair of directions.
#[inline]
fn is_lobe_raised(lobe: &Lobe, tau: f32) -> bool {
    if lobe.kind == lobe_kind::THIN_DIELECTRIC {
        return true;
    }
    let reflected = alpha_hat(lobe, false, tau);
    let transmitted = alpha_hat(lobe, true, tau);
    let alpha = if reflected > transmitted {
        reflected
    } else {
        transmitted
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

/// [`Bsdf::eval_cosine_pdf_both`] below `tau`: f_hat |cos| and p_hat.
pub fn eval_cosine_pdf_both(
    bsdf: &Bsdf,
    tables: &Tables<'_>,
    point: &SurfacePoint,
    wi: Vec3,
    wo: Vec3,
    is_exchanged: bool,
    tau: f32,
) -> BsdfValue {
    let mut both = BsdfValue::ZERO;
    let forward = |bsdf: &Bsdf| mixture_eval_cosine_pdf(bsdf, tables.data, wi, wo, tau);
    if is_exchanged {
        (both.value, both.pdf_reverse) = reverse(bsdf, tables, point, wi, wo, tau);
        if both.value.max_element() > 0.0 {
            both.pdf = forward(bsdf).1;
        }
    } else {
        (both.value, both.pdf) = forward(bsdf);
        if both.value.max_element() > 0.0 {
            both.pdf_reverse = reverse(bsdf, tables, point, wi, wo, tau).1;
        }
    }
    both
}

/// f_hat(wo, wi) |cos wi| and the density of sampling wi where wo is known, of a material looked up for wi.
fn reverse(
    bsdf: &Bsdf,
    tables: &Tables<'_>,
    point: &SurfacePoint,
    wi: Vec3,
    wo: Vec3,
    tau: f32,
) -> (Rgb, f32) {
    if !bsdf.holds_reverse(tables, point, wi, wo) {
        let reverse = Bsdf::at(tables, point, wo, mode::RADIANCE);
        return mixture_eval_cosine_pdf(&reverse, tables.data, wo, wi, tau);
    }
    let mut value = Vec3::ZERO;
    let mut pdf = 0.0;
    let mut sum = 0.0;
    for i in 0..bsdf.lobe_count() {
        let lobe = bsdf.lobe_at(i);
        let (f, p) = super::regularized_bsdf::eval_cosine_pdf(lobe, tables.data, wo, wi, tau);
        let selection = if bsdf.lobe_count() == 1 {
            1.0
        } else {
            lobe::selection_weight(lobe, tables.data, wo)
        };
        value += f * lobe.weight;
        pdf += p * selection;
        sum += selection;
    }
    if sum > 0.0 {
        (value, pdf / sum)
    } else {
        (Vec3::ZERO, 0.0)
    }
}
