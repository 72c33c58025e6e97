//! One lobe of a material: the choice of the model by its kind, two-sidedness and perturbed frames.
//!
//! A lobe's model knows only its own frame, z along its own normal. Two maps lie between that and the surface point:
//! - two-sided lobes ([`lobe_flag::FLIP_BACK`]) mirror z of both directions when wi is below the surface;
//! - a normal or bump map turns the directions into the perturbed frame. Where the two normals disagree on the side
//!   of a direction, nothing is scattered: cos_surface * cos_perturbed > 0 is required of wi and of wo, in evaluation
//!   and in sampling, or the two would describe different functions.
//!
//! Because the cosine that belongs to a lobe is that of its own normal, this level deals in `eval_cosine` = f |cos|,
//! per lobe, not yet multiplied by the lobe's weight in the material. Invariant (tests): for every kind, weight * pdf of
//! a sample equals `eval_cosine` there, and the samples follow `pdf`.

use super::fresnel::fresnel_conductor;
use super::{
    BsdfSample, Lobe, conductor, dielectric, diffuse, event, frame_map, mode, null, plastic,
    rough_conductor, rough_dielectric, rough_plastic, thin_dielectric,
};
use crate::math::{Frame, Rgb, float};
use crate::scene::{NONE, lobe_flag, lobe_kind};
use glam::{Vec2, Vec3};

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
        internal_reflectance: 0.0,
        mode: mode::RADIANCE,
    };
}

/// Whether every scattered direction of the kind is a discrete one.
#[inline]
pub fn is_delta(kind: u32) -> bool {
    kind == lobe_kind::CONDUCTOR
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
    (wi.z > 0.0 && flags & lobe_flag::FRONT != 0) || (wi.z < 0.0 && flags & lobe_flag::BACK != 0)
}

/// The value times the cosine of the lobe's normal with `wo`; the discrete part is not in it.
#[inline]
pub fn eval_cosine(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    let local = Local::new(lobe, wi);
    let w = local.enter(lobe, wo);
    if !local.valid || !same_side(local.outer(wo), w) {
        return Vec3::ZERO;
    }
    model_eval(lobe, data, local.wi, w) * (float::abs(w.z) * shadowing(lobe, wi, wo))
}

/// Density of [`sample`] per solid angle; the discrete part is not in it.
#[inline]
pub fn pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    let local = Local::new(lobe, wi);
    let w = local.enter(lobe, wo);
    if !local.valid || !same_side(local.outer(wo), w) {
        return 0.0;
    }
    model_pdf(lobe, data, local.wi, w)
}

/// [`eval_cosine`] and [`pdf`] together.
#[inline]
pub fn eval_cosine_pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> (Rgb, f32) {
    let local = Local::new(lobe, wi);
    let w = local.enter(lobe, wo);
    if !local.valid || !same_side(local.outer(wo), w) {
        return (Vec3::ZERO, 0.0);
    }
    (
        model_eval(lobe, data, local.wi, w) * (float::abs(w.z) * shadowing(lobe, wi, wo)),
        model_pdf(lobe, data, local.wi, w),
    )
}

/// A direction in the surface's local frame with weight f |cos| / pdf.
#[inline]
pub fn sample(lobe: &Lobe, data: &[f32], wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    if lobe.kind == lobe_kind::NULL {
        return null::sample(lobe, wi, u1, u2);
    }
    let local = Local::new(lobe, wi);
    if !local.valid {
        return BsdfSample::NONE;
    }
    let mut s = model_sample(lobe, data, local.wi, u1, u2);
    if s.pdf <= 0.0 {
        return BsdfSample::NONE;
    }
    if lobe.has_frame {
        let outer = lobe.frame.to_world(s.wo);
        if !same_side(outer, s.wo) {
            return BsdfSample::NONE;
        }
        s.wo = outer;
        s.weight *= shadowing(lobe, wi, outer);
    }
    if local.flip {
        s.wo.z = -s.wo.z;
    }
    s
}

/// `wi` in the frame of the lobe's model, and how it came there.
struct Local {
    wi: Vec3,
    flip: bool,
    valid: bool,
}

impl Local {
    #[inline]
    fn new(lobe: &Lobe, wi: Vec3) -> Local {
        let flip = wi.z < 0.0 && lobe.flags & lobe_flag::FLIP_BACK != 0;
        let mut local = Local {
            wi,
            flip,
            valid: is_active(lobe.flags, wi),
        };
        let outer = local.outer(wi);
        local.wi = local.enter(lobe, wi);
        local.valid = local.valid && same_side(outer, local.wi);
        local
    }

    /// After mirroring, before the perturbed frame.
    #[inline]
    fn outer(&self, w: Vec3) -> Vec3 {
        if self.flip {
            Vec3::new(w.x, w.y, -w.z)
        } else {
            w
        }
    }

    /// In the frame of the lobe's model.
    #[inline]
    fn enter(&self, lobe: &Lobe, w: Vec3) -> Vec3 {
        let outer = self.outer(w);
        if lobe.has_frame {
            lobe.frame.to_local(outer)
        } else {
            outer
        }
    }
}

/// The terminator term of a perturbed frame: on camera paths light comes along `wo`, on light paths along `wi`.
#[inline]
fn shadowing(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    if !lobe.has_frame {
        return 1.0;
    }
    let light = if lobe.mode == mode::RADIANCE { wo } else { wi };
    frame_map::terminator_shadowing(lobe.frame.n.z, light.z)
}

#[inline]
fn same_side(a: Vec3, b: Vec3) -> bool {
    a.z * b.z > 0.0
}

/// The value of the lobe's model in its own frame.
#[inline]
fn model_eval(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    match lobe.kind {
        lobe_kind::DIFFUSE => diffuse::eval(lobe, wi, wo),
        lobe_kind::ROUGH_CONDUCTOR => rough_conductor::eval(lobe, wi, wo),
        lobe_kind::ROUGH_DIELECTRIC => rough_dielectric::eval(lobe, wi, wo),
        lobe_kind::PLASTIC => plastic::eval(lobe, wi, wo),
        lobe_kind::ROUGH_PLASTIC => rough_plastic::eval(lobe, data, wi, wo),
        // Discrete directions have no value.
        _ => Vec3::ZERO,
    }
}

#[inline]
fn model_pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    match lobe.kind {
        lobe_kind::DIFFUSE => diffuse::pdf(lobe, wi, wo),
        lobe_kind::ROUGH_CONDUCTOR => rough_conductor::pdf(lobe, wi, wo),
        lobe_kind::ROUGH_DIELECTRIC => rough_dielectric::pdf(lobe, wi, wo),
        lobe_kind::PLASTIC => plastic::pdf(lobe, wi, wo),
        lobe_kind::ROUGH_PLASTIC => rough_plastic::pdf(lobe, data, wi, wo),
        _ => 0.0,
    }
}

#[inline]
fn model_sample(lobe: &Lobe, data: &[f32], wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    match lobe.kind {
        lobe_kind::DIFFUSE => diffuse::sample(lobe, wi, u1, u2),
        lobe_kind::CONDUCTOR => conductor::sample(lobe, wi, u1, u2),
        lobe_kind::ROUGH_CONDUCTOR => rough_conductor::sample(lobe, wi, u1, u2),
        lobe_kind::DIELECTRIC => dielectric::sample(lobe, wi, u1, u2),
        lobe_kind::THIN_DIELECTRIC => thin_dielectric::sample(lobe, wi, u1, u2),
        lobe_kind::ROUGH_DIELECTRIC => rough_dielectric::sample(lobe, wi, u1, u2),
        lobe_kind::PLASTIC => plastic::sample(lobe, wi, u1, u2),
        lobe_kind::ROUGH_PLASTIC => rough_plastic::sample(lobe, data, wi, u1, u2),
        lobe_kind::NULL => null::sample(lobe, wi, u1, u2),
        _ => BsdfSample::NONE,
    }
}

/// What the lobe reflects and transmits, roughly: an upper bound on its colour from its parameters, for choosing a lobe
/// and for the albedo layer. Exact for diffuse and null lobes.
#[inline]
pub fn albedo(lobe: &Lobe, _data: &[f32], wi: Vec3) -> Rgb {
    if !is_active(lobe.flags, wi) && lobe.kind != lobe_kind::NULL {
        return Vec3::ZERO;
    }
    match lobe.kind {
        lobe_kind::DIFFUSE => lobe.reflectance,
        lobe_kind::CONDUCTOR | lobe_kind::ROUGH_CONDUCTOR => {
            lobe.specular_reflectance * fresnel_conductor(wi.z, lobe.eta, lobe.k)
        }
        lobe_kind::PLASTIC | lobe_kind::ROUGH_PLASTIC => lobe.reflectance,
        lobe_kind::NULL => Vec3::ONE,
        _ => lobe.specular_reflectance.max(lobe.specular_transmittance),
    }
}

/// Relative probability of choosing the lobe: its weight in the material times the largest channel of its colour;
/// zero exactly where the lobe scatters nothing.
#[inline]
pub fn selection_weight(lobe: &Lobe, data: &[f32], wi: Vec3) -> f32 {
    let mut colour = albedo(lobe, data, wi).max_element();
    if lobe.kind == lobe_kind::PLASTIC || lobe.kind == lobe_kind::ROUGH_PLASTIC {
        colour = colour.max(lobe.specular_reflectance.max_element());
    }
    lobe.weight * colour
}

/// Events that a lobe of the kind can produce: bits of [`event`].
#[inline]
pub fn events(kind: u32) -> u32 {
    match kind {
        lobe_kind::DIFFUSE => event::REFLECTION | event::DIFFUSE,
        lobe_kind::CONDUCTOR => event::REFLECTION | event::DELTA,
        lobe_kind::ROUGH_CONDUCTOR => event::REFLECTION | event::GLOSSY,
        lobe_kind::DIELECTRIC | lobe_kind::THIN_DIELECTRIC => {
            event::REFLECTION | event::TRANSMISSION | event::DELTA
        }
        lobe_kind::ROUGH_DIELECTRIC => event::REFLECTION | event::TRANSMISSION | event::GLOSSY,
        lobe_kind::PLASTIC => event::REFLECTION | event::DELTA | event::DIFFUSE,
        lobe_kind::ROUGH_PLASTIC => event::REFLECTION | event::GLOSSY | event::DIFFUSE,
        _ => event::TRANSMISSION | event::DELTA | event::NULL,
    }
}
