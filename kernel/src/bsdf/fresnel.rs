//! Fresnel reflectance of smooth boundaries, unpolarised, and the directions of reflection and refraction.
//!
//! Cosines are signed against the normal that points to the exterior: `cos_i < 0` arrives from the inside. A dielectric
//! is given by `eta`, interior over exterior index; [`relative_eta`] turns it into transmitted over incident. Domain:
//! `eta` in [1e-3, 1e3], clamped there; conductors `eta >= 0`, `k >= 0` relative to the exterior.
//!
//! The differences in numerator and denominator of the textbook formulas cancel at `eta` near 1 and at the critical
//! angle, so they are expanded here with Snell's law; tests compare with `f64` and check the limits, Stokes'
//! reciprocity `F(cos_i) = F(cos_t)`, and the closed form of the hemispherical mean.

use crate::math::Rgb;
use crate::math::float::{abs, safe_sqrt, sqr, sqrt, with_sign_of};
use glam::Vec3;

/// Index on the transmitted side over the index on the incident side, for light that arrives with `cos_i`.
#[inline]
pub fn relative_eta(cos_i: f32, eta: f32) -> f32 {
    let eta = eta.max(1e-3).min(1e3);
    if cos_i >= 0.0 { eta } else { 1.0 / eta }
}

/// Reflectance of a dielectric boundary and the signed cosine of the refracted direction.
///
/// `cos_t` has the opposite sign of `cos_i`. Total internal reflection gives `(1, 0)`; `eta == 1` gives `(0, -cos_i)`
/// at every angle.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn fresnel_dielectric(cos_i: f32, eta: f32) -> (f32, f32) {
    let e = relative_eta(cos_i, eta);
    let c = abs(cos_i).min(1.0);
    // e^2 - 1, exact to a rounding near e = 1.
    let e2m1 = (e - 1.0) * (e + 1.0);
    if e2m1 == 0.0 {
        return (0.0, with_sign_of(c, -cos_i));
    }
    // Snell: (e cos_t)^2 = e^2 - sin_i^2.
    let e_cos_t_squared = e2m1 + c * c;
    if e_cos_t_squared <= 0.0 {
        return (1.0, 0.0);
    }
    let t = (sqrt(e_cos_t_squared) / e).min(1.0);
    // r_s = (c - e t) / (c + e t) and r_p = (e c - t) / (e c + t), numerators multiplied out.
    let r_s = -e2m1 / sqr(c + e * t);
    let r_p = e2m1 * ((e * e + 1.0) * c * c - 1.0) / sqr(e * (e * c + t));
    let reflectance = (0.5 * (r_s * r_s + r_p * r_p)).min(1.0);
    (reflectance, with_sign_of(t, -cos_i))
}

/// Exact reflectance of a conductor with complex index `eta + i k` per channel; `cos_i` is taken without its sign.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn fresnel_conductor(cos_i: f32, eta: Vec3, k: Vec3) -> Rgb {
    Vec3::new(
        conductor_channel(cos_i, eta.x, k.x),
        conductor_channel(cos_i, eta.y, k.y),
        conductor_channel(cos_i, eta.z, k.z),
    )
}

/// [`fresnel_conductor`] of one channel (Born and Wolf, Principles of Optics, section 14.2, in real arithmetic).
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn conductor_channel(cos_i: f32, eta: f32, k: f32) -> f32 {
    let c = abs(cos_i).min(1.0);
    let c2 = c * c;
    let s2 = 1.0 - c2;
    // (a + i b)^2 = (eta + i k)^2 - sin^2
    let re = (eta - k) * (eta + k) - s2;
    let im = 2.0 * eta * k;
    let a2_b2 = sqrt(re * re + im * im);
    // a^2 = (|.| + re) / 2, without its cancellation where re < 0.
    let a2 = if re >= 0.0 {
        0.5 * (a2_b2 + re)
    } else {
        0.5 * im * im / (a2_b2 - re)
    };
    let two_a_c = 2.0 * safe_sqrt(a2) * c;
    let s_sum = a2_b2 + c2;
    let p_sum = c2 * a2_b2 + s2 * s2;
    let p_cross = two_a_c * s2;
    // Grazing incidence, or no index at all: the limit is total reflection.
    if s_sum + two_a_c <= 0.0 || p_sum + p_cross <= 0.0 {
        return 1.0;
    }
    let r_s = (s_sum - two_a_c) / (s_sum + two_a_c);
    let r_p = r_s * (p_sum - p_cross) / (p_sum + p_cross);
    (0.5 * (r_s + r_p)).max(0.0).min(1.0)
}

/// Reflectance of a dielectric boundary under uniform hemispherical illumination, `2 integral F(c) c dc`.
///
/// The light arrives on the side where `eta` is transmitted over incident: `fresnel_diffuse_reflectance(1.5)` is the
/// external mean of glass, 0.0918, and `fresnel_diffuse_reflectance(1.0 / 1.5)` its internal mean, 0.5963, which
/// plastics need. Absolute error below 1e-5 for `eta` in [1/3, 3] (closed form in `f64`). It costs about a hundred
/// Fresnel terms: call it when a scene is built.
pub fn fresnel_diffuse_reflectance(eta: f32) -> f32 {
    const INTERVALS: u32 = 128;
    let eta = eta.max(1e-3).min(1e3);
    let n = if eta < 1.0 { 1.0 / eta } else { eta };
    // Simpson's rule in t = sqrt(c): the integrand 4 t^3 F(t^2) has no steep end at grazing angles.
    let mut sum = 0.0;
    for i in 0..=INTERVALS {
        let t = i as f32 / INTERVALS as f32;
        let weight = if i == 0 || i == INTERVALS {
            1.0
        } else if i % 2 == 1 {
            4.0
        } else {
            2.0
        };
        sum += weight * 4.0 * t * t * t * fresnel_dielectric(t * t, n).0;
    }
    let external = sum / (3.0 * INTERVALS as f32);
    if eta < 1.0 {
        // Reciprocity of the flux: n^2 (1 - internal) = 1 - external.
        1.0 - (1.0 - external) / (n * n)
    } else {
        external
    }
}

/// `w` mirrored about the unit vector `m`.
#[inline]
pub fn reflect(w: Vec3, m: Vec3) -> Vec3 {
    m * (2.0 * w.dot(m)) - w
}

/// The refraction of `w` at the unit normal `m`: `cos_t` from [`fresnel_dielectric`] of `w.dot(m)`, `eta` transmitted
/// over incident index ([`relative_eta`]). Unit length, on the other side of `m`, and `w + eta * refract` is along `m`.
#[inline]
pub fn refract(w: Vec3, m: Vec3, cos_t: f32, eta: f32) -> Vec3 {
    let scale = 1.0 / eta;
    m * (w.dot(m) * scale + cos_t) - w * scale
}
