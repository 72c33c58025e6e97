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
//! # Energy
//! The published code takes for Q the sum of the four squared Rayleigh-Rice polarisation factors, `2 F` at normal
//! incidence. That counts unpolarised light twice: both parts together would return `F (2 - A) > 1`. The mean over the
//! two incident polarisations is half the sum. It equals F exactly in the mirror direction at every angle (a test does
//! the algebra in f64), where a facet's diffraction is brightest, so `Q = F(theta_d)` here; then the two parts share F
//! as `A + (1 - A)`.
//!
//! A defect of the model remains where the spectrum is broad (`b` about lambda or less): at a grazing wi the facets keep
//! their reflection, but the diffraction towards directions nearer the normal is computed from the smaller theta_d there. A
//! white conductor would return up to a third too much (1.36, tested; with the published Q, 1.98). [`fill_table`] therefore
//! finds, per wavelength and angle, the share `s` of the diffraction that conserves energy beside the reflection, and the
//! diffraction is multiplied by `min(s(wi), s(wo))`, which keeps it symmetric. The share is 1 where the model conserves
//! energy by itself.
//!
//! Sampled from the facets' normals with probability about A, else from half vectors whose slopes follow a
//! K-correlation law of the combined width, on the side that faces `wi` ([`super::microfacet::v_cavity`]). Checked:
//! density by chi-square, reciprocity, furnace, limits of sigma 0 and of smooth facets.

use super::diffraction_table::{FineScale, energy_limit, fine_scale, ln_spectrum, scattered_share};
use super::fresnel::{fresnel_conductor, reflect};
use super::microfacet::v_cavity;
use super::{BsdfSample, Lobe, event, weighted};
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
    let channel = |k: usize| {
        let (kept, diffracted) = parts(data, lobe.table, &scale, k, cos_d, h);
        let i = energy_limit(data, lobe.table, k, wi.z);
        let o = energy_limit(data, lobe.table, k, wo.z);
        kept * reflected + diffracted * (wi.z * wo.z * i.min(o))
    };
    let f = Vec3::new(channel(0), channel(1), channel(2));
    lobe.specular_reflectance * fresnel_conductor(cos_d, lobe.eta, lobe.k) * f * visible
}

/// `A` and `(1 - A) S~ / (rho lambda^2)` of one channel.
#[inline]
fn parts(
    data: &[f32],
    table: u32,
    scale: &FineScale,
    channel: usize,
    cos_d: f32,
    h: Vec3,
) -> (f32, f32) {
    let wavelength = scale.wavelengths[channel];
    let rho = scattered_share(data, table, channel, cos_d);
    let lost = scattered(scale, wavelength, cos_d, rho);
    let theta_h = atan2(safe_sqrt(h.x * h.x + h.y * h.y), h.z);
    let spectrum = exp(ln_spectrum(
        data,
        table,
        theta_h,
        scale.b * cos_d / wavelength,
    ));
    let diffracted = lost * spectrum / (rho.max(1e-12) * wavelength * wavelength);
    (1.0 - lost, diffracted)
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
    let law = HalfVectorDensity::new(lobe, data, wi.z);
    let normals = lobe.microfacets().visible_normal_pdf(wi, h);
    let slopes = law.distribution(h) * v_cavity::facing_area(wi, h);
    // Solid angle of half vectors per solid angle of wo.
    (law.reflection * normals + (1.0 - law.reflection) * slopes) * 0.25 / cos_d
}

/// A direction reflected at a sampled half vector: the visible normal that `normal` draws, or one of the diffraction drawn with
/// `u2`; `u1` chooses.
#[inline]
pub fn sample(
    lobe: &Lobe,
    data: &[f32],
    wi: Vec3,
    u1: f32,
    u2: Vec2,
    normal: impl FnOnce() -> Vec3,
) -> BsdfSample {
    if wi.z <= 0.0 || lobe.table == NONE {
        return BsdfSample::NONE;
    }
    let law = HalfVectorDensity::new(lobe, data, wi.z);
    let h = if u1 < law.reflection {
        normal()
    } else {
        law.sample_normal(wi, u2)
    };
    let s = BsdfSample::towards(reflect(wi, h), event::GLOSSY | event::REFLECTION);
    weighted!(s, pdf(lobe, data, wi, s.wo), eval(lobe, data, wi, s.wo))
}

/// The law of the half vectors of diffraction, an approximation to the spectrum that can be sampled: slopes with density
/// `(c - 1) / (2 pi w^2) (1 + s^2 / w^2)^(-(c + 1) / 2)`.
struct HalfVectorDensity {
    /// Probability of the facets' own normals.
    reflection: f32,
    width: f32,
    c: f32,
}

impl HalfVectorDensity {
    #[inline]
    fn new(lobe: &Lobe, data: &[f32], cos: f32) -> HalfVectorDensity {
        let scale = fine_scale(data, lobe.table);
        let mut kept = 0.0;
        for k in 0..3 {
            let rho = scattered_share(data, lobe.table, k, cos);
            kept += 1.0 - scattered(&scale, scale.wavelengths[k], cos, rho);
        }
        // The spectrum's width as a slope at the middle wavelength, and that of the facets; at grazing incidence the
        // spectrum covers all directions.
        let diffracted =
            0.5 * scale.wavelengths[1] / (scale.b * cos).max(0.1 * scale.wavelengths[1]);
        HalfVectorDensity {
            // Neither is left out: each is what the other's density is too thin for.
            reflection: 0.05 + 0.9 * kept * (1.0 / 3.0),
            width: safe_sqrt(diffracted * diffracted + sqr(lobe.microfacets().alpha.x)),
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

    /// A half vector that faces `wi`.
    #[inline]
    fn sample_normal(&self, wi: Vec3, u: Vec2) -> Vec3 {
        let slope = v_cavity::sample_azimuth(wi, self.sample_radius(u.y), u.x);
        Vec3::new(slope.x, slope.y, 1.0).normalize_or_zero()
    }

    /// The slope at the quantile `u`.
    #[inline]
    fn sample_radius(&self, u: f32) -> f32 {
        let q = pow((1.0 - u).max(6e-8), -2.0 / (self.c - 1.0));
        self.width * safe_sqrt(q - 1.0)
    }
}

/// Fills a table of [`super::diffraction_table::WORDS`] words for facets of width `alpha` and exponent `exponent`, energy
/// limits included. Runs on the host when a scene is built, in about a quarter of a second.
#[cfg(not(target_arch = "spirv"))]
pub fn fill_table(scale: &FineScale, alpha: f32, exponent: f32, out: &mut [f32]) {
    use super::diffraction_table::{COSINES, fill_spectrum, set_energy_limit};
    fill_spectrum(scale, alpha, exponent, out);
    let lobe = Lobe {
        distribution: crate::scene::distribution::EXPONENTIAL_POWER,
        alpha: Vec2::splat(alpha),
        exponent,
        table: 0,
        ..Lobe::NONE
    };
    for k in 0..COSINES {
        let cos = (k as f32 / (COSINES - 1) as f32).max(1e-3);
        let wi = Vec3::new(safe_sqrt((1.0 - cos) * (1.0 + cos)), 0.0, cos);
        let (reflected, diffracted) = albedos(&lobe, out, scale, wi);
        for c in 0..3 {
            let room = (1.0 - reflected[c]).max(0.0) / diffracted[c].max(1e-12);
            set_energy_limit(out, c, k, room.min(1.0) as f32);
        }
    }
}

/// What a lossless surface reflects and what it diffracts, by the midpoint rule over the samplers' square.
#[cfg(not(target_arch = "spirv"))]
fn albedos(lobe: &Lobe, data: &[f32], scale: &FineScale, wi: Vec3) -> ([f64; 3], [f64; 3]) {
    const NODES: u32 = 40;
    let facets = lobe.microfacets();
    let law = HalfVectorDensity::new(lobe, data, wi.z);
    let (mut reflected, mut diffracted) = ([0.0; 3], [0.0; 3]);
    for node in 0..NODES * NODES {
        let (x, y) = ((node % NODES) as f32, (node / NODES) as f32);
        let u = Vec2::new(x + 0.5, y + 0.5) * (1.0 / NODES as f32);
        let m = facets.sample_visible_normal(wi, u);
        let wo = reflect(wi, m);
        if wo.z > 0.0 && wi.dot(m) > 0.0 {
            let weight = facets.visible_normal_weight(wi, m) * wo.z / facets.projected_area(wo);
            for c in 0..3 {
                let kept = parts(data, 0, scale, c, wi.dot(m), m).0;
                reflected[c] += f64::from(kept * weight);
            }
        }
        let h = law.sample_normal(wi, u);
        let wo = reflect(wi, h);
        let cos_d = wi.dot(h);
        if wo.z > 0.0 && cos_d > 0.0 && h.z > 0.0 {
            let pdf = law.distribution(h) * v_cavity::facing_area(wi, h) * 0.25 / cos_d;
            let area = facets.projected_area(wi) * facets.projected_area(wo);
            for c in 0..3 {
                let f = parts(data, 0, scale, c, cos_d, h).1 * wi.z * wo.z / area;
                diffracted[c] += f64::from(f * wo.z / pdf.max(1e-30));
            }
        }
    }
    let nodes = f64::from(NODES * NODES);
    (reflected.map(|x| x / nodes), diffracted.map(|x| x / nodes))
}
