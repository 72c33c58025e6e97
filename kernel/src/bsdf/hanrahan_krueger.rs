//! Light scattered once in a thin layer, and what passes the layer unscattered.
//!
//! Hanrahan and Krueger 1993, "Reflection from Layered Surfaces due to Subsurface Scattering", section 4, for a layer between
//! equal indices. With tau the optical depth along the normal, s that of scattering alone (tau times the albedo), and p the phase
//! function, the first order of scattering is
//!
//!   reflection:    f = p s / tau (1 - exp(-tau (A + B))) / (cos_i + cos_o),
//!   transmission:  f = p s / tau (exp(-tau A) - exp(-tau B)) / (cos_i - cos_o),
//!
//! A = 1 / cos_i, B = 1 / cos_o with absolute cosines; exp(-tau A) passes straight on, a discrete direction. Both are
//! `p s / (cos_i cos_o) e phi(x)`, phi(x) = (1 - exp(-x)) / x, with e = 1 and x = tau (A + B), or e = exp(-tau min(A, B)) and
//! x = tau |A - B|, a form without poles. Where light is scattered more than once it is lost, so the layer is darker than a medium.
//!
//! p is Henyey and Greenstein's, its mean cosine g in `exponent`; zero is isotropic. [`Lobe::distribution`], one of [`layer_parameters`], says
//! whether `reflectance` holds s and `specular_transmittance` the depth of absorption, or the albedo and tau. The layer looks
//! alike from both sides. Directions are drawn from p, or straight on with the probability of passing, the mean over channels;
//! densities per solid angle. Invariants (tests): reciprocity, the published forms, the furnace at most 1, and 1 where nothing
//! is absorbed in the limit of thin layers.

use super::{BsdfSample, Lobe, coat, event};
use crate::math::{Frame, Rgb, float};
use core::f32::consts::TAU;
use glam::{Vec2, Vec3};

/// What a record gives of the layer.
pub mod layer_parameters {
    /// Optical depths of scattering and of absorption.
    pub const DEPTHS: u32 = 0;
    /// The albedo and the whole optical depth.
    pub const ALBEDO: u32 = 1;
}

/// The thickest layer: nothing passes, and products stay finite.
pub const LARGEST_DEPTH: f32 = 1e6;

/// Largest mean cosine.
const MAX_G: f32 = 0.999;

/// Smallest cosine.
const MIN_COS: f32 = 1e-6;

/// The layer of a lobe.
#[derive(Clone, Copy)]
struct Layer {
    /// Optical depth of scattering.
    scattering: Vec3,
    /// Optical depth.
    depth: Vec3,
}

#[inline]
fn layer(lobe: &Lobe) -> Layer {
    let limited = |v: Vec3| v.max(Vec3::ZERO).min(Vec3::splat(LARGEST_DEPTH));
    if lobe.distribution == layer_parameters::ALBEDO {
        let depth = limited(lobe.specular_transmittance);
        Layer {
            scattering: lobe.reflectance.max(Vec3::ZERO).min(Vec3::ONE) * depth,
            depth,
        }
    } else {
        let scattering = limited(lobe.reflectance);
        Layer {
            scattering,
            depth: scattering + limited(lobe.specular_transmittance),
        }
    }
}

/// (1 - exp(-x)) / x for x >= 0.
#[inline]
fn phi(x: f32) -> f32 {
    if x < 1e-6 {
        1.0
    } else {
        -float::exp_m1(-x) / x
    }
}

/// Henyey and Greenstein's phase function of the cosine between the directions of travel.
#[inline]
fn henyey_greenstein(g: f32, cos: f32) -> f32 {
    // 1 + g^2 - 2 g cos without the cancellation.
    let base = float::sqr(1.0 - g) + 2.0 * g * (1.0 - cos);
    (1.0 - g) * (1.0 + g) / (2.0 * TAU * base * float::sqrt(base))
}

/// The mean cosine of the phase function.
#[inline]
fn mean_cosine(lobe: &Lobe) -> f32 {
    lobe.exponent.max(-MAX_G).min(MAX_G)
}

/// The share that passes at an incident cosine.
#[inline]
fn transmitted_share(layer: &Layer, cos: f32) -> Rgb {
    coat::absorption(layer.depth, float::abs(cos).max(MIN_COS))
}

/// Probability of a sample straight on: all where nothing is scattered.
#[inline]
fn straight_probability(passed: Rgb) -> f32 {
    (passed.x + passed.y + passed.z) / 3.0
}

/// The factor on the phase function.
#[inline]
fn attenuated(layer: &Layer, wi: Vec3, wo: Vec3) -> Rgb {
    let (cos_i, cos_o) = (float::abs(wi.z).max(MIN_COS), float::abs(wo.z).max(MIN_COS));
    let (a, b) = (1.0 / cos_i, 1.0 / cos_o);
    let (before, x) = if wi.z * wo.z > 0.0 {
        (0.0, a + b)
    } else {
        (a.min(b), float::abs(a - b))
    };
    let along = |depth: f32| float::exp(-depth * before) * phi(depth * x);
    let factor = Vec3::new(
        along(layer.depth.x),
        along(layer.depth.y),
        along(layer.depth.z),
    );
    layer.scattering * factor * (a * b)
}

/// The scattered part of the BSDF, without a cosine.
#[inline]
pub fn eval(lobe: &Lobe, wi: Vec3, wo: Vec3) -> Rgb {
    if wi.z == 0.0 || wo.z == 0.0 {
        return Vec3::ZERO;
    }
    attenuated(&layer(lobe), wi, wo) * henyey_greenstein(mean_cosine(lobe), -wi.dot(wo))
}

/// Density of the scattered part of [`sample`] per solid angle.
#[inline]
pub fn pdf(lobe: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    if wi.z == 0.0 || wo.z == 0.0 {
        return 0.0;
    }
    let q = straight_probability(transmitted_share(&layer(lobe), wi.z));
    (1.0 - q) * henyey_greenstein(mean_cosine(lobe), -wi.dot(wo))
}

/// Straight on where `u1` is below the probability of passing, or a direction of the phase function.
#[inline]
pub fn sample(lobe: &Lobe, wi: Vec3, u1: f32, u2: Vec2) -> BsdfSample {
    if wi.z == 0.0 {
        return BsdfSample::NONE;
    }
    let layer = layer(lobe);
    let passed = transmitted_share(&layer, wi.z);
    let q = straight_probability(passed);
    if u1 < q {
        return BsdfSample {
            wo: -wi,
            weight: passed / q,
            pdf: q,
            eta: 1.0,
            event: event::TRANSMISSION | event::DELTA,
        };
    }
    let g = mean_cosine(lobe);
    let cos = sample_cosine(g, u2.x);
    let sin = float::safe_sqrt(1.0 - cos * cos);
    let (sin_phi, cos_phi) = float::sin_cos(TAU * u2.y);
    let along = Frame::from_normal(-wi);
    let wo = along
        .to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos))
        .normalize();
    // The density of the direction as it was rounded, which `pdf` will see.
    let density = henyey_greenstein(g, -wi.dot(wo));
    let pdf = (1.0 - q) * density;
    if wo.z == 0.0 || !(pdf > 0.0) {
        return BsdfSample::NONE;
    }
    let side = if wi.z * wo.z > 0.0 {
        event::REFLECTION
    } else {
        event::TRANSMISSION
    };
    BsdfSample {
        wo,
        weight: attenuated(&layer, wi, wo) * (float::abs(wo.z) / (1.0 - q)),
        pdf,
        eta: 1.0,
        event: side | event::GLOSSY,
    }
}

/// A cosine of the phase function.
#[inline]
fn sample_cosine(g: f32, u: f32) -> f32 {
    let cos = if float::abs(g) < 1e-3 {
        // To first order in g.
        let mu = 1.0 - 2.0 * u;
        mu + 1.5 * g * (1.0 - mu * mu)
    } else {
        let ratio = (1.0 - g) * (1.0 + g) / (1.0 - g + 2.0 * g * (1.0 - u));
        (1.0 + g * g - ratio * ratio) / (2.0 * g)
    };
    cos.max(-1.0).min(1.0)
}

/// At most what the layer returns: what passes, and all that is scattered once.
#[inline]
pub fn albedo(lobe: &Lobe, wi: Vec3) -> Rgb {
    let layer = layer(lobe);
    let passed = transmitted_share(&layer, wi.z);
    let albedo = layer.scattering / layer.depth.max(Vec3::splat(1e-20));
    passed + (Vec3::ONE - passed) * albedo.min(Vec3::ONE)
}
