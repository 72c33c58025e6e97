//! The choice of the scattering model by a lobe's kind.
//!
//! Directions are in the frame of the model, below the lobe's coats; [`super::lobe`] transforms them. Every kind has its own
//! file beside this one; a specular model has neither value nor density.

use super::fresnel::{fresnel_conductor, fresnel_dielectric};
use super::{
    BsdfSample, Lobe, clearcoat, coat_reflection, conductor, dielectric, diffracting_conductor,
    diffuse, diffuse_transmission, event, hanrahan_krueger, measured, merl, phong, plastic,
    principled_diffuse, rough_conductor, rough_dielectric, rough_diffuse, rough_plastic,
    schlick_reflection, sheen, thin_dielectric, thin_transmission, ward,
};
use crate::math::{Rgb, float};
use crate::scene::{features, lobe_kind};
use glam::{Vec2, Vec3};

/// The BSDF without a cosine.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn eval(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    match lobe.kind {
        lobe_kind::DIFFUSE if lobe.may_be(features::lobe(lobe_kind::DIFFUSE)) => {
            diffuse::eval(lobe, wi, wo)
        }
        lobe_kind::ROUGH_CONDUCTOR if lobe.may_be(features::lobe(lobe_kind::ROUGH_CONDUCTOR)) => {
            rough_conductor::eval(lobe, wi, wo)
        }
        lobe_kind::ROUGH_DIELECTRIC if lobe.may_be(features::lobe(lobe_kind::ROUGH_DIELECTRIC)) => {
            rough_dielectric::eval(lobe, wi, wo)
        }
        lobe_kind::PLASTIC if lobe.may_be(features::lobe(lobe_kind::PLASTIC)) => {
            plastic::eval(lobe, wi, wo)
        }
        lobe_kind::ROUGH_PLASTIC if lobe.may_be(features::lobe(lobe_kind::ROUGH_PLASTIC)) => {
            rough_plastic::eval(lobe, data, wi, wo)
        }
        lobe_kind::ROUGH_COAT if lobe.may_be(features::lobe(lobe_kind::ROUGH_COAT)) => {
            coat_reflection::eval(lobe, wi, wo)
        }
        lobe_kind::ROUGH_DIFFUSE if lobe.may_be(features::lobe(lobe_kind::ROUGH_DIFFUSE)) => {
            rough_diffuse::eval(lobe, wi, wo)
        }
        lobe_kind::MERL if lobe.may_be(features::lobe(lobe_kind::MERL)) => {
            merl::eval(lobe, data, wi, wo)
        }
        lobe_kind::MEASURED if lobe.may_be(features::lobe(lobe_kind::MEASURED)) => {
            measured::eval(lobe, data, wi, wo)
        }
        lobe_kind::DIFFRACTING_CONDUCTOR
            if lobe.may_be(features::lobe(lobe_kind::DIFFRACTING_CONDUCTOR)) =>
        {
            diffracting_conductor::eval(lobe, data, wi, wo)
        }
        _ if lobe.kind >= lobe_kind::PHONG && lobe.may_be(features::lobe(lobe_kind::PHONG)) => {
            eval_later(lobe, wi, wo)
        }
        // Discrete directions have no value.
        _ => Vec3::ZERO,
    }
}

/// Density of [`sample`] per solid angle.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    match lobe.kind {
        lobe_kind::DIFFUSE if lobe.may_be(features::lobe(lobe_kind::DIFFUSE)) => {
            diffuse::pdf(lobe, wi, wo)
        }
        lobe_kind::ROUGH_CONDUCTOR if lobe.may_be(features::lobe(lobe_kind::ROUGH_CONDUCTOR)) => {
            rough_conductor::pdf(lobe, wi, wo)
        }
        lobe_kind::ROUGH_DIELECTRIC if lobe.may_be(features::lobe(lobe_kind::ROUGH_DIELECTRIC)) => {
            rough_dielectric::pdf(lobe, wi, wo)
        }
        lobe_kind::PLASTIC if lobe.may_be(features::lobe(lobe_kind::PLASTIC)) => {
            plastic::pdf(lobe, wi, wo)
        }
        lobe_kind::ROUGH_PLASTIC if lobe.may_be(features::lobe(lobe_kind::ROUGH_PLASTIC)) => {
            rough_plastic::pdf(lobe, data, wi, wo)
        }
        lobe_kind::ROUGH_COAT if lobe.may_be(features::lobe(lobe_kind::ROUGH_COAT)) => {
            coat_reflection::pdf(lobe, wi, wo)
        }
        lobe_kind::ROUGH_DIFFUSE if lobe.may_be(features::lobe(lobe_kind::ROUGH_DIFFUSE)) => {
            rough_diffuse::pdf(lobe, wi, wo)
        }
        lobe_kind::MERL if lobe.may_be(features::lobe(lobe_kind::MERL)) => {
            merl::pdf(lobe, data, wi, wo)
        }
        lobe_kind::MEASURED if lobe.may_be(features::lobe(lobe_kind::MEASURED)) => {
            measured::pdf(lobe, data, wi, wo)
        }
        lobe_kind::DIFFRACTING_CONDUCTOR
            if lobe.may_be(features::lobe(lobe_kind::DIFFRACTING_CONDUCTOR)) =>
        {
            diffracting_conductor::pdf(lobe, data, wi, wo)
        }
        _ if lobe.kind >= lobe_kind::PHONG && lobe.may_be(features::lobe(lobe_kind::PHONG)) => {
            pdf_later(lobe, wi, wo)
        }
        _ => 0.0,
    }
}

/// [`eval`] of the kinds from [`lobe_kind::PHONG`] on.
#[inline]
fn eval_later(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    match lobe.kind {
        lobe_kind::PHONG => phong::eval(lobe, wi, wo),
        lobe_kind::WARD => ward::eval(lobe, wi, wo),
        lobe_kind::DIFFUSE_TRANSMISSION => diffuse_transmission::eval(lobe, wi, wo),
        lobe_kind::PRINCIPLED_DIFFUSE => principled_diffuse::eval(lobe, wi, wo),
        lobe_kind::SHEEN => sheen::eval(lobe, wi, wo),
        lobe_kind::SCHLICK_REFLECTION => schlick_reflection::eval(lobe, wi, wo),
        lobe_kind::CLEARCOAT => clearcoat::eval(lobe, wi, wo),
        lobe_kind::THIN_TRANSMISSION => thin_transmission::eval(lobe, wi, wo),
        lobe_kind::HANRAHAN_KRUEGER => hanrahan_krueger::eval(lobe, wi, wo),
        _ => Vec3::ZERO,
    }
}

/// [`pdf`] of the kinds from [`lobe_kind::PHONG`] on.
#[inline]
fn pdf_later(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    match lobe.kind {
        lobe_kind::PHONG => phong::pdf(lobe, wi, wo),
        lobe_kind::WARD => ward::pdf(lobe, wi, wo),
        lobe_kind::DIFFUSE_TRANSMISSION => diffuse_transmission::pdf(lobe, wi, wo),
        lobe_kind::PRINCIPLED_DIFFUSE => principled_diffuse::pdf(lobe, wi, wo),
        lobe_kind::SHEEN => sheen::pdf(lobe, wi, wo),
        lobe_kind::SCHLICK_REFLECTION => schlick_reflection::pdf(lobe, wi, wo),
        lobe_kind::CLEARCOAT => clearcoat::pdf(lobe, wi, wo),
        lobe_kind::THIN_TRANSMISSION => thin_transmission::pdf(lobe, wi, wo),
        lobe_kind::HANRAHAN_KRUEGER => hanrahan_krueger::pdf(lobe, wi, wo),
        _ => 0.0,
    }
}

/// [`sample_with_normal`] of the kinds from [`lobe_kind::PHONG`] on.
#[inline]
fn sample_later(
    lobe: &Lobe,
    wi: Vec3,
    u1: f32,
    u2: Vec2,
    normal: impl FnOnce() -> Vec3,
) -> BsdfSample {
    match lobe.kind {
        lobe_kind::PHONG => phong::sample(lobe, wi, u1, u2),
        lobe_kind::WARD => ward::sample(lobe, wi, u1, u2),
        lobe_kind::DIFFUSE_TRANSMISSION => diffuse_transmission::sample(lobe, wi, u1, u2),
        lobe_kind::PRINCIPLED_DIFFUSE => principled_diffuse::sample(lobe, wi, u1, u2),
        lobe_kind::SHEEN => sheen::sample(lobe, wi, u1, u2),
        lobe_kind::SCHLICK_REFLECTION => schlick_reflection::sample(lobe, wi, normal()),
        lobe_kind::CLEARCOAT => clearcoat::sample(lobe, wi, u1, u2),
        lobe_kind::THIN_TRANSMISSION => thin_transmission::sample(lobe, wi, normal()),
        lobe_kind::HANRAHAN_KRUEGER => hanrahan_krueger::sample(lobe, wi, u1, u2),
        _ => BsdfSample::NONE,
    }
}

/// The kinds with microfacets, as features.
#[cfg(target_arch = "spirv")]
const MICROFACET_KINDS: u32 = features::lobe(lobe_kind::ROUGH_CONDUCTOR)
    | features::lobe(lobe_kind::ROUGH_DIELECTRIC)
    | features::lobe(lobe_kind::ROUGH_PLASTIC)
    | features::lobe(lobe_kind::ROUGH_COAT)
    | features::lobe(lobe_kind::DIFFRACTING_CONDUCTOR)
    | features::lobe(lobe_kind::SCHLICK_REFLECTION);

/// The kinds, as features, that leave value and density of a sample to [`super::Bsdf::mix`], see [`BsdfSample`].
#[cfg(target_arch = "spirv")]
pub const UNWEIGHTED_KINDS: u32 = features::lobe(lobe_kind::ROUGH_PLASTIC)
    | features::lobe(lobe_kind::ROUGH_COAT)
    | features::lobe(lobe_kind::MERL)
    | features::lobe(lobe_kind::DIFFRACTING_CONDUCTOR)
    | features::lobe(lobe_kind::PHONG);

/// The microfacet normal that a rough lobe draws with `u2`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(super) fn sample_facet_normal(lobe: &Lobe, wi: Vec3, u2: Vec2) -> Vec3 {
    let facets = lobe.microfacets();
    if lobe.samples_all_normals() {
        facets.sample_normal(u2)
    } else {
        facets.sample_visible_normal(rough_dielectric::to_upper_hemisphere(wi), u2)
    }
}

/// A direction in the model's frame with weight f |cos| / pdf.
#[inline]
pub fn sample(lobe: &Lobe, data: &[f32], wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    // A shader compiler copies functions to their callers: it gets a single one to the sampling of normals.
    #[cfg(target_arch = "spirv")]
    {
        let m =
            if lobe.may_be(MICROFACET_KINDS) && MICROFACET_KINDS & features::lobe(lobe.kind) != 0 {
                sample_facet_normal(lobe, wi, u2)
            } else {
                Vec3::Z
            };
        sample_with_normal(lobe, data, wi, u1, u2, || m)
    }
    #[cfg(not(target_arch = "spirv"))]
    sample_with_normal(lobe, data, wi, u1, u2, || sample_facet_normal(lobe, wi, u2))
}

/// [`sample`] with the microfacet normal of rough models drawn by `normal`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample_with_normal(
    lobe: &Lobe,
    data: &[f32],
    wi: Vec3,
    u1: f32,
    u2: Vec2,
    normal: impl FnOnce() -> Vec3,
) -> BsdfSample {
    match lobe.kind {
        lobe_kind::DIFFUSE if lobe.may_be(features::lobe(lobe_kind::DIFFUSE)) => {
            diffuse::sample(lobe, wi, u1, u2)
        }
        lobe_kind::CONDUCTOR if lobe.may_be(features::lobe(lobe_kind::CONDUCTOR)) => {
            conductor::sample(lobe, wi, u1, u2)
        }
        lobe_kind::ROUGH_CONDUCTOR if lobe.may_be(features::lobe(lobe_kind::ROUGH_CONDUCTOR)) => {
            rough_conductor::sample(lobe, wi, normal())
        }
        lobe_kind::DIELECTRIC if lobe.may_be(features::lobe(lobe_kind::DIELECTRIC)) => {
            dielectric::sample(lobe, wi, u1, u2)
        }
        lobe_kind::THIN_DIELECTRIC if lobe.may_be(features::lobe(lobe_kind::THIN_DIELECTRIC)) => {
            thin_dielectric::sample(lobe, wi, u1, u2)
        }
        lobe_kind::ROUGH_DIELECTRIC if lobe.may_be(features::lobe(lobe_kind::ROUGH_DIELECTRIC)) => {
            rough_dielectric::sample(lobe, wi, u1, normal())
        }
        lobe_kind::PLASTIC if lobe.may_be(features::lobe(lobe_kind::PLASTIC)) => {
            plastic::sample(lobe, wi, u1, u2)
        }
        lobe_kind::ROUGH_PLASTIC if lobe.may_be(features::lobe(lobe_kind::ROUGH_PLASTIC)) => {
            rough_plastic::sample(lobe, data, wi, u1, u2, normal)
        }
        lobe_kind::COAT if lobe.may_be(features::lobe(lobe_kind::COAT)) => {
            coat_reflection::sample_smooth(lobe, wi)
        }
        lobe_kind::ROUGH_COAT if lobe.may_be(features::lobe(lobe_kind::ROUGH_COAT)) => {
            coat_reflection::sample(lobe, wi, normal())
        }
        lobe_kind::MERL if lobe.may_be(features::lobe(lobe_kind::MERL)) => {
            merl::sample(lobe, data, wi, u1, u2)
        }
        lobe_kind::MEASURED if lobe.may_be(features::lobe(lobe_kind::MEASURED)) => {
            measured::sample(lobe, data, wi, u1, u2)
        }
        lobe_kind::ROUGH_DIFFUSE if lobe.may_be(features::lobe(lobe_kind::ROUGH_DIFFUSE)) => {
            rough_diffuse::sample(lobe, wi, u1, u2)
        }
        lobe_kind::DIFFRACTING_CONDUCTOR
            if lobe.may_be(features::lobe(lobe_kind::DIFFRACTING_CONDUCTOR)) =>
        {
            diffracting_conductor::sample(lobe, data, wi, u1, u2, normal)
        }
        _ if lobe.kind >= lobe_kind::PHONG && lobe.may_be(features::lobe(lobe_kind::PHONG)) => {
            sample_later(lobe, wi, u1, u2, normal)
        }
        _ => BsdfSample::NONE,
    }
}

/// What the model reflects and transmits, roughly; see [`super::lobe::albedo`].
#[inline]
pub fn albedo(lobe: &Lobe, data: &[f32], wi: Vec3) -> Rgb {
    match lobe.kind {
        lobe_kind::DIFFUSE | lobe_kind::ROUGH_DIFFUSE
            if lobe.may_be(
                features::lobe(lobe_kind::DIFFUSE) | features::lobe(lobe_kind::ROUGH_DIFFUSE),
            ) =>
        {
            lobe.reflectance
        }
        lobe_kind::CONDUCTOR | lobe_kind::ROUGH_CONDUCTOR | lobe_kind::DIFFRACTING_CONDUCTOR
            if lobe.may_be(
                features::lobe(lobe_kind::CONDUCTOR)
                    | features::lobe(lobe_kind::ROUGH_CONDUCTOR)
                    | features::lobe(lobe_kind::DIFFRACTING_CONDUCTOR),
            ) =>
        {
            lobe.specular_reflectance * fresnel_conductor(wi.z, lobe.eta, lobe.k)
        }
        lobe_kind::PLASTIC | lobe_kind::ROUGH_PLASTIC
            if lobe.may_be(
                features::lobe(lobe_kind::PLASTIC) | features::lobe(lobe_kind::ROUGH_PLASTIC),
            ) =>
        {
            lobe.reflectance
        }
        lobe_kind::NULL if lobe.may_be(features::lobe(lobe_kind::NULL)) => Vec3::ONE,
        // Cells are coarse: some direction may reflect although the albedo of its cell is zero.
        lobe_kind::MERL if lobe.may_be(features::lobe(lobe_kind::MERL)) => {
            merl::albedo(lobe, data, float::abs(wi.z))
                .max(Vec3::splat(1e-3))
                .min(Vec3::ONE)
        }
        lobe_kind::MEASURED if lobe.may_be(features::lobe(lobe_kind::MEASURED)) => {
            measured::albedo(lobe, data, float::abs(wi.z))
                .max(Vec3::splat(1e-3))
                .min(Vec3::ONE)
        }
        lobe_kind::COAT | lobe_kind::ROUGH_COAT
            if lobe.may_be(
                features::lobe(lobe_kind::COAT) | features::lobe(lobe_kind::ROUGH_COAT),
            ) =>
        {
            lobe.specular_reflectance * coat_share(lobe, wi)
        }
        _ if lobe.kind >= lobe_kind::PHONG => match lobe.kind {
            lobe_kind::PRINCIPLED_DIFFUSE => lobe.reflectance,
            lobe_kind::SHEEN => sheen::color(lobe).min(Vec3::ONE),
            // Black facets still reflect what grazes them.
            lobe_kind::SCHLICK_REFLECTION => schlick_reflection::fresnel(lobe, float::abs(wi.z))
                .max(lobe.specular_reflectance * 1e-3),
            lobe_kind::CLEARCOAT => {
                lobe.specular_reflectance * clearcoat::fresnel(float::abs(wi.z))
            }
            lobe_kind::DIFFUSE_TRANSMISSION | lobe_kind::THIN_TRANSMISSION => {
                lobe.specular_transmittance
            }
            lobe_kind::HANRAHAN_KRUEGER => hanrahan_krueger::albedo(lobe, wi),
            _ => lobe.specular_reflectance,
        },
        _ => lobe.specular_reflectance.max(lobe.specular_transmittance),
    }
}

/// Reflectance of a coat's surface seen along `wi`.
#[inline]
fn coat_share(lobe: &Lobe, wi: Vec3) -> f32 {
    let cos = if lobe.has_frame {
        lobe.frame.n.dot(wi)
    } else {
        wi.z
    };
    fresnel_dielectric(float::abs(cos), lobe.eta.x).0
}

/// Events that a lobe of the kind can produce: bits of [`event`].
#[inline]
pub fn events(kind: u32) -> u32 {
    match kind {
        lobe_kind::DIFFUSE
        | lobe_kind::ROUGH_DIFFUSE
        | lobe_kind::PRINCIPLED_DIFFUSE
        | lobe_kind::SHEEN => event::REFLECTION | event::DIFFUSE,
        lobe_kind::DIFFUSE_TRANSMISSION => event::TRANSMISSION | event::DIFFUSE,
        lobe_kind::THIN_TRANSMISSION => event::TRANSMISSION | event::GLOSSY,
        lobe_kind::HANRAHAN_KRUEGER => {
            event::REFLECTION | event::TRANSMISSION | event::GLOSSY | event::DELTA
        }
        lobe_kind::MERL
        | lobe_kind::MEASURED
        | lobe_kind::PHONG
        | lobe_kind::WARD
        | lobe_kind::SCHLICK_REFLECTION
        | lobe_kind::CLEARCOAT => event::REFLECTION | event::GLOSSY,
        lobe_kind::CONDUCTOR | lobe_kind::COAT => event::REFLECTION | event::DELTA,
        lobe_kind::ROUGH_CONDUCTOR | lobe_kind::ROUGH_COAT | lobe_kind::DIFFRACTING_CONDUCTOR => {
            event::REFLECTION | event::GLOSSY
        }
        lobe_kind::DIELECTRIC | lobe_kind::THIN_DIELECTRIC => {
            event::REFLECTION | event::TRANSMISSION | event::DELTA
        }
        lobe_kind::ROUGH_DIELECTRIC => event::REFLECTION | event::TRANSMISSION | event::GLOSSY,
        lobe_kind::PLASTIC => event::REFLECTION | event::DELTA | event::DIFFUSE,
        lobe_kind::ROUGH_PLASTIC => event::REFLECTION | event::GLOSSY | event::DIFFUSE,
        _ => event::TRANSMISSION | event::DELTA | event::NULL,
    }
}
