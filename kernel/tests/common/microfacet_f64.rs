//! The microfacet BSDF of the bounds in double precision, by its definitions and not by the kernel's formulas.

// Each test file uses its part.
#![allow(dead_code)]

use glam::DVec3;
use halflight_kernel::scene::distribution;
use statrs::function::erf::erf;
use std::f64::consts::PI;

pub const BECKMANN: u32 = distribution::BECKMANN;
pub const GGX: u32 = distribution::GGX;
pub const COSINE: u32 = distribution::PHONG;

/// D for a unit or longer normal with `h.z > 0`.
pub fn normals(kind: u32, alpha: [f64; 2], h: DVec3) -> f64 {
    let slope2 = ((h.x / alpha[0]).powi(2) + (h.y / alpha[1]).powi(2)) / (h.z * h.z);
    let cos2 = h.z * h.z / h.length_squared();
    let peak = 1.0 / (PI * alpha[0] * alpha[1]);
    match kind {
        BECKMANN => peak * (-slope2).exp() / (cos2 * cos2),
        GGX => peak / ((1.0 + slope2) * cos2).powi(2),
        _ => peak * cos2.powf(1.0 / (alpha[0] * alpha[0]) - 1.0),
    }
}

/// Smith's Lambda; the cosine distribution takes Beckmann's, as the paper has it.
pub fn lambda(kind: u32, alpha: [f64; 2], w: DVec3) -> f64 {
    let spread = ((alpha[0] * w.x).powi(2) + (alpha[1] * w.y).powi(2)).sqrt();
    if spread == 0.0 {
        return 0.0;
    }
    let a = w.z.abs() / spread;
    if kind == GGX {
        0.5 * ((1.0 + 1.0 / (a * a)).sqrt() - 1.0)
    } else {
        0.5 * (erf(a) - 1.0) + (-a * a).exp() / (2.0 * a * PI.sqrt())
    }
}

#[derive(Clone, Copy, PartialEq)]
pub enum Masking {
    Separable,
    Correlated,
    VCavity,
}

/// G2 / (cos_i cos_o).
pub fn masking(kind: u32, alpha: [f64; 2], i: DVec3, o: DVec3, h: DVec3, form: Masking) -> f64 {
    let cosines = (i.z * o.z).abs();
    let (li, lo) = (lambda(kind, alpha, i), lambda(kind, alpha, o));
    match form {
        Masking::Separable => 1.0 / ((1.0 + li) * (1.0 + lo) * cosines),
        Masking::Correlated => 1.0 / ((1.0 + li + lo) * cosines),
        Masking::VCavity => {
            let n = h.normalize();
            let g = |w: DVec3| 2.0 * n.z * w.z.abs() / w.dot(n).abs();
            g(i).min(g(o)).min(1.0) / cosines
        }
    }
}

pub fn reflection(kind: u32, alpha: [f64; 2], i: DVec3, o: DVec3, form: Masking) -> f64 {
    let h = i + o;
    0.25 * normals(kind, alpha, h) * masking(kind, alpha, i, o, h, form)
}

pub fn direction(z: f64, azimuth: f64) -> DVec3 {
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * azimuth.cos(), r * azimuth.sin(), z)
}

/// Equation 7 for a pair that a microfacet refracts; zero where none does. `eta` is transmitted over incident.
pub fn refraction(kind: u32, alpha: [f64; 2], eta: f64, i: DVec3, m: DVec3) -> f64 {
    let ci = i.dot(m);
    let sin2 = (1.0 - ci * ci) / (eta * eta);
    if ci <= 0.0 || sin2 >= 1.0 {
        return 0.0;
    }
    let ct = (1.0 - sin2).sqrt();
    let o = m * (ci / eta - ct) - i / eta;
    if o.z >= 0.0 {
        return 0.0;
    }
    let core = eta * eta * ci * ct / (ci - eta * ct).powi(2);
    normals(kind, alpha, m) * masking(kind, alpha, i, o, m, Masking::Separable) * core
}
