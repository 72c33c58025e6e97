//! Rough dielectric boundary: microfacets that reflect and refract.
//!
//! Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", with `eta` the index on the side of
//! `wo` over that of `wi`, `m` the half vector in the upper hemisphere, and projected areas `A = |w.z| / G1`:
//!
//! - reflection (eq. 20): `f = F D(m) / (4 A(wi) A(wo))`, `m` along `wi + wo`;
//! - transmission (eq. 21): `f = (1 - F) D(m) |wi.m| |wo.m| s / (A(wi) A(wo) |wi + eta wo|^2)`, `m` along
//!   `wi + eta wo`, with `s = 1` for radiance and `eta^2` for importance.
//!
//! Masking is separable; a direction must lie on the same side of `m` as of the surface. `lobe.eta.x` is interior over
//! exterior; `wi` may be on either side. The normal is sampled with `u2`, one of the two events with `u1` by the
//! Fresnel reflectance at that normal. Within [`INDEX_MATCHED`] of equal indices the transmitted lobe is narrower than
//! `f32` directions resolve and the boundary is treated as absent: a delta straight on.
//!
//! Checked: the density by chi-square on both sides, the Jacobians by central differences, `f(wi, wo) / n_i^2` equal to
//! `f(wo, wi) / n_o^2`, importance the adjoint of radiance, the furnace at most 1, values against another renderer,
//! finite for every roughness and index.

use super::fresnel::{fresnel_dielectric, reflect, refract, relative_eta};
use super::microfacet::Microfacets;
use super::{BsdfSample, Lobe, event, mode};
use crate::math::Rgb;
use crate::math::float::abs;
use glam::Vec3;

/// Largest distance of the relative index from 1 at which the boundary is taken as absent.
pub const INDEX_MATCHED: f32 = 1e-4;

/// The half vector of two directions and the cosines against it.
#[derive(Clone, Copy)]
struct Half {
    /// Unit normal in the upper hemisphere; meaningless unless `valid`.
    m: Vec3,
    /// `wi.m`, with the sign of `wi.z`.
    cos_i: f32,
    /// `wo.m`, with the sign of `wo.z`.
    cos_o: f32,
    /// `wo.z` over `wi.z` is positive.
    reflection: bool,
    /// Relative index.
    eta: f32,
    /// Squared length of `wi + wo` or `wi + eta wo`.
    length_squared: f32,
    /// Whether a microfacet can turn one direction into the other.
    valid: bool,
}

impl Half {
    /// Fresnel reflectance at the microfacet. Refraction takes the cosine on the side of lower index (F is the same
    /// along the reversed path): from the other side it would depend on a difference that vanishes at the critical
    /// angle.
    #[inline]
    fn reflectance(&self, lobe: &Lobe) -> f32 {
        let cos = if self.reflection || self.eta > 1.0 {
            self.cos_i
        } else {
            self.cos_o
        };
        fresnel_dielectric(cos, lobe.eta.x).0
    }

    /// The BSDF for radiance without its colour.
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    fn value(&self, lobe: &Lobe, facets: &Microfacets, wi: Vec3, wo: Vec3) -> f32 {
        let reflectance = self.reflectance(lobe);
        let area = facets.projected_area(wi) * facets.projected_area(wo);
        let d = facets.distribution(self.m) / area;
        if self.reflection {
            0.25 * reflectance * d
        } else {
            (1.0 - reflectance) * d * abs(self.cos_i * self.cos_o) / self.length_squared
        }
    }
}

#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn half_vector(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Half {
    let reflection = wi.z * wo.z > 0.0;
    let eta = relative_eta(wi.z, lobe.eta.x);
    let h = wi + wo * if reflection { 1.0 } else { eta };
    let length_squared = h.length_squared();
    let mut half = Half {
        m: Vec3::Z,
        cos_i: 0.0,
        cos_o: 0.0,
        reflection,
        eta,
        length_squared,
        valid: false,
    };
    if wi.z == 0.0
        || wo.z == 0.0
        || length_squared < 1e-14
        || abs(lobe.eta.x - 1.0) <= INDEX_MATCHED
    {
        return half;
    }
    let m = h * (1.0 / crate::math::float::sqrt(length_squared));
    half.m = if m.z < 0.0 { -m } else { m };
    half.cos_i = wi.dot(half.m);
    half.cos_o = wo.dot(half.m);
    half.valid = half.cos_i * wi.z > 0.0 && half.cos_o * wo.z > 0.0;
    half
}

/// BSDF without a cosine.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    let half = half_vector(lobe, wi, wo);
    if !half.valid {
        return Rgb::ZERO;
    }
    let f = half.value(lobe, &lobe.microfacets(), wi, wo);
    if half.reflection {
        lobe.specular_reflectance * f
    } else {
        let scale = if lobe.mode == mode::RADIANCE {
            1.0
        } else {
            half.eta * half.eta
        };
        lobe.specular_transmittance * (f * scale)
    }
}

/// The BSDF for radiance of a boundary with other microfacets.
#[derive(Clone, Copy)]
pub(crate) struct BoundaryValue {
    /// Its value without the lobe's colour.
    pub value: f32,
    /// Whether light is reflected.
    pub reflection: bool,
    /// The value with exchanged directions over this one: the squared relative index where light is refracted.
    pub exchanged: f32,
}

/// [`eval`] with the microfacets `facets` instead of the lobe's. With their projected areas A the densities of visible normals
/// are `value exchanged A(wo)` for wo and `value A(wi)` for wi where wo is known, times Fresnel's share, which the value holds.
#[inline]
pub(crate) fn boundary_value(
    lobe: &Lobe,
    facets: &Microfacets,
    wi: Vec3,
    wo: Vec3,
) -> BoundaryValue {
    let half = half_vector(lobe, wi, wo);
    BoundaryValue {
        value: if half.valid {
            half.value(lobe, facets, wi, wo)
        } else {
            0.0
        },
        reflection: half.reflection,
        exchanged: if half.reflection {
            1.0
        } else {
            half.eta * half.eta
        },
    }
}

/// Density of [`sample`] per solid angle.
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    let half = half_vector(lobe, wi, wo);
    if !half.valid {
        return 0.0;
    }
    let reflectance = half.reflectance(lobe);
    let density = pdf_of_normal(lobe, wi, half.m);
    if half.reflection {
        density * reflectance * solid_angle_of_reflection(half.cos_i)
    } else {
        density
            * (1.0 - reflectance)
            * solid_angle_of_refraction(half.cos_o, half.eta, half.length_squared)
    }
}

/// The reflection or refraction at a sampled microfacet normal `m`; `u1` chooses between them.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn sample(lobe: &Lobe, wi: Vec3, u1: f32, m: Vec3) -> BsdfSample {
    let all = lobe.samples_all_normals();
    let facets = lobe.microfacets();
    let cos_i = wi.dot(m);
    let (reflectance, cos_t) = fresnel_dielectric(cos_i, lobe.eta.x);
    let eta = relative_eta(cos_i, lobe.eta.x);
    let density = pdf_of_normal(lobe, wi, m);

    // Both events are computed and one is selected: lanes of a vector cannot branch apart.
    let is_reflected = u1 < reflectance;
    let reflected = reflect(wi, m);
    let reflected_pdf = density * reflectance * solid_angle_of_reflection(cos_i);
    // wi.m + eta wo.m, whose square is |wi + eta wo|^2, by Snell's law free of cancellation.
    let length = (1.0 - eta) * (1.0 + eta) / (abs(cos_i) + eta * abs(cos_t));
    let refracted = refract(wi, m, cos_t, eta);
    let refracted_pdf =
        density * (1.0 - reflectance) * solid_angle_of_refraction(cos_t, eta, length * length);
    let mut transmittance = lobe.specular_transmittance;
    if lobe.mode == mode::RADIANCE {
        transmittance *= 1.0 / (eta * eta);
    }
    let mut s = if is_reflected {
        BsdfSample {
            wo: reflected,
            weight: lobe.specular_reflectance,
            pdf: reflected_pdf,
            eta: 1.0,
            event: event::GLOSSY | event::REFLECTION,
        }
    } else {
        BsdfSample {
            wo: refracted,
            weight: transmittance,
            pdf: refracted_pdf,
            eta,
            event: event::GLOSSY | event::TRANSMISSION,
        }
    };
    // f cos / pdf: Fresnel terms, D and Jacobians cancel, and with Smith's visible normals so does everything of wi.
    s.weight *= abs(s.wo.z) / facets.projected_area(s.wo);
    s.weight *= if all {
        abs(cos_i) / (facets.projected_area(wi) * m.z)
    } else {
        facets.visible_normal_weight(to_upper_hemisphere(wi), m)
    };
    let side = s.wo.z * wi.z;
    let is_there = if is_reflected { side > 0.0 } else { side < 0.0 };
    if abs(lobe.eta.x - 1.0) <= INDEX_MATCHED && wi.z != 0.0 {
        straight_through(lobe, wi)
    } else if cos_i * wi.z > 0.0 && is_there && s.pdf > 0.0 {
        s
    } else {
        BsdfSample::NONE
    }
}

/// Straight on, where there is no boundary.
#[inline]
fn straight_through(lobe: &Lobe, wi: Vec3) -> BsdfSample {
    BsdfSample {
        wo: -wi,
        weight: lobe.specular_transmittance,
        pdf: 1.0,
        eta: 1.0,
        event: event::DELTA | event::TRANSMISSION,
    }
}

/// The direction or its opposite, whichever is above the surface: microfacets look alike from both sides.
#[inline]
pub(crate) fn to_upper_hemisphere(w: Vec3) -> Vec3 {
    if w.z < 0.0 { -w } else { w }
}

/// Density per solid angle of the sampled normal.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn pdf_of_normal(lobe: &Lobe, wi: Vec3, m: Vec3) -> f32 {
    if lobe.samples_all_normals() {
        lobe.microfacets().normal_pdf(m)
    } else {
        lobe.microfacets()
            .visible_normal_pdf(to_upper_hemisphere(wi), m)
    }
}

/// Solid angle of half vectors per solid angle of `wo` in reflection, `1 / (4 |wi.m|)` (eq. 14).
#[inline]
fn solid_angle_of_reflection(cos_i: f32) -> f32 {
    0.25 / abs(cos_i)
}

/// Solid angle of half vectors per solid angle of `wo` in refraction, `eta^2 |wo.m| / |wi + eta wo|^2` (eq. 17).
#[inline]
fn solid_angle_of_refraction(cos_o: f32, eta: f32, length_squared: f32) -> f32 {
    eta * eta * abs(cos_o) / length_squared
}
