//! One lobe of a material: evaluation, density and sampling of the model that its kind names.
//!
//! The model is evaluated in its own frame, to which `lobe_frame` maps the directions: two-sided lobes, perturbed
//! frames and coats are handled there. The cosine that belongs to a lobe is that with its own normal, which is not the
//! surface's under a normal or bump map. This level therefore works with `eval_cosine` = f |cos|, per lobe, not yet
//! multiplied by the lobe's weight in the material.
//!
//! Invariant (tests): for every kind, weight * pdf of a sample equals `eval_cosine` there, and the samples follow `pdf`.

pub(crate) use super::lobe_frame::inner_pair;
pub use super::lobe_frame::{exchange_ratio, is_active};
pub(crate) use super::lobe_frame::{is_flipped, is_plain, mirrored, pair_to_plain_model};

use super::lobe_frame::{
    coats_albedo, from_model, pair_to_model, shadowing, to_model, value_factor,
};
use super::microfacet::{self, Microfacets};
use super::{BsdfSample, BsdfValue, Coat, Lobe, event, mode, model, null, rough_dielectric};
use crate::math::{Frame, Rgb, float};
use crate::scene::{MAX_COATS, NONE, lobe_flag, lobe_kind};
use glam::{Vec2, Vec3};
pub use model::events;

impl Lobe {
    /// A black lobe with neutral parameters.
    pub const NONE: Lobe = Lobe {
        kind: lobe_kind::DIFFUSE,
        distribution: 0,
        flags: lobe_flag::FRONT,
        weight: 0.0,
        frame: Frame::LOCAL,
        has_frame: false,
        reflectance: Vec3::ZERO,
        specular_reflectance: Vec3::ZERO,
        specular_transmittance: Vec3::ZERO,
        eta: Vec3::ONE,
        k: Vec3::ZERO,
        alpha: Vec2::ONE,
        table: NONE,
        table_rows: 1,
        internal_reflectance: 0.0,
        optical_depth: Vec3::ZERO,
        coat_count: 0,
        coats: [Coat::NONE; MAX_COATS],
        exponent: 1.0,
        mode: mode::RADIANCE,
        #[cfg(target_arch = "spirv")]
        features: crate::scene::features::ALL,
    };

    /// Whether the scene may have lobes with one of the [`crate::scene::features`].
    #[inline]
    pub fn may_be(&self, features: u32) -> bool {
        #[cfg(target_arch = "spirv")]
        {
            self.features & features != 0
        }
        #[cfg(not(target_arch = "spirv"))]
        {
            let _ = features;
            true
        }
    }

    /// Whether normals are sampled from the whole distribution rather than from that of visible normals. Coatings always
    /// sample visible ones.
    #[inline]
    pub fn samples_all_normals(&self) -> bool {
        self.flags & lobe_flag::SAMPLE_ALL_NORMALS != 0
            && (self.kind == lobe_kind::ROUGH_CONDUCTOR || self.kind == lobe_kind::ROUGH_DIELECTRIC)
    }

    /// The distribution of microfacets of a rough lobe.
    #[inline]
    pub fn microfacets(&self) -> Microfacets {
        Microfacets {
            kind: self.distribution,
            alpha: microfacet::clamp_alpha(self.alpha),
            exponent: self.exponent,
            #[cfg(target_arch = "spirv")]
            features: self.features,
        }
    }
}

/// Whether the kind is specular: all it scatters goes into discrete directions.
#[inline]
pub fn is_delta(kind: u32) -> bool {
    kind == lobe_kind::CONDUCTOR
        || kind == lobe_kind::COAT
        || kind == lobe_kind::DIELECTRIC
        || kind == lobe_kind::THIN_DIELECTRIC
        || kind == lobe_kind::NULL
}

/// Whether the lobe scatters into some discrete direction: also smooth plastic by its coating, and a rough boundary between
/// equal indices, which is no boundary.
#[inline]
pub fn has_delta(lobe: &Lobe) -> bool {
    is_delta(lobe.kind)
        || lobe.kind == lobe_kind::PLASTIC
        || lobe.kind == lobe_kind::HANRAHAN_KRUEGER
        || (lobe.kind == lobe_kind::ROUGH_DIELECTRIC
            && float::abs(lobe.eta.x - 1.0) <= rough_dielectric::INDEX_MATCHED)
}

/// f |cos|, with the cosine between `wo` and the lobe's own normal; without the discrete part.
#[inline]
pub fn eval_cosine(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    #[cfg(not(target_arch = "spirv"))]
    if is_plain(lobe) {
        return plain::eval_cosine(lobe, data, wi, wo);
    }
    let (i, o) = pair_to_model(lobe, data, wi, wo);
    if !o.valid {
        return Vec3::ZERO;
    }
    model::eval(lobe, data, i.w, o.w) * value_factor(lobe, &i, &o)
}

/// Density of [`sample`] per solid angle; without the discrete part.
#[inline]
pub fn pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    let (i, o) = pair_to_model(lobe, data, wi, wo);
    if !o.valid {
        return 0.0;
    }
    model::pdf(lobe, data, i.w, o.w) * o.jacobian
}

/// [`eval_cosine`] and [`pdf`] together.
#[inline]
pub fn eval_cosine_pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> (Rgb, f32) {
    #[cfg(not(target_arch = "spirv"))]
    if is_plain(lobe) {
        return plain::eval_cosine_pdf(lobe, data, wi, wo);
    }
    eval_cosine_pdf_layered(lobe, data, wi, wo)
}

/// [`eval_cosine_pdf`] of a lobe with coats or a perturbed frame.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(never))]
fn eval_cosine_pdf_layered(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> (Rgb, f32) {
    let (i, o) = pair_to_model(lobe, data, wi, wo);
    if !o.valid {
        return (Vec3::ZERO, 0.0);
    }
    (
        model::eval(lobe, data, i.w, o.w) * value_factor(lobe, &i, &o),
        model::pdf(lobe, data, i.w, o.w) * o.jacobian,
    )
}

/// Lobes without coats and perturbed frames ([`is_plain`]). Inlined, so that a caller that knows the kind compiles to the code
/// of that model alone. Not in shaders, where it would be a second copy of all models.
#[cfg(not(target_arch = "spirv"))]
pub(crate) mod plain {
    use super::*;

    /// [`eval_cosine`](super::eval_cosine) of a plain lobe.
    #[inline(always)]
    pub fn eval_cosine(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
        if !is_active(lobe.flags, wi) || wo.z == 0.0 {
            return Vec3::ZERO;
        }
        let [wi, wo] = pair_to_plain_model(lobe, wi, wo);
        model::eval(lobe, data, wi, wo) * float::abs(wo.z)
    }

    /// [`eval_cosine_pdf`](super::eval_cosine_pdf) of a plain lobe.
    #[inline(always)]
    pub fn eval_cosine_pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> (Rgb, f32) {
        if !is_active(lobe.flags, wi) || wo.z == 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let [wi, wo] = pair_to_plain_model(lobe, wi, wo);
        (
            model::eval(lobe, data, wi, wo) * float::abs(wo.z),
            model::pdf(lobe, data, wi, wo),
        )
    }

    /// [`sample`](super::sample) of a plain lobe; rough models reflect or refract at the microfacet normal that `normal` draws
    /// for a direction in the frame of the model.
    #[inline(always)]
    pub fn sample(
        lobe: &Lobe,
        data: &[f32],
        wi: Vec3,
        u1: f32,
        u2: Vec2,
        normal: impl FnOnce(Vec3) -> Vec3,
    ) -> BsdfSample {
        let flip = is_flipped(lobe, wi);
        let inner = mirrored(flip, wi);
        let mut s = model::sample_with_normal(lobe, data, inner, u1, u2, || normal(inner));
        s.wo = mirrored(flip, s.wo);
        if is_active(lobe.flags, wi) {
            s
        } else {
            BsdfSample::NONE
        }
    }
}

/// Whether [`eval_pdf_both`] applies: the lobe is plain, and its value does not depend on which of the two directions is known.
#[inline]
pub(super) fn is_reciprocal_and_plain(lobe: &Lobe) -> bool {
    let kind = lobe.kind;
    is_plain(lobe) && (kind == lobe_kind::DIFFUSE || kind == lobe_kind::ROUGH_CONDUCTOR)
}

/// The value *without* a cosine and the densities in both directions of a lobe that [`is_reciprocal_and_plain`].
#[inline]
pub(super) fn eval_pdf_both(lobe: &Lobe, wi: Vec3, wo: Vec3) -> BsdfValue {
    if !is_active(lobe.flags, wi) || !(wi.z * wo.z > 0.0) {
        return BsdfValue::ZERO;
    }
    let [wi, wo] = pair_to_plain_model(lobe, wi, wo);
    if lobe.kind == lobe_kind::DIFFUSE {
        BsdfValue {
            value: super::diffuse::eval(lobe, wi, wo),
            pdf: super::diffuse::pdf(lobe, wi, wo),
            pdf_reverse: super::diffuse::pdf(lobe, wo, wi),
        }
    } else {
        let (value, pdf, pdf_reverse) = super::rough_conductor::eval_pdf_both(lobe, wi, wo);
        BsdfValue {
            value,
            pdf,
            pdf_reverse,
        }
    }
}

/// Whether lobes of the kind scatter light only to the side from which it came, null scattering aside.
#[inline(always)]
pub(crate) fn is_opaque(kind: u32) -> bool {
    kind == lobe_kind::DIFFUSE
        || kind == lobe_kind::ROUGH_DIFFUSE
        || kind == lobe_kind::ROUGH_CONDUCTOR
        || kind == lobe_kind::DIFFRACTING_CONDUCTOR
        || kind == lobe_kind::PLASTIC
        || kind == lobe_kind::ROUGH_PLASTIC
        || kind == lobe_kind::ROUGH_COAT
        || kind == lobe_kind::MERL
        || kind == lobe_kind::MEASURED
        || is_delta(kind) && kind != lobe_kind::DIELECTRIC && kind != lobe_kind::THIN_DIELECTRIC
}

/// Samples a direction in the local frame of the surface, with weight f |cos| / pdf.
#[inline]
pub fn sample(lobe: &Lobe, data: &[f32], wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    if lobe.kind == lobe_kind::NULL {
        return null::sample(lobe, wi, u1, u2);
    }
    if !is_active(lobe.flags, wi) {
        return BsdfSample::NONE;
    }
    #[cfg(not(target_arch = "spirv"))]
    if is_plain(lobe) {
        let normal = |wi| model::sample_facet_normal(lobe, wi, u2);
        return plain::sample(lobe, data, wi, u1, u2, normal);
    }
    let flip = is_flipped(lobe, wi);
    let i = to_model(lobe, data, flip, wi);
    if !i.valid {
        return BsdfSample::NONE;
    }
    let mut s = model::sample(lobe, data, i.w, u1, u2);
    if s.pdf <= 0.0 {
        return BsdfSample::NONE;
    }
    let o = from_model(lobe, data, s.wo);
    if !o.valid {
        return BsdfSample::NONE;
    }
    s.wo = mirrored(flip, o.w);
    s.weight *= i.transmittance * o.transmittance * shadowing(lobe, &i, &o);
    if s.event & event::DELTA == 0 {
        s.pdf *= o.jacobian;
    }
    s
}

/// An estimate from above of the albedo of the lobe by its parameters, for choosing a lobe and for the albedo layer. Exact
/// for diffuse and null lobes.
#[inline]
pub fn albedo(lobe: &Lobe, data: &[f32], wi: Vec3) -> Rgb {
    if !is_active(lobe.flags, wi) && lobe.kind != lobe_kind::NULL {
        return Vec3::ZERO;
    }
    model::albedo(lobe, data, wi) * coats_albedo(lobe, data, wi)
}

/// Relative probability of choosing the lobe: its weight in the material times the largest channel of its estimated albedo;
/// zero exactly where the lobe scatters nothing.
#[inline]
pub fn selection_weight(lobe: &Lobe, data: &[f32], wi: Vec3) -> f32 {
    if !is_active(lobe.flags, wi) && lobe.kind != lobe_kind::NULL {
        return 0.0;
    }
    let mut colour = model::albedo(lobe, data, wi);
    if lobe.kind == lobe_kind::PLASTIC || lobe.kind == lobe_kind::ROUGH_PLASTIC {
        colour = colour.max(lobe.specular_reflectance);
    }
    lobe.weight * (colour * coats_albedo(lobe, data, wi)).max_element()
}
