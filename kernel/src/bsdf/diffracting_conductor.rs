//! CTD: a conductor whose microfacets reflect and, by their own finer roughness, diffract.
//!
//! Holzschuch and Pacanowski 2015, "A Physically Accurate Reflectance Model Combining Reflection and Diffraction" (Inria
//! RR-8807). Per wavelength, with `h` the half vector, theta_d the difference angle, `rho` and `S~` of
//! [`super::diffraction_table`]:
//!
//! - `A = exp(-(4 pi sigma cos(theta_d) / lambda)^2 rho(theta_d))` of the light stays a reflection at the facets:
//!   `f = A F D(h) G / (4 cos_i cos_o)`;
//! - the rest is diffracted around it: `f = G (1 - A) Q S~(theta_h, u) / (rho(theta_d) lambda^2)`.
//!
//! `D` is the exponential power distribution, `G` the product of Smith's G1, F the conductor's Fresnel reflectance.
//!
//! # The factor two
//! The model's published code takes for Q the sum of the four squared Rayleigh-Rice polarisation factors, which is
//! `2 F` at normal incidence. That is unpolarised light counted twice: both parts together would return
//! `F (2 - A) > 1`. The mean over the two incident polarisations is half the sum. It equals F exactly in the mirror
//! direction at every angle (a test does the algebra in f64), where a facet's diffraction is brightest, so `Q = F(theta_d)`
//! here; then the two parts share `F` as `A + (1 - A)`, and a white conductor's furnace stays at most 1 (tested; with
//! twice the Q it reaches 1.8).
//!
//! Sampled from the facets' normals with probability about A, else from half vectors whose slopes follow a
//! K-correlation law of the combined width, on the side that faces `wi` ([`super::microfacet::v_cavity`]). Checked:
//! density by chi-square, reciprocity, furnace, limits of sigma 0 and of smooth facets.

use super::diffraction_table::{FineScale, fine_scale, ln_spectrum, scattered_share};
use super::fresnel::{fresnel_conductor, reflect};
use super::microfacet::v_cavity;
use super::{BsdfSample, Lobe, event};
use crate::math::Rgb;
use crate::math::float::{atan2, exp, pow, safe_sqrt, sqr};
use crate::scene::NONE;
use core::f32::consts::{FRAC_1_PI, PI};
use glam::{Vec2, Vec3};

/// BSDF without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z <= 0.0 || wo.z <= 0.0 || lobe.table == NONE {
        return Vec3::ZERO;
    }
    let h = (wi + wo).normalize_or_zero();
    let cos_d = wi.dot(h);
    if cos_d <= 0.0 || h.z <= 0.0 {
        return Vec3::ZERO;
    }
    let facets = lobe.microfacets();
    // G / (cos_i cos_o).
    let visible = 1.0 / (facets.projected_area(wi) * facets.projected_area(wo));
    let reflected = 0.25 * facets.distribution(h);
    let scale = fine_scale(data, lobe.table);
    let theta_h = atan2(safe_sqrt(h.x * h.x + h.y * h.y), h.z);
    let area = wi.z * wo.z;
    let channel = |k: usize, wavelength: f32| {
        let rho = scattered_share(data, lobe.table, k, cos_d);
        let lost = scattered(&scale, wavelength, cos_d, rho);
        let u = scale.b * cos_d / wavelength;
        let spectrum = exp(ln_spectrum(data, lobe.table, theta_h, u));
        let diffracted = lost * spectrum / (rho.max(1e-12) * wavelength * wavelength);
        (1.0 - lost) * reflected + diffracted * area
    };
    let f = Vec3::new(
        channel(0, scale.wavelengths[0]),
        channel(1, scale.wavelengths[1]),
        channel(2, scale.wavelengths[2]),
    );
    lobe.specular_reflectance * fresnel_conductor(cos_d, lobe.eta, lobe.k) * f * visible
}

/// `1 - A`.
#[inline]
fn scattered(scale: &FineScale, wavelength: f32, cos_d: f32, rho: f32) -> f32 {
    let x = sqr(4.0 * PI * scale.sigma * cos_d / wavelength) * rho;
    // Without cancellation.
    if x < 1e-3 {
        x * (1.0 - 0.5 * x)
    } else {
        1.0 - exp(-x)
    }
}

/// Density of [`sample`] per solid angle.
#[inline]
pub fn pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> f32 {
    if wi.z <= 0.0 || wo.z <= 0.0 || lobe.table == NONE {
        return 0.0;
    }
    let h = (wi + wo).normalize_or_zero();
    let cos_d = wi.dot(h);
    if cos_d <= 0.0 || h.z <= 0.0 {
        return 0.0;
    }
    let law = Law::new(lobe, data, wi.z);
    let normals = lobe.microfacets().visible_normal_pdf(wi, h);
    let slopes = law.distribution(h) * v_cavity::facing_area(wi, h);
    // Solid angle of half vectors per solid angle of wo.
    (law.reflection * normals + (1.0 - law.reflection) * slopes) * 0.25 / cos_d
}

/// A direction reflected at a sampled half vector; `u1` chooses the kind of half vector.
#[inline]
pub fn sample(lobe: &Lobe, data: &[f32], wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    if wi.z <= 0.0 || lobe.table == NONE {
        return BsdfSample::NONE;
    }
    let law = Law::new(lobe, data, wi.z);
    let h = if u1 < law.reflection {
        lobe.microfacets().sample_visible_normal(wi, u2)
    } else {
        let slope = v_cavity::sample_azimuth(wi, law.sample_radius(u2.y), u2.x);
        Vec3::new(slope.x, slope.y, 1.0).normalize_or_zero()
    };
    let wo = reflect(wi, h);
    let density = pdf(lobe, data, wi, wo);
    if density <= 0.0 {
        return BsdfSample::NONE;
    }
    BsdfSample {
        wo,
        weight: eval(lobe, data, wi, wo) * (wo.z / density),
        pdf: density,
        eta: 1.0,
        event: event::GLOSSY | event::REFLECTION,
    }
}

/// The law of the half vectors of diffraction, an approximation to the spectrum that can be sampled: slopes with density
/// `(c - 1) / (2 pi w^2) (1 + s^2 / w^2)^(-(c + 1) / 2)`.
struct Law {
    /// Probability of the facets' own normals.
    reflection: f32,
    width: f32,
    c: f32,
}

impl Law {
    #[inline]
    fn new(lobe: &Lobe, data: &[f32], cos: f32) -> Law {
        let scale = fine_scale(data, lobe.table);
        let mut kept = 0.0;
        for k in 0..3 {
            let rho = scattered_share(data, lobe.table, k, cos);
            kept += 1.0 - scattered(&scale, scale.wavelengths[k], cos, rho);
        }
        // The spectrum's width as a slope at the middle wavelength, and that of the facets; at grazing incidence the
        // spectrum covers all directions.
        let own = 0.5 * scale.wavelengths[1] / (scale.b * cos).max(0.1 * scale.wavelengths[1]);
        Law {
            // Neither is left out: each is what the other's density is too thin for.
            reflection: 0.05 + 0.9 * kept * (1.0 / 3.0),
            width: safe_sqrt(own * own + sqr(lobe.microfacets().alpha.x)),
            // A slower decay would put most half vectors on the horizon.
            c: scale.c.max(2.0),
        }
    }

    /// Slope density over `h.z^4`, like a distribution of normals.
    #[inline]
    fn distribution(&self, h: Vec3) -> f32 {
        let z2 = h.z * h.z;
        let s2 = (h.x * h.x + h.y * h.y) / (z2 * self.width * self.width).max(1e-30);
        let density = pow(1.0 + s2, -0.5 * (self.c + 1.0)) / (self.width * self.width);
        0.5 * (self.c - 1.0) * FRAC_1_PI * density / (z2 * z2).max(1e-30)
    }

    /// The slope at the quantile `u`.
    #[inline]
    fn sample_radius(&self, u: f32) -> f32 {
        let q = pow((1.0 - u).max(6e-8), -2.0 / (self.c - 1.0));
        self.width * safe_sqrt(q - 1.0)
    }
}
