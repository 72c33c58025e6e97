//! The generalised half vector, its coordinates and the Jacobians between their measures.
//!
//! `H = wi + eta wo`, `h = +-H / |H|` with `h . n >= 0` (Sommerfeld and Runge 1911; Kaplanyan 2017, section 7.1.2), where
//! directions point away from the surface and `eta` is the index on the side of wo over the index on the side of wi: 1 for
//! any reflection, also off a dielectric. For a mirror or a smooth interface `h` is the normal, for a rough one the normal of
//! the microfacet.
//!
//! Two charts of the hemisphere of `h`, both around the shading normal n:
//! - *projected*: `h_perp = (h.s, h.t)`, the unit disk; measure `dh_perp = dh |h.n|`, projected solid angle;
//! - *slope* (plane/plane): `h_pp = (h.s, h.t) / (h.n)`, the whole plane; measure `dh_pp = dh / |h.n|^3`.
//!
//! | Jacobian | value | function |
//! |---|---|---|
//! | do / dh | `|H|^2 / (eta^2 |h.wo|)`; `4 |h.wo|` for reflection | [`HalfVector::solid_angle_per_half_vector`] |
//! | dh_perp / dh | `|h.n|` | [`projected_per_half_vector`] |
//! | dh_pp / dh | `1 / |h.n|^3` | [`slope_per_half_vector`] |
//! | dh_perp / dh_pp | `cos^4 = 1 / (1 + |h_pp|^2)^2` | [`projected_per_slope`] |
//!
//! The first is equation 7.1 (Walter et al. 2007, equation 17) turned over: `|h.wi + eta h.wo| = |H|`. Checked: all of them
//! against central differences in f64; `outgoing` inverts `half_vector`.

use crate::math::Frame;
use crate::math::float::{abs, safe_sqrt, sqrt};
use glam::{Vec2, Vec3};

/// A half vector with what its Jacobian needs.
#[derive(Clone, Copy, Debug)]
pub struct HalfVector {
    /// Unit vector on the side of the normal that it was made with.
    pub h: Vec3,
    /// |H|; zero where there is no half vector.
    pub length: f32,
    /// -1 when `h` is `-H / |H|`.
    pub sign: f32,
}

/// Below this |H| directions are taken as opposite and equal: no half vector.
pub const SHORTEST: f32 = 1e-6;

/// The half vector of two unit directions, turned to the side of `n`.
#[inline]
pub fn half_vector(wi: Vec3, wo: Vec3, eta: f32, n: Vec3) -> HalfVector {
    let sum = wi + wo * eta;
    let length = safe_sqrt(sum.length_squared());
    if !(length > SHORTEST && length < f32::MAX) {
        return HalfVector {
            h: n,
            length: 0.0,
            sign: 1.0,
        };
    }
    let sign = if sum.dot(n) < 0.0 { -1.0 } else { 1.0 };
    HalfVector {
        h: sum * (sign / length),
        length,
        sign,
    }
}

impl HalfVector {
    /// |do / dh|, solid angle of outgoing directions per solid angle of half vectors at fixed wi; zero where undefined.
    #[inline]
    pub fn solid_angle_per_half_vector(&self, wo: Vec3, eta: f32) -> f32 {
        let denominator = eta * eta * abs(self.h.dot(wo));
        if !(denominator > 1e-12) {
            return 0.0;
        }
        self.length * self.length / denominator
    }
}

/// |dh_perp / dh|.
#[inline]
pub fn projected_per_half_vector(cos_h: f32) -> f32 {
    abs(cos_h)
}

/// |dh_pp / dh|; zero at the horizon, where it has its pole.
#[inline]
pub fn slope_per_half_vector(cos_h: f32) -> f32 {
    let c3 = abs(cos_h * cos_h * cos_h);
    if c3 > 1e-30 { 1.0 / c3 } else { 0.0 }
}

/// |dh_perp / dh_pp| at a slope.
#[inline]
pub fn projected_per_slope(slope: Vec2) -> f32 {
    let cos2 = 1.0 / (1.0 + slope.length_squared());
    cos2 * cos2
}

/// Slope of a projected half vector inside the disk; a point on or outside the rim is taken as just inside.
#[inline]
pub fn slope_of_projected(h: Vec2) -> Vec2 {
    h * (1.0 / sqrt((1.0 - h.length_squared()).max(1e-12)))
}

/// Projected half vector of a slope.
#[inline]
pub fn projected_of_slope(h: Vec2) -> Vec2 {
    h * (1.0 / sqrt(1.0 + h.length_squared()))
}

/// The unit half vector of a slope in a frame.
#[inline]
pub fn half_vector_of_slope(frame: &Frame, h: Vec2) -> Vec3 {
    frame.to_world(Vec3::new(h.x, h.y, 1.0)) * (1.0 / sqrt(1.0 + h.length_squared()))
}

/// The unit half vector of a projected one in a frame.
#[inline]
pub fn half_vector_of_projected(frame: &Frame, h: Vec2) -> Vec3 {
    frame.to_world(Vec3::new(h.x, h.y, safe_sqrt(1.0 - h.length_squared())))
}

/// A scattered direction.
#[derive(Clone, Copy, Debug)]
pub struct Outgoing {
    /// Unit direction.
    pub wo: Vec3,
    /// False at total internal reflection.
    pub valid: bool,
}

/// Reflection of `wi` at a microfacet with unit normal `m`.
#[inline]
pub fn reflect(wi: Vec3, m: Vec3) -> Outgoing {
    Outgoing {
        wo: m * (2.0 * wi.dot(m)) - wi,
        valid: true,
    }
}

/// Refraction of `wi` through a microfacet: `wi + eta wo` is along `m`.
#[inline]
pub fn refract(wi: Vec3, m: Vec3, eta: f32) -> Outgoing {
    let cos_i = wi.dot(m);
    // Snell: sin_o = sin_i / eta. 1 - cos^2 as a product does not cancel at normal incidence.
    let sin2 = (1.0 - cos_i) * (1.0 + cos_i) / (eta * eta);
    if !(sin2 < 1.0) {
        return Outgoing {
            wo: -wi,
            valid: false,
        };
    }
    let cos_o = sqrt(1.0 - sin2);
    let along = if cos_i < 0.0 { cos_o } else { -cos_o };
    let wo = (m * cos_i - wi) * (1.0 / eta) + m * along;
    Outgoing {
        wo: wo * (1.0 / safe_sqrt(wo.length_squared()).max(1e-20)),
        valid: true,
    }
}
