//! One lobe of a material: the choice of the model by its kind, two-sidedness and perturbed frames.
//!
//! A lobe's model knows only its own frame, z along its own normal. Three maps lie between that and the surface point:
//! - two-sided lobes ([`lobe_flag::FLIP_BACK`]) mirror z of both directions when wi is below the surface;
//! - a normal or bump map turns the directions into the perturbed frame. Where the two normals disagree on the side
//!   of a direction, nothing is scattered: cos_surface * cos_perturbed > 0 is required of wi and of wo, in evaluation
//!   and in sampling, or the two would describe different functions.
//!
//! Coats ([`super::coat`]) lie between the mirroring and the model: above the perturbed frame with
//! [`lobe_flag::COATS_OUTSIDE_FRAME`], in it without. They refract both directions, multiply the value by their
//! transmittances, and value and density by their Jacobian.
//!
//! Because the cosine that belongs to a lobe is that of its own normal, this level deals in `eval_cosine` = f |cos|,
//! per lobe, not yet multiplied by the lobe's weight in the material. Invariant (tests): for every kind, weight * pdf of
//! a sample equals `eval_cosine` there, and the samples follow `pdf`.

use super::microfacet::{self, Microfacets};
use super::{BsdfSample, Coat, Lobe, coat, event, frame_map, mode, model, null, rough_dielectric};
use crate::math::{Frame, Rgb, float, select};
use crate::scene::{MAX_COATS, NONE, features, lobe_flag, lobe_kind};
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
        features: features::ALL,
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

    #[inline]
    fn has_coats(&self) -> bool {
        self.may_be(features::COATS) && self.coat_count > 0
    }

    #[inline]
    fn has_map(&self) -> bool {
        self.may_be(features::FRAME_MAPS) && self.has_frame
    }

    /// Whether normals are sampled from all of the distribution rather than from its visible part, which coatings always do.
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

/// Whether every scattered direction of the kind is a discrete one.
#[inline]
pub fn is_delta(kind: u32) -> bool {
    kind == lobe_kind::CONDUCTOR
        || kind == lobe_kind::COAT
        || kind == lobe_kind::DIELECTRIC
        || kind == lobe_kind::THIN_DIELECTRIC
        || kind == lobe_kind::NULL
}

/// Whether some scattered direction of the lobe is a discrete one: also the coating of smooth plastic, and a rough
/// boundary between equal indices, which is no boundary.
#[inline]
pub fn has_delta(lobe: &Lobe) -> bool {
    is_delta(lobe.kind)
        || lobe.kind == lobe_kind::PLASTIC
        || (lobe.kind == lobe_kind::ROUGH_DIELECTRIC
            && float::abs(lobe.eta.x - 1.0) <= rough_dielectric::INDEX_MATCHED)
}

/// Whether the lobe exists for `wi`.
#[inline]
pub fn is_active(flags: u32, wi: Vec3) -> bool {
    // Without a branch on the side, which is often random.
    let side = select(
        wi.z > 0.0,
        lobe_flag::FRONT,
        select(wi.z < 0.0, lobe_flag::BACK, 0),
    );
    flags & side != 0
}

/// The value times the cosine of the lobe's normal with `wo`; the discrete part is not in it.
#[inline]
pub fn eval_cosine(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    let (i, o) = both_inside(lobe, data, wi, wo);
    if !o.valid {
        return Vec3::ZERO;
    }
    model::eval(lobe, data, i.w, o.w) * value_factor(lobe, &i, &o)
}

/// Density of [`sample`] per solid angle; the discrete part is not in it.
#[inline]
pub fn pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    let (i, o) = both_inside(lobe, data, wi, wo);
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
    let (i, o) = both_inside(lobe, data, wi, wo);
    if !o.valid {
        return (Vec3::ZERO, 0.0);
    }
    (
        model::eval(lobe, data, i.w, o.w) * value_factor(lobe, &i, &o),
        model::pdf(lobe, data, i.w, o.w) * o.jacobian,
    )
}

/// Lobes without coats and perturbed frames ([`is_plain`]). Inlined, so that callers who know the kind get its code alone;
/// shaders do without, as it would be a second copy of all models.
#[cfg(not(target_arch = "spirv"))]
pub(crate) mod plain {
    use super::*;

    /// [`eval_cosine_pdf`](super::eval_cosine_pdf) of a plain lobe.
    #[inline(always)]
    pub fn eval_cosine_pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> (Rgb, f32) {
        if !is_active(lobe.flags, wi) || wo.z == 0.0 {
            return (Vec3::ZERO, 0.0);
        }
        let flip = is_flipped(lobe, wi);
        let (wi, wo) = (mirrored(flip, wi), mirrored(flip, wo));
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

/// Value without a cosine and the densities both ways of a plain lobe whose value does not depend on which of the two
/// directions is known; `is_valid` is false for other lobes.
#[inline]
pub(super) fn eval_pdf_both(lobe: &Lobe, wi: Vec3, wo: Vec3) -> BothWays {
    let kind = lobe.kind;
    if !is_plain(lobe) || !(kind == lobe_kind::DIFFUSE || kind == lobe_kind::ROUGH_CONDUCTOR) {
        return BothWays {
            is_valid: false,
            ..BothWays::ZERO
        };
    }
    if !is_active(lobe.flags, wi) || !(wi.z * wo.z > 0.0) {
        return BothWays::ZERO;
    }
    let flip = is_flipped(lobe, wi);
    let (wi, wo) = (mirrored(flip, wi), mirrored(flip, wo));
    let (value, pdf, pdf_reverse) = if kind == lobe_kind::DIFFUSE {
        (
            super::diffuse::eval(lobe, wi, wo),
            super::diffuse::pdf(lobe, wi, wo),
            super::diffuse::pdf(lobe, wo, wi),
        )
    } else {
        super::rough_conductor::eval_pdf_both(lobe, wi, wo)
    };
    BothWays {
        value,
        pdf,
        pdf_reverse,
        is_valid: true,
    }
}

/// See [`eval_pdf_both`].
#[derive(Clone, Copy, Debug)]
pub(super) struct BothWays {
    pub value: Rgb,
    pub pdf: f32,
    pub pdf_reverse: f32,
    pub is_valid: bool,
}

impl BothWays {
    const ZERO: BothWays = BothWays {
        value: Vec3::ZERO,
        pdf: 0.0,
        pdf_reverse: 0.0,
        is_valid: true,
    };
}

/// Whether light that the lobe scatters along a direction with a density stays on its side.
#[inline]
pub(super) fn is_opaque(kind: u32) -> bool {
    kind == lobe_kind::DIFFUSE
        || kind == lobe_kind::ROUGH_DIFFUSE
        || kind == lobe_kind::ROUGH_CONDUCTOR
        || kind == lobe_kind::DIFFRACTING_CONDUCTOR
        || kind == lobe_kind::PLASTIC
        || kind == lobe_kind::ROUGH_PLASTIC
        || kind == lobe_kind::ROUGH_COAT
        || kind == lobe_kind::MERL
        || is_delta(kind)
}

/// A direction in the surface's local frame with weight f |cos| / pdf.
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
    let i = inside(lobe, data, flip, wi);
    if !i.valid {
        return BsdfSample::NONE;
    }
    let mut s = model::sample(lobe, data, i.w, u1, u2);
    if s.pdf <= 0.0 {
        return BsdfSample::NONE;
    }
    let o = outside(lobe, data, s.wo);
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

/// A direction below the coats in the frame of the lobe's model, or above them, and what lies between.
struct Way {
    w: Vec3,
    /// What the coats leave of the light.
    transmittance: Rgb,
    /// Solid angle below the coats per solid angle above them.
    jacobian: f32,
    /// Cosine of the direction with the normal that a map perturbs.
    cos_unperturbed: f32,
    valid: bool,
}

/// The value times the cosine for exchanged directions over that for these, in the mode of radiance and for one frame of the
/// lobe: the ratio of |cos| of the known direction and of the sampled one, each with the lobe's own normal below its coats
/// and times the coats' Jacobian, and that of the terminator's shadowing, which asks for the direction of the light.
pub fn exchange_ratio(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    let flip = is_flipped(lobe, wi);
    let (i, o) = (inside(lobe, data, flip, wi), inside(lobe, data, flip, wo));
    let from = float::abs(o.w.z) * o.jacobian * shadowing(lobe, &i, &o);
    if !i.valid || !o.valid || !(from > 0.0) {
        return 0.0;
    }
    float::abs(i.w.z) * i.jacobian * shadowing(lobe, &o, &i) / from
}

/// Whether the lobe sees directions mirrored to the front.
#[inline]
pub(crate) fn is_flipped(lobe: &Lobe, wi: Vec3) -> bool {
    wi.z < 0.0 && lobe.flags & lobe_flag::FLIP_BACK != 0
}

/// Whether nothing lies between the surface and the model: the common case, which needs none of the maps below. Never in
/// shaders, for which the shortcut would be a second copy of all models.
#[inline]
fn is_plain(lobe: &Lobe) -> bool {
    !cfg!(target_arch = "spirv") && !lobe.has_coats() && !lobe.has_map()
}

/// `w` with its z negated if `flip`.
#[inline]
pub(crate) fn mirrored(flip: bool, w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, select(flip, -w.z, w.z))
}

/// Both directions in the frame of the model; the second is invalid where the lobe is zero.
#[inline]
fn both_inside(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> (Way, Way) {
    let flip = is_flipped(lobe, wi);
    let i = inside(lobe, data, flip, wi);
    let mut o = inside(lobe, data, flip, wo);
    o.valid = o.valid && i.valid && is_active(lobe.flags, wi);
    (i, o)
}

/// `w` in the frame of the model.
#[inline]
fn inside(lobe: &Lobe, data: &[f32], flip: bool, w: Vec3) -> Way {
    let mut way = Way {
        w: mirrored(flip, w),
        transmittance: Vec3::ONE,
        jacobian: 1.0,
        cos_unperturbed: w.z,
        valid: true,
    };
    let coats_first = lobe.flags & lobe_flag::COATS_OUTSIDE_FRAME != 0;
    if lobe.has_coats() && coats_first {
        pass_coats(lobe, data, &mut way);
        way.cos_unperturbed = way.w.z;
    }
    let unperturbed = way.w;
    if lobe.has_map() {
        way.w = lobe.frame.to_local(way.w);
    }
    way.valid = way.valid && same_side(unperturbed, way.w);
    if lobe.has_coats() && !coats_first {
        pass_coats(lobe, data, &mut way);
    }
    way
}

#[inline]
fn pass_coats(lobe: &Lobe, data: &[f32], way: &mut Way) {
    let passage = coat::enter(&lobe.coats, lobe.coat_count, data, way.w);
    way.w = passage.w;
    way.transmittance = passage.transmittance;
    way.jacobian = passage.jacobian;
    way.valid = way.valid && passage.valid;
}

/// The direction `w` of the model above coats and perturbed frame; not yet mirrored back.
#[inline]
fn outside(lobe: &Lobe, data: &[f32], w: Vec3) -> Way {
    let mut way = Way {
        w,
        transmittance: Vec3::ONE,
        jacobian: 1.0,
        cos_unperturbed: w.z,
        valid: true,
    };
    let coats_last = lobe.flags & lobe_flag::COATS_OUTSIDE_FRAME != 0;
    if lobe.has_coats() && !coats_last {
        leave_coats(lobe, data, &mut way);
    }
    if lobe.has_map() {
        let perturbed = way.w;
        way.w = lobe.frame.to_world(perturbed);
        way.valid = way.valid && same_side(way.w, perturbed);
    }
    way.cos_unperturbed = way.w.z;
    if lobe.has_coats() && coats_last {
        leave_coats(lobe, data, &mut way);
    }
    way
}

#[inline]
fn leave_coats(lobe: &Lobe, data: &[f32], way: &mut Way) {
    let passage = coat::leave(&lobe.coats, lobe.coat_count, data, way.w);
    way.w = passage.w;
    way.transmittance = passage.transmittance;
    way.jacobian = passage.jacobian;
    way.valid = way.valid && passage.valid;
}

/// What the model's value is multiplied by: its cosine, the coats, the terminator.
#[inline]
fn value_factor(lobe: &Lobe, i: &Way, o: &Way) -> Rgb {
    let cosine = float::abs(o.w.z) * o.jacobian * shadowing(lobe, i, o);
    i.transmittance * o.transmittance * cosine
}

/// A pair of directions below the coats in the frame of a lobe's model, for code that evaluates a model of its own there.
pub(crate) struct InnerPair {
    /// The known direction.
    pub wi: Vec3,
    /// The other one.
    pub wo: Vec3,
    /// Factor on a value times the cosine of the model's frame: coats, terminator and Jacobian.
    pub factor: Rgb,
    /// Factor on a density.
    pub jacobian: f32,
    /// Whether the lobe scatters between the two at all.
    pub valid: bool,
}

/// The directions as [`eval_cosine`] sees them.
#[inline]
pub(crate) fn inner_pair(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> InnerPair {
    let (i, o) = both_inside(lobe, data, wi, wo);
    InnerPair {
        wi: i.w,
        wo: o.w,
        factor: i.transmittance * o.transmittance * (o.jacobian * shadowing(lobe, &i, &o)),
        jacobian: o.jacobian,
        valid: o.valid,
    }
}

/// The terminator term of a perturbed frame: on camera paths light comes along `wo`, on light paths along `wi`.
#[inline]
fn shadowing(lobe: &Lobe, i: &Way, o: &Way) -> f32 {
    if !lobe.has_map() {
        return 1.0;
    }
    let cos_light = if lobe.mode == mode::RADIANCE {
        o.cos_unperturbed
    } else {
        i.cos_unperturbed
    };
    frame_map::terminator_shadowing(lobe.frame.n.z, cos_light)
}

#[inline]
fn same_side(a: Vec3, b: Vec3) -> bool {
    a.z * b.z > 0.0
}

/// What the lobe reflects and transmits, roughly: an upper bound on its colour from its parameters, for choosing a lobe
/// and for the albedo layer. Exact for diffuse and null lobes.
#[inline]
pub fn albedo(lobe: &Lobe, data: &[f32], wi: Vec3) -> Rgb {
    if !is_active(lobe.flags, wi) && lobe.kind != lobe_kind::NULL {
        return Vec3::ZERO;
    }
    model::albedo(lobe, data, wi) * coats_albedo(lobe, data, wi)
}

/// What the coats leave of the colour of the lobe below them.
#[inline]
fn coats_albedo(lobe: &Lobe, data: &[f32], wi: Vec3) -> Rgb {
    if !lobe.has_coats() {
        return Vec3::ONE;
    }
    let mut w = mirrored(is_flipped(lobe, wi), wi);
    if lobe.has_map() && lobe.flags & lobe_flag::COATS_OUTSIDE_FRAME == 0 {
        w = lobe.frame.to_local(w);
    }
    coat::round_trip(&lobe.coats, lobe.coat_count, data, w)
}

/// Relative probability of choosing the lobe: its weight in the material times the largest channel of its colour;
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
