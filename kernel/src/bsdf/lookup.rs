//! A material's records at a surface point: lobes with their parameters and weights looked up.
//!
//! A parameter is its value times the texture at the point, if it has one; roughnesses and exponents take a texture's
//! luminance. A lobe's weight in the material is the product of its mixing factors, each clamped to [0, 1].

use super::lobe::{is_flipped, mirrored};
use super::{Coat, Lobe, clearcoat, frame_map, microfacet, rough_transmittance};
use crate::math::{Rgb, float, luminance, vec3};
use crate::scene::{
    CoatRecord, LobeRecord, MAX_COATS, NONE, SurfacePoint, Tables, distribution, features,
    lobe_flag, lobe_kind,
    texture::{eval_at_point, eval_rgb, eval_scalar},
};
use glam::{Vec2, Vec3};

/// [`super::Bsdf::null_transmittance`] of the material of `point`, which depends on no direction, without the other lobes.
#[inline]
pub fn null_transmittance(tables: &Tables<'_>, point: &SurfacePoint) -> Rgb {
    if point.material == NONE {
        return Vec3::ZERO;
    }
    if !tables.has(features::lobe(lobe_kind::NULL)) {
        return Vec3::ZERO;
    }
    let material = &tables.materials[point.material as usize];
    let mut sum = 0.0;
    for i in 0..material.lobe_count {
        let record = &tables.lobes[(material.first_lobe + i) as usize];
        if record.kind == lobe_kind::NULL {
            sum += weight(tables, record, point);
        }
    }
    Vec3::splat(float::abs(sum).min(1.0))
}

/// Product of a lobe's mixing factors.
#[inline]
pub(super) fn weight(tables: &Tables<'_>, record: &LobeRecord, point: &SurfacePoint) -> f32 {
    let mut product = 1.0;
    if !tables.has(features::FACTORS) {
        return product;
    }
    for i in 0..record.factor_count {
        let factor = &tables.factors[(record.first_factor + i) as usize];
        let value = eval_scalar(tables, &factor.parameter, point)
            .max(0.0)
            .min(1.0);
        product *= if factor.complement != 0 {
            1.0 - value
        } else {
            value
        };
    }
    product
}

/// Sets `lobe` to the record's lobe, with the parameters that its kind has; its weight is left zero.
pub(crate) fn fill_lobe(
    lobe: &mut Lobe,
    tables: &Tables<'_>,
    record: &LobeRecord,
    point: &SurfacePoint,
    wi: Vec3,
    mode: u32,
) {
    *lobe = Lobe::NONE;
    lobe.kind = record.kind;
    lobe.flags = record.flags;
    lobe.mode = mode;
    if record.kind == lobe_kind::NULL {
        return;
    }
    if tables.has(features::COATS) {
        lobe.coat_count = record.coat_count.min(MAX_COATS as u32);
        for i in 0..lobe.coat_count as usize {
            lobe.coats[i] = coat_at(tables, &record.coats[i], point);
        }
    }
    if tables.has(features::FRAME_MAPS) && record.frame != NONE {
        // For two-sided lobes wi is mirrored to the front.
        let wi = mirrored(is_flipped(lobe, wi), wi);
        lobe.frame = frame_map::perturbed_frame(tables, record.frame, point, wi);
        lobe.has_frame = true;
    }
    // Shaders look up the parameters of all kinds together, see `parameters`.
    #[cfg(not(target_arch = "spirv"))]
    if record.kind == lobe_kind::DIFFUSE {
        lobe.reflectance = eval_rgb(tables, &record.reflectance, point);
        return;
    }
    let p = parameters(tables, record, point);
    #[cfg(target_arch = "spirv")]
    if record.kind == lobe_kind::DIFFUSE {
        lobe.reflectance = p[0];
        return;
    }
    set_parameters(lobe, record, &p);
    if tables.has(features::lobe(lobe_kind::ROUGH_PLASTIC))
        && record.kind == lobe_kind::ROUGH_PLASTIC
        && record.table != NONE
        && record.table_rows > 1
    {
        lobe.internal_reflectance = rough_transmittance::internal_reflectance(
            tables.data,
            record.table,
            record.table_rows,
            lobe.alpha.x,
        );
    }
}

/// Takes what the record's kind reads of its parameters, which are in the order of [`parameters`].
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn set_parameters(lobe: &mut Lobe, record: &LobeRecord, p: &[Rgb; 9]) {
    if lobe.kind == lobe_kind::ROUGH_DIFFUSE {
        lobe.reflectance = p[0];
        lobe.alpha = Vec2::splat(p[6].x);
        return;
    }
    lobe.distribution = record.distribution;
    if lobe.kind >= lobe_kind::PHONG {
        set_later_parameters(lobe, p);
        return;
    }
    if record.distribution == distribution::EXPONENTIAL_POWER {
        lobe.exponent = p[8].x;
    }
    lobe.table = record.table;
    lobe.table_rows = record.table_rows;
    lobe.internal_reflectance = record.internal_reflectance;
    if lobe.kind == lobe_kind::MERL || lobe.kind == lobe_kind::MEASURED {
        return;
    }
    lobe.specular_reflectance = p[1];
    lobe.eta = p[3];
    match lobe.kind {
        lobe_kind::PLASTIC | lobe_kind::ROUGH_PLASTIC => {
            lobe.reflectance = p[0];
            lobe.optical_depth = p[5];
        }
        lobe_kind::COAT | lobe_kind::ROUGH_COAT => {}
        lobe_kind::CONDUCTOR | lobe_kind::ROUGH_CONDUCTOR | lobe_kind::DIFFRACTING_CONDUCTOR => {
            lobe.k = p[4];
        }
        _ => {
            lobe.specular_transmittance = if lobe.flags & lobe_flag::ROOT_TRANSMITTANCE != 0 {
                square_root(p[2])
            } else {
                p[2]
            }
        }
    }
    if lobe.kind == lobe_kind::ROUGH_CONDUCTOR
        || lobe.kind == lobe_kind::DIFFRACTING_CONDUCTOR
        || lobe.kind == lobe_kind::ROUGH_DIELECTRIC
        || lobe.kind == lobe_kind::ROUGH_PLASTIC
        || lobe.kind == lobe_kind::ROUGH_COAT
    {
        lobe.alpha = roughness(lobe.flags, p[6].x, p[7].x);
    }
}

/// [`set_parameters`] of the kinds from [`lobe_kind::PHONG`] on.
#[inline]
fn set_later_parameters(lobe: &mut Lobe, p: &[Rgb; 9]) {
    lobe.reflectance = p[0];
    lobe.specular_reflectance = p[1];
    lobe.specular_transmittance = p[2];
    lobe.eta = p[3];
    lobe.exponent = p[8].x;
    lobe.alpha = if lobe.kind == lobe_kind::PRINCIPLED_DIFFUSE {
        Vec2::splat(p[6].x)
    } else if lobe.kind == lobe_kind::CLEARCOAT {
        Vec2::splat(clearcoat::width(p[8].x))
    } else {
        roughness(lobe.flags, p[6].x, p[7].x)
    };
}

/// The widths of microfacets, from the two parameters of a record.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn roughness(flags: u32, u: f32, v: f32) -> Vec2 {
    let mut alpha = Vec2::new(u, v);
    if flags & lobe_flag::PRINCIPLED_ROUGHNESS != 0 {
        // Burley 2012, section 5.4: the width is the square of the roughness, stretched by the anisotropy.
        let aspect = float::sqrt(1.0 - 0.9 * v.max(0.0).min(1.0));
        alpha = Vec2::new(u * u / aspect, u * u * aspect).max(Vec2::splat(LEAST_PRINCIPLED_ALPHA));
    }
    microfacet::clamp_alpha(alpha)
}

/// Smallest width of the principled model.
const LEAST_PRINCIPLED_ALPHA: f32 = 1e-3;

#[inline]
fn square_root(c: Rgb) -> Rgb {
    Vec3::new(
        float::safe_sqrt(c.x),
        float::safe_sqrt(c.y),
        float::safe_sqrt(c.z),
    )
}

/// The lobe of a record without coats, perturbed frame and textures, whose `kind` callers know.
#[cfg(not(target_arch = "spirv"))]
#[inline(always)]
pub(crate) fn plain_lobe(record: &LobeRecord, kind: u32) -> Lobe {
    let mut lobe = Lobe {
        kind,
        flags: record.flags,
        weight: 1.0,
        ..Lobe::NONE
    };
    if kind == lobe_kind::DIFFUSE {
        lobe.reflectance = vec3(record.reflectance.value);
        return lobe;
    }
    set_parameters(&mut lobe, record, &constants(record));
    lobe
}

/// The record's parameters at the point: reflectance, specular reflectance and transmittance, eta, k, optical depth, and
/// in every channel the two roughnesses and the exponent. One loop over all, because shader compilers copy the texture
/// lookup to every call.
#[inline]
fn parameters(tables: &Tables<'_>, record: &LobeRecord, point: &SurfacePoint) -> [Rgb; 9] {
    let mut values = constants(record);
    let textures = [
        record.reflectance.texture,
        record.specular_reflectance.texture,
        record.specular_transmittance.texture,
        record.eta.texture,
        record.k.texture,
        record.optical_depth.texture,
        record.alpha_u.texture,
        record.alpha_v.texture,
        record.exponent.texture,
    ];
    for i in 0..9 {
        if tables.has(features::TEXTURES) && textures[i] != NONE {
            let texel = eval_at_point(tables, textures[i], point);
            values[i] *= if i < 6 {
                texel
            } else {
                Vec3::splat(luminance(texel))
            };
        }
    }
    values
}

/// The record's parameters without their textures, in the order of [`parameters`].
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn constants(record: &LobeRecord) -> [Rgb; 9] {
    [
        vec3(record.reflectance.value),
        vec3(record.specular_reflectance.value),
        vec3(record.specular_transmittance.value),
        vec3(record.eta.value),
        vec3(record.k.value),
        vec3(record.optical_depth.value),
        Vec3::splat(record.alpha_u.value),
        Vec3::splat(record.alpha_v.value),
        Vec3::splat(record.exponent.value),
    ]
}

/// A coat with its parameters looked up.
#[inline]
fn coat_at(tables: &Tables<'_>, record: &CoatRecord, point: &SurfacePoint) -> Coat {
    let mut coat = Coat::NONE;
    coat.eta = record.eta;
    coat.optical_depth = eval_rgb(tables, &record.optical_depth, point);
    coat.table = record.table;
    coat.table_rows = record.table_rows;
    if record.table != NONE && record.table_rows > 1 {
        coat.alpha = eval_scalar(tables, &record.alpha, point);
    }
    coat
}
