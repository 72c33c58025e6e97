//! Diffuse base under a rough dielectric coating.
//!
//! f = F D G1(wi) G1(wo) / (4 cos_i cos_o) + T(cos_i) T(cos_o) / eta^2 * rho / (1 - rho F_int) / pi
//!
//! The first term is the microfacet reflection with separable Smith masking, F at the half vector. T is the rough
//! transmittance, T(cos) = integral of D_wi(m) (1 - F(wi . m)) G1(wt) dm over visible normals with wt the refraction at
//! m, and F_int the cosine-weighted mean of the share that is reflected back inside; the base is that of [`plastic`],
//! linear or nonlinear. T is read from a table of
//! [`TRANSMITTANCE_ENTRIES`] values at cos = i / (entries - 1), linear in between, that a host fills with
//! [`fill_rough_transmittance`]; without a table the smooth boundary's 1 - F stands in (Tungsten's choice). A table over
//! roughness as well only needs another [`rough_transmittance`].
//!
//! Densities per solid angle, one sample over both parts. The coating is chosen with probability proportional to
//! (1 - T(cos_i)) s against T(cos_i) d, s and d the mean reflectances. Invariants (tests): furnace at most 1, reciprocity,
//! samples follow the density, values and densities of an independent renderer.

use super::fresnel::{fresnel_dielectric, reflect, refract};
use super::{BsdfSample, Lobe, event, microfacet, plastic};
use crate::math::{Rgb, float, warp};
use crate::scene::NONE;
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};

/// Entries of a table of rough transmittance.
pub const TRANSMITTANCE_ENTRIES: usize = 64;

/// The BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return Vec3::ZERO;
    }
    let transmitted = rough_transmittance(lobe, data, wi.z) * rough_transmittance(lobe, data, wo.z);
    let mut f = plastic::base(lobe) * transmitted;
    let h = half_vector(wi, wo);
    let d = microfacet::distribution(lobe.distribution, lobe.alpha, h);
    if d > 0.0 {
        // G1(w) / cos as one over the projected area, which has no pole at grazing angles.
        let area = microfacet::projected_area(lobe.distribution, lobe.alpha, wi)
            * microfacet::projected_area(lobe.distribution, lobe.alpha, wo);
        let reflected = fresnel_dielectric(wi.dot(h), lobe.eta.x).0;
        f += lobe.specular_reflectance * (0.25 * reflected * d / area);
    }
    f
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 {
        return 0.0;
    }
    let p = plastic::specular_probability(lobe, 1.0 - rough_transmittance(lobe, data, wi.z));
    let h = half_vector(wi, wo);
    let cos_h = wi.dot(h);
    let mut density = (1.0 - p) * wo.z * FRAC_1_PI;
    if cos_h > 0.0 {
        // Jacobian of the reflection at h: d omega_h / d omega_o = 1 / (4 wi . h).
        density += p * microfacet::visible_normal_pdf(lobe.distribution, lobe.alpha, wi, h)
            / (4.0 * cos_h);
    }
    density
}

/// A direction of the coating or of the base, `u1` chooses, weighted by the whole.
#[inline]
pub fn sample(lobe: &Lobe, data: &[f32], wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    if wi.z <= 0.0 {
        return BsdfSample::NONE;
    }
    let p = plastic::specular_probability(lobe, 1.0 - rough_transmittance(lobe, data, wi.z));
    let (wo, kind) = if u1 < p {
        let m = microfacet::sample_visible_normal(lobe.distribution, lobe.alpha, wi, u2);
        (reflect(wi, m), event::GLOSSY)
    } else {
        (warp::square_to_cosine_hemisphere(u2), event::DIFFUSE)
    };
    let pdf = pdf(lobe, data, wi, wo);
    if pdf <= 0.0 {
        return BsdfSample::NONE;
    }
    BsdfSample {
        wo,
        weight: eval(lobe, data, wi, wo) * (wo.z / pdf),
        pdf,
        eta: 1.0,
        event: event::REFLECTION | kind,
    }
}

/// Unit half vector of two directions on the same side.
#[inline]
fn half_vector(wi: Vec3, wo: Vec3) -> Vec3 {
    let h = wi + wo;
    h * (1.0 / float::sqrt(h.length_squared().max(1e-30)))
}

/// Share of the light from cosine `cos` that passes the coating.
#[inline]
pub fn rough_transmittance(lobe: &Lobe, data: &[f32], cos: f32) -> f32 {
    if lobe.table == NONE {
        return 1.0 - fresnel_dielectric(cos, lobe.eta.x).0;
    }
    const LAST: usize = TRANSMITTANCE_ENTRIES - 1;
    let x = cos.clamp(0.0, 1.0) * LAST as f32;
    let i = (x as usize).min(LAST - 1);
    let at = lobe.table as usize + i;
    float::lerp(data[at], data[at + 1], x - i as f32)
}

/// Nodes per axis of the quadrature over visible normals: absolute error below 2e-3 at grazing angles, 1e-4 elsewhere.
#[cfg(not(target_arch = "spirv"))]
const QUADRATURE: u32 = 48;

/// Mean of `f(m)` over the normals visible from `wi`, by the midpoint rule over the sampler's square. Runs on the host
/// when a scene is built: it accumulates in f64, which shaders lack.
#[cfg(not(target_arch = "spirv"))]
fn mean_over_visible_normals(kind: u32, alpha: f32, wi: Vec3, f: impl Fn(Vec3) -> f32) -> f32 {
    let alpha = microfacet::clamp_alpha(Vec2::splat(alpha));
    let step = 1.0 / QUADRATURE as f32;
    let mut sum = 0.0_f64;
    for i in 0..QUADRATURE {
        for j in 0..QUADRATURE {
            let u = Vec2::new((i as f32 + 0.5) * step, (j as f32 + 0.5) * step);
            sum += f64::from(f(microfacet::sample_visible_normal(kind, alpha, wi, u)));
        }
    }
    (sum / f64::from(QUADRATURE * QUADRATURE)) as f32
}

/// A direction with cosine `cos`, kept off the horizon.
#[cfg(not(target_arch = "spirv"))]
fn direction_at_cosine(cos: f32) -> Vec3 {
    let cos = cos.clamp(1e-6, 1.0);
    Vec3::new(float::safe_sqrt((1.0 - cos) * (1.0 + cos)), 0.0, cos)
}

/// Share of the light that a rough dielectric boundary lets in from outside at cosine `cos`; `eta` interior over
/// exterior.
#[cfg(not(target_arch = "spirv"))]
pub fn boundary_transmittance(kind: u32, alpha: f32, eta: f32, cos: f32) -> f32 {
    let wi = direction_at_cosine(cos);
    let width = microfacet::clamp_alpha(Vec2::splat(alpha));
    mean_over_visible_normals(kind, alpha, wi, |m| {
        let cos_i = wi.dot(m);
        let (reflected, cos_t) = fresnel_dielectric(cos_i, eta);
        let wt = refract(wi, m, cos_t, eta);
        if cos_i <= 0.0 || wt.z >= 0.0 {
            return 0.0;
        }
        (1.0 - reflected) * microfacet::smith_g1(kind, width, wt, m)
    })
}

/// Share of the light from inside at cosine `cos` that a rough dielectric boundary reflects back inside; `eta` interior
/// over exterior.
#[cfg(not(target_arch = "spirv"))]
pub fn boundary_internal_reflectance(kind: u32, alpha: f32, eta: f32, cos: f32) -> f32 {
    let wi = direction_at_cosine(cos);
    let width = microfacet::clamp_alpha(Vec2::splat(alpha));
    mean_over_visible_normals(kind, alpha, wi, |m| {
        let cos_i = wi.dot(m);
        let wo = reflect(wi, m);
        if cos_i <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        // The side of the interior is that of negative cosines.
        fresnel_dielectric(-cos_i, eta).0 * microfacet::smith_g1(kind, width, wo, m)
    })
}

/// Fills the table that [`rough_transmittance`] reads ([`TRANSMITTANCE_ENTRIES`] words), for an isotropic coating.
#[cfg(not(target_arch = "spirv"))]
pub fn fill_rough_transmittance(kind: u32, alpha: f32, eta: f32, out: &mut [f32]) {
    let last = out.len().saturating_sub(1).max(1);
    for (i, value) in out.iter_mut().enumerate() {
        *value = boundary_transmittance(kind, alpha, eta, i as f32 / last as f32);
    }
}

/// F_int of a rough coating for [`crate::scene::LobeRecord::internal_reflectance`]: the cosine-weighted mean of
/// [`boundary_internal_reflectance`].
///
/// It is the plain mean of 2 cos R over the [`TRANSMITTANCE_ENTRIES`] nodes, both ends included, because the images that
/// people compare with are made so; the trapezoidal rule, with one node less in the divisor, gives values 1.6 % higher.
#[cfg(not(target_arch = "spirv"))]
pub fn rough_internal_reflectance(kind: u32, alpha: f32, eta: f32) -> f32 {
    let mut sum = 0.0;
    for i in 0..TRANSMITTANCE_ENTRIES {
        let cos = i as f32 / (TRANSMITTANCE_ENTRIES - 1) as f32;
        sum += 2.0 * cos * boundary_internal_reflectance(kind, alpha, eta, cos);
    }
    sum / TRANSMITTANCE_ENTRIES as f32
}
