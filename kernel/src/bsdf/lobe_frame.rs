//! From the local frame of the surface to the frame of a lobe's model, and back.
//!
//! A model knows only its own frame, z along its own normal. Three maps lie between that and the surface point:
//! - two-sided lobes ([`lobe_flag::FLIP_BACK`]) mirror z of both directions when wi is below the surface;
//! - a normal or bump map rotates the directions into the perturbed frame. Where the two normals disagree about the side of
//!   a direction, nothing is scattered: cos_surface * cos_perturbed > 0 is required of wi and of wo, in evaluation as in
//!   sampling, or the two would describe different functions;
//! - coats ([`super::coat`]) refract both directions, multiply the value by their transmittances, and value and density by
//!   their Jacobian. They lie above the perturbed frame with [`lobe_flag::COATS_OUTSIDE_FRAME`], inside it without.

use super::{Lobe, coat, frame_map, mode};
use crate::math::{Rgb, float, select};
use crate::scene::{features, lobe_flag};
use glam::Vec3;

impl Lobe {
    /// Whether there are coats above the model.
    #[inline]
    pub(super) fn has_coats(&self) -> bool {
        self.may_be(features::COATS) && self.coat_count > 0
    }

    /// Whether the lobe has a perturbed frame.
    #[inline]
    pub(super) fn has_map(&self) -> bool {
        self.may_be(features::FRAME_MAPS) && self.has_frame
    }
}

/// Whether a lobe of these flags exists on the side of `wi`.
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

/// A direction in the frame of the lobe's model, or above the layers again, and what the layers do to light along it.
pub(super) struct ModelDirection {
    /// The unit direction.
    pub w: Vec3,
    /// Transmittance of the coats.
    pub transmittance: Rgb,
    /// Solid angle below the coats per solid angle above them.
    pub jacobian: f32,
    /// Cosine of the direction with the unperturbed normal, below coats that lie outside the perturbed frame.
    pub cos_unperturbed: f32,
    /// Whether light passes along it.
    pub valid: bool,
}

impl ModelDirection {
    /// On the other side of the coats.
    #[inline]
    fn transmit_through_coats(&mut self, transmission: coat::CoatTransmission) {
        self.w = transmission.w;
        self.transmittance = transmission.transmittance;
        self.jacobian = transmission.jacobian;
        self.valid = self.valid && transmission.valid;
    }
}

/// f |cos| with the directions exchanged over f |cos| of (wi, wo), for radiance and with the frame of the lobe kept: the ratio
/// of |cos| of wi and of wo, each with the lobe's own normal below its coats and times the coats' Jacobian, and the ratio of
/// the terminator's shadowing, which depends on the direction of the light. Zero where the lobe scatters nothing.
pub fn exchange_ratio(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    let flip = is_flipped(lobe, wi);
    let (i, o) = (
        to_model(lobe, data, flip, wi),
        to_model(lobe, data, flip, wo),
    );
    let from = float::abs(o.w.z) * o.jacobian * shadowing(lobe, &i, &o);
    if !i.valid || !o.valid || !(from > 0.0) {
        return 0.0;
    }
    float::abs(i.w.z) * i.jacobian * shadowing(lobe, &o, &i) / from
}

/// Whether a two-sided lobe mirrors directions to its front side.
#[inline]
pub(crate) fn is_flipped(lobe: &Lobe, wi: Vec3) -> bool {
    wi.z < 0.0 && lobe.flags & lobe_flag::FLIP_BACK != 0
}

/// Whether the lobe has neither coats nor a perturbed frame: the common case, which skips these maps. Always false in shaders,
/// for which the shortcut would be a second copy of all models.
#[inline]
pub(crate) fn is_plain(lobe: &Lobe) -> bool {
    !cfg!(target_arch = "spirv") && !lobe.has_coats() && !lobe.has_map()
}

/// `w`, mirrored to the other side of the surface if `flip`.
#[inline]
pub(crate) fn mirrored(flip: bool, w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, select(flip, -w.z, w.z))
}

/// Both directions in the frame of the model of a plain lobe.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(crate) fn pair_to_plain_model(lobe: &Lobe, wi: Vec3, wo: Vec3) -> [Vec3; 2] {
    let flip = is_flipped(lobe, wi);
    [mirrored(flip, wi), mirrored(flip, wo)]
}

/// Both directions in the frame of the model; the second is invalid where the lobe scatters nothing between them.
#[inline]
pub(super) fn pair_to_model(
    lobe: &Lobe,
    data: &[f32],
    wi: Vec3,
    wo: Vec3,
) -> (ModelDirection, ModelDirection) {
    let flip = is_flipped(lobe, wi);
    let i = to_model(lobe, data, flip, wi);
    let mut o = to_model(lobe, data, flip, wo);
    o.valid = o.valid && i.valid && is_active(lobe.flags, wi);
    (i, o)
}

/// The local direction `w` of the surface in the frame of the model.
#[inline]
pub(super) fn to_model(lobe: &Lobe, data: &[f32], flip: bool, w: Vec3) -> ModelDirection {
    let mut direction = ModelDirection {
        w: mirrored(flip, w),
        transmittance: Vec3::ONE,
        jacobian: 1.0,
        cos_unperturbed: w.z,
        valid: true,
    };
    let coats_first = lobe.flags & lobe_flag::COATS_OUTSIDE_FRAME != 0;
    if lobe.has_coats() && coats_first {
        direction.transmit_through_coats(coat::refract_in(
            &lobe.coats,
            lobe.coat_count,
            data,
            direction.w,
        ));
        direction.cos_unperturbed = direction.w.z;
    }
    let unperturbed = direction.w;
    if lobe.has_map() {
        direction.w = lobe.frame.to_local(direction.w);
    }
    direction.valid = direction.valid && same_side(unperturbed, direction.w);
    if lobe.has_coats() && !coats_first {
        direction.transmit_through_coats(coat::refract_in(
            &lobe.coats,
            lobe.coat_count,
            data,
            direction.w,
        ));
    }
    direction
}

/// The inverse of [`to_model`] without the mirroring: a direction `w` of the model in the local frame of the surface.
#[inline]
pub(super) fn from_model(lobe: &Lobe, data: &[f32], w: Vec3) -> ModelDirection {
    let mut direction = ModelDirection {
        w,
        transmittance: Vec3::ONE,
        jacobian: 1.0,
        cos_unperturbed: w.z,
        valid: true,
    };
    let coats_last = lobe.flags & lobe_flag::COATS_OUTSIDE_FRAME != 0;
    if lobe.has_coats() && !coats_last {
        direction.transmit_through_coats(coat::refract_out(
            &lobe.coats,
            lobe.coat_count,
            data,
            direction.w,
        ));
    }
    if lobe.has_map() {
        let perturbed = direction.w;
        direction.w = lobe.frame.to_world(perturbed);
        direction.valid = direction.valid && same_side(direction.w, perturbed);
    }
    direction.cos_unperturbed = direction.w.z;
    if lobe.has_coats() && coats_last {
        direction.transmit_through_coats(coat::refract_out(
            &lobe.coats,
            lobe.coat_count,
            data,
            direction.w,
        ));
    }
    direction
}

/// Factor from the model's value to f |cos|: its cosine, the coats' transmittances and Jacobian, the terminator's shadowing.
#[inline]
pub(super) fn value_factor(lobe: &Lobe, i: &ModelDirection, o: &ModelDirection) -> Rgb {
    let cosine = float::abs(o.w.z) * o.jacobian * shadowing(lobe, i, o);
    i.transmittance * o.transmittance * cosine
}

/// A pair of directions in the frame of a lobe's model, for code that evaluates another model there.
pub(crate) struct InnerPair {
    /// The known direction.
    pub wi: Vec3,
    /// The sampled direction.
    pub wo: Vec3,
    /// Factor on f times the cosine in the model's frame: transmittances and Jacobian of the coats, terminator's shadowing.
    pub factor: Rgb,
    /// Factor on a density.
    pub jacobian: f32,
    /// Whether the lobe can scatter between the two.
    pub valid: bool,
}

/// The pair of directions at which [`super::lobe::eval_cosine`] evaluates the model.
#[inline]
pub(crate) fn inner_pair(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> InnerPair {
    let (i, o) = pair_to_model(lobe, data, wi, wo);
    InnerPair {
        wi: i.w,
        wo: o.w,
        factor: i.transmittance * o.transmittance * (o.jacobian * shadowing(lobe, &i, &o)),
        jacobian: o.jacobian,
        valid: o.valid,
    }
}

/// Shadowing at the terminator of a perturbed frame: the light comes from `wo` on camera paths, from `wi` on light paths.
#[inline]
pub(super) fn shadowing(lobe: &Lobe, i: &ModelDirection, o: &ModelDirection) -> f32 {
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

/// Whether both directions are on the same side of their normals.
#[inline]
fn same_side(a: Vec3, b: Vec3) -> bool {
    a.z * b.z > 0.0
}

/// Transmittance of the coats for the albedo of the model below them.
#[inline]
pub(super) fn coats_albedo(lobe: &Lobe, data: &[f32], wi: Vec3) -> Rgb {
    if !lobe.has_coats() {
        return Vec3::ONE;
    }
    let mut w = mirrored(is_flipped(lobe, wi), wi);
    if lobe.has_map() && lobe.flags & lobe_flag::COATS_OUTSIDE_FRAME == 0 {
        w = lobe.frame.to_local(w);
    }
    coat::round_trip(&lobe.coats, lobe.coat_count, data, w)
}
