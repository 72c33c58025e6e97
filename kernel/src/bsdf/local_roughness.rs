//! Local Beckmann roughness: the width of the Beckmann lobe that resembles a BSDF at one pair of directions.
//!
//! Holzschuch, Kaplanyan, Hanika and Dachsbacher 2016, "Estimating Local Beckmann Roughness for Complex BSDFs": with
//! `t = tan(theta_h)` the slope of the half vector, `f ~ k exp(-t^2 / sigma^2)` near the pair, so that
//! `sigma^2 = -2 t f / (df / dt)` (equation 3). The pole `cos^-4` of D and the cosines are slowly varying factors that
//! belong to `k`: D enters as the slope density `P = D cos^4` (with `cos^-4` left in, a Beckmann lobe of
//! `alpha^2 = 0.09` would return 0.109 at `t = 0.13`). sigma is a Beckmann alpha, not a standard deviation.
//!
//! A sum of lobes has `df / dt = sum of f_l / sigma_l^2 (-2 t)`: `1 / sigma^2` is the mean of the lobes' own, weighted by
//! their values at the pair. A lobe without a peak has zero, so that the roughness grows where a diffuse lobe dominates, as
//! the paper intends. Under coats the half vector's slope changes by refraction, and `1 / sigma^2` by the square of that
//! factor.
//!
//! Fall-backs: [`DIFFUSE_ROUGHNESS`] where nothing falls off with `t`; zero where only discrete directions exist; at
//! `t = 0`, where equation 3 is 0 / 0, its limit. Checked: alpha for Beckmann at every angle, `(alpha^2 + t^2) / 2` for
//! GGX, closed forms for Phong and the exponential power distribution, refraction by coats, and that differences agree with
//! the derivatives.

use super::lobe::{eval_cosine, inner_pair};
use super::{Bsdf, Lobe, coat_reflection, microfacet, model};
use crate::math::float::{abs, atan2, ln, safe_sqrt, sin_cos, sqr, sqrt};
use crate::math::luminance;
use crate::scene::{lobe_flag, lobe_kind};
use glam::Vec3;

/// The roughness of lobes without a peak.
pub const DIFFUSE_ROUGHNESS: f32 = 1e3;

/// Local roughness of a material at a pair of directions in the local frame of the surface point, a Beckmann alpha in
/// [[`microfacet::ALPHA_MIN`], [`DIFFUSE_ROUGHNESS`]], or zero for a material of discrete directions alone.
pub fn local_beckmann_roughness(bsdf: &Bsdf, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    if bsdf.lobe_count() == 1 && has_own_falloff(bsdf.lobe_at(0).kind) {
        // Its value at the pair weighs nothing but itself.
        return roughness_of_falloff(lobe_falloff(bsdf.lobe_at(0), data, wi, wo), 1.0);
    }
    let mut value = 0.0;
    let mut falloff = 0.0;
    for i in 0..bsdf.lobe_count() {
        let lobe = bsdf.lobe(i);
        let f = luminance(eval_cosine(&lobe, data, wi, wo)) * lobe.weight;
        if f > 0.0 {
            value += f;
            falloff += f * lobe_falloff(&lobe, data, wi, wo);
        }
    }
    if value <= 0.0 && bsdf.has_delta() && !bsdf.has_smooth() {
        return 0.0;
    }
    roughness_of_falloff(falloff, value)
}

/// Whether the fall-off of a lobe takes no value at the pair.
#[inline]
fn has_own_falloff(kind: u32) -> bool {
    matches!(
        kind,
        lobe_kind::ROUGH_CONDUCTOR
            | lobe_kind::ROUGH_DIELECTRIC
            | lobe_kind::DIFFUSE
            | lobe_kind::ROUGH_DIFFUSE
            | lobe_kind::MERL
            | lobe_kind::MEASURED
            | lobe_kind::DIFFRACTING_CONDUCTOR
    )
}

/// `1 / sigma^2` of one lobe at a pair where it is not zero.
pub fn lobe_falloff(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    let pair = inner_pair(lobe, data, wi, wo);
    let (i, o) = (pair.wi, pair.wo);
    if !pair.valid {
        return 0.0;
    }
    let uncoated = match lobe.kind {
        lobe_kind::ROUGH_CONDUCTOR | lobe_kind::ROUGH_COAT => normal_falloff(lobe, i + o),
        lobe_kind::ROUGH_DIELECTRIC => {
            let eta = super::fresnel::relative_eta(i.z, lobe.eta.x);
            let transmitted = i.z * o.z < 0.0;
            normal_falloff(lobe, i + o * if transmitted { eta } else { 1.0 })
        }
        lobe_kind::ROUGH_PLASTIC => {
            // The base is flat: only the coating's share of the value falls off.
            let whole = luminance(model::eval(lobe, data, i, o));
            let share = luminance(coat_reflection::eval(lobe, i, o)) / whole.max(f32::MIN_POSITIVE);
            normal_falloff(lobe, i + o) * share.min(1.0)
        }
        lobe_kind::DIFFUSE
        | lobe_kind::ROUGH_DIFFUSE
        | lobe_kind::PLASTIC
        | lobe_kind::DIFFUSE_TRANSMISSION
        | lobe_kind::PRINCIPLED_DIFFUSE
        | lobe_kind::SHEEN
        | lobe_kind::HANRAHAN_KRUEGER => 0.0,
        lobe_kind::SCHLICK_REFLECTION => normal_falloff(lobe, i + o),
        // The half vector of the reflection that the sheet mirrors to its other side.
        lobe_kind::THIN_TRANSMISSION => {
            normal_falloff(lobe, Vec3::new(i.x + o.x, i.y + o.y, abs(i.z) + abs(o.z)))
        }
        // Measured and tabulated models.
        _ => falloff_by_differences(|i, o| luminance(model::eval(lobe, data, i, o)), i, o),
    };
    uncoated * sqr(slope_through_coats(lobe, wi, wo, i, o))
}

/// `1 / sigma^2` of the lobe's microfacets at the half vector along `h`, of either orientation.
#[inline]
fn normal_falloff(lobe: &Lobe, h: Vec3) -> f32 {
    let m = h.normalize_or_zero();
    let m = if m.z < 0.0 { -m } else { m };
    let alpha_squared = lobe.microfacets().local_alpha_squared(m);
    1.0 / alpha_squared.max(1e-12)
}

/// Slope of the half vector below the coats over that above: tangential components shrink by the index, and the
/// directions steepen.
#[inline]
fn slope_through_coats(lobe: &Lobe, wi: Vec3, wo: Vec3, i: Vec3, o: Vec3) -> f32 {
    if lobe.coat_count == 0 {
        return 1.0;
    }
    let mut eta = 1.0;
    for k in 0..lobe.coat_count as usize {
        eta *= lobe.coats[k].eta;
    }
    // Mirroring to the front changes both signs; a perturbed frame matters where the coats follow it.
    let (mut above_i, mut above_o) = (wi, wo);
    if lobe.has_frame && lobe.flags & lobe_flag::COATS_OUTSIDE_FRAME == 0 {
        above_i = lobe.frame.to_local(wi);
        above_o = lobe.frame.to_local(wo);
    }
    abs(above_i.z + above_o.z) / (eta * abs(i.z + o.z)).max(1e-6)
}

/// `1 / sigma^2` of a reflectance given by its values, for models without a derivative: `value(wi, wo)` is the BSDF
/// without a cosine, both directions above the surface.
///
/// The pair is turned rigidly in the plane of the normal and the half vector, so that the difference angle stays, to
/// half vectors around its own; `value cos_i cos_o cos_h^4` serves as the slope density. The chord between two slopes,
/// `(ln g(t1) - ln g(t2)) / (t2^2 - t1^2)`, is exact for a Beckmann lobe however far they are apart. The step is a tenth of
/// the angle and at least a quarter of a degree, which spans a bin of measured data. Zero where the value does not
/// fall.
pub fn falloff_by_differences(value: impl Fn(Vec3, Vec3) -> f32, wi: Vec3, wo: Vec3) -> f32 {
    let h = (wi + wo).normalize_or_zero();
    if h.z <= 0.0 {
        return 0.0;
    }
    let across = safe_sqrt(h.x * h.x + h.y * h.y);
    let theta = atan2(across, h.z);
    // The axis that tilts z towards the half vector.
    let (x, y) = if across > 1e-6 {
        (h.x / across, h.y / across)
    } else {
        (1.0, 0.0)
    };
    let axis = Vec3::new(-y, x, 0.0);
    let step = (0.1 * theta).max(SMALLEST_STEP);
    let low = if theta > step { -step } else { -theta };
    let (t1, g1) = turned(&value, wi, wo, axis, low, theta);
    let (t2, g2) = turned(&value, wi, wo, axis, step, theta);
    // A turned direction may leave the hemisphere: then one side is enough.
    let unturned = || turned(&value, wi, wo, axis, 0.0, theta);
    let (ta, ga) = if g1 > 0.0 { (t1, g1) } else { unturned() };
    let (tb, gb) = if g2 > 0.0 { (t2, g2) } else { unturned() };
    let spread = tb * tb - ta * ta;
    if !(ga > gb && gb > 0.0 && spread > 1e-12) {
        return 0.0;
    }
    (ln(ga) - ln(gb)) / spread
}

/// A quarter of a degree.
const SMALLEST_STEP: f32 = 0.004_4;

/// Slope of the half vector after turning both directions by `angle`, and the value there instead of the slope density.
#[inline]
fn turned(
    value: &impl Fn(Vec3, Vec3) -> f32,
    wi: Vec3,
    wo: Vec3,
    axis: Vec3,
    angle: f32,
    theta: f32,
) -> (f32, f32) {
    let (s, c) = sin_cos(angle);
    let (i, o) = (rotate(wi, axis, s, c), rotate(wo, axis, s, c));
    let (sin_h, cos_h) = sin_cos(theta + angle);
    if i.z <= 0.0 || o.z <= 0.0 || cos_h <= 1e-4 {
        return (0.0, 0.0);
    }
    let g = value(i, o) * i.z * o.z * sqr(cos_h * cos_h);
    (sin_h / cos_h, g)
}

/// `w` turned about a unit axis (Rodrigues' formula).
#[inline]
fn rotate(w: Vec3, axis: Vec3, sin: f32, cos: f32) -> Vec3 {
    w * cos + axis.cross(w) * sin + axis * (axis.dot(w) * (1.0 - cos))
}

/// `sqrt(value / falloff)` within the limits.
#[inline]
fn roughness_of_falloff(falloff: f32, value: f32) -> f32 {
    const SMALLEST: f32 = 1.0 / (DIFFUSE_ROUGHNESS * DIFFUSE_ROUGHNESS);
    // Also where both vanish.
    if !(falloff > SMALLEST * value) {
        return DIFFUSE_ROUGHNESS;
    }
    sqrt(value / falloff).max(microfacet::ALPHA_MIN)
}
