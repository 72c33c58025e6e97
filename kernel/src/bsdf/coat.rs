//! Dielectric coats above any reflecting lobe: refraction of directions and transmission of light through them.
//!
//! Weidlich and Wilkie 2007, "Arbitrarily Layered Micro-Facet Surfaces", in the form of Jakob's and Bitterli's renderers:
//!
//! f(wi, wo) = (1 - F(wi)) (1 - F(wo)) / n^2 * exp(-tau (1 / cos'_i + 1 / cos'_o)) * f_below(wi', wo')
//!
//! with w' the refraction of w at the coat's surface, n the index of the coat over that of its surroundings, and
//! tau = sigma_a thickness the optical depth of the coat. The cosines of the absorption are those inside the coat. Light
//! that the coat's surface reflects back down is left out; [`super::plastic`] has it in closed form for a diffuse base.
//! Rough coats refract as if they were smooth (the roughness of the coat shapes its own reflection); 1 - F may come from a
//! table of [`super::rough_transmittance`].
//!
//! A base under two coats sees the composition of both, in order. With the Jacobian of the refraction on the outgoing side,
//! d omega' / d omega = cos / (n^2 cos'), a density below becomes p(wo) = p_below(wo') d omega' / d omega, and the value
//! times its cosine takes the same factor: f cos / p changes by the transmittances alone.
//!
//! Directions point away from the surface, above and inside; only `z > 0` passes. Total reflection on the way out (or in,
//! for coats thinner than their surroundings) gives no contribution. Checked: [`refract_in`] and [`refract_out`] are inverse,
//! the Jacobian by central differences in f64, chi-square of coated lobes, reciprocity, values of another renderer.

use super::fresnel::fresnel_dielectric;
use super::rough_transmittance;
use crate::math::{Rgb, float};
use crate::scene::MAX_COATS;
use crate::scene::NONE;
use glam::Vec3;

/// A coat with its parameters looked up.
#[derive(Clone, Copy, Debug)]
pub struct Coat {
    /// Index of the coat over that of its surroundings.
    pub eta: f32,
    /// Absorption coefficient times thickness.
    pub optical_depth: Vec3,
    /// Roughness, for the table.
    pub alpha: f32,
    /// Table of rough transmittance in `data`, or NONE.
    pub table: u32,
    /// Rows of the table.
    pub table_rows: u32,
}

impl Coat {
    /// No boundary and no absorption.
    pub const NONE: Coat = Coat {
        eta: 1.0,
        optical_depth: Vec3::ZERO,
        alpha: 0.0,
        table: NONE,
        table_rows: 1,
    };
}

/// A direction on the other side of the coats, and the attenuation between the two.
#[derive(Clone, Copy, Debug)]
pub struct CoatTransmission {
    /// The direction after the transmission.
    pub w: Vec3,
    /// Product of the transmittances of the boundaries and of the absorbing layers.
    pub transmittance: Rgb,
    /// Solid angle inside per solid angle outside.
    pub jacobian: f32,
    /// Whether light passes at all.
    pub valid: bool,
}

/// Cosine inside below which the transmittance is taken as zero. Only coats of lower index than their surroundings reach it,
/// near total reflection; they transmit almost nothing there, the Jacobian has a pole, and the cosine itself is a difference
/// that `f32` directions determine to 1e-7 / cos.
const MIN_COSINE: f32 = 1e-2;

/// Refracts `w` from outside through the first `count` coats.
#[inline]
pub fn refract_in(
    coats: &[Coat; MAX_COATS],
    count: u32,
    data: &[f32],
    w: Vec3,
) -> CoatTransmission {
    let mut transmission = CoatTransmission {
        w,
        transmittance: Vec3::ONE,
        jacobian: 1.0,
        valid: w.z > 0.0,
    };
    for i in 0..count as usize {
        let coat = &coats[i];
        let outside = transmission.w;
        let eta = coat.eta.max(1e-3).min(1e3);
        let cos_inside = -fresnel_dielectric(outside.z, eta).1;
        if !transmission.valid || cos_inside < MIN_COSINE {
            transmission.valid = false;
            return transmission;
        }
        let passed = rough_transmittance::transmittance(
            data,
            coat.table,
            coat.table_rows,
            eta,
            coat.alpha,
            outside.z,
        );
        let inverse = 1.0 / eta;
        transmission.w = Vec3::new(outside.x * inverse, outside.y * inverse, cos_inside);
        transmission.transmittance *= absorption(coat.optical_depth, cos_inside) * passed;
        transmission.jacobian *= inverse * inverse * outside.z / cos_inside;
    }
    transmission
}

/// Refracts `w` from below all coats to the outside; transmittance and Jacobian are those of [`refract_in`] at the resulting
/// direction.
#[inline]
pub fn refract_out(
    coats: &[Coat; MAX_COATS],
    count: u32,
    data: &[f32],
    w: Vec3,
) -> CoatTransmission {
    let mut outside = w;
    let mut valid = w.z > 0.0;
    for k in 0..count as usize {
        let eta = coats[count as usize - 1 - k].eta.max(1e-3).min(1e3);
        // Snell's law in the sines; the cosine from them, so that the direction stays of unit length.
        let (x, y) = (outside.x * eta, outside.y * eta);
        let cos = float::safe_sqrt(1.0 - x * x - y * y);
        valid = valid && cos > 0.0;
        outside = Vec3::new(x, y, cos);
    }
    if !valid {
        return CoatTransmission {
            w: Vec3::Z,
            transmittance: Vec3::ZERO,
            jacobian: 0.0,
            valid: false,
        };
    }
    CoatTransmission {
        w: outside,
        ..refract_in(coats, count, data, outside)
    }
}

/// Transmittance of the coats for light that enters along `w` and leaves along the normal: an estimate of a coated lobe's
/// share that needs no second direction, and an upper bound of the transmittance for any pair of directions with this `w`.
#[inline]
pub fn round_trip(coats: &[Coat; MAX_COATS], count: u32, data: &[f32], w: Vec3) -> Rgb {
    let transmission = refract_in(coats, count, data, w);
    if !transmission.valid {
        return Vec3::ZERO;
    }
    let mut transmittance = transmission.transmittance;
    for i in 0..count as usize {
        transmittance *= absorption(coats[i].optical_depth, 1.0);
    }
    transmittance
}

/// exp(-tau / cos) per channel.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn absorption(optical_depth: Vec3, cos: f32) -> Rgb {
    let inverse = 1.0 / cos;
    Vec3::new(
        float::exp(-optical_depth.x.max(0.0) * inverse),
        float::exp(-optical_depth.y.max(0.0) * inverse),
        float::exp(-optical_depth.z.max(0.0) * inverse),
    )
}
