//! Upper bounds of microfacet BSDFs and the roughness that keeps them below a threshold.
//!
//! Jendersie and Grosch 2019, "Microfacet Model Regularization for Robust Light Transport", equations 1, 8, 9, with F
//! = 1:
//!
//! `rho_r(alpha) = G(alpha) / (4 pi alpha^2)`, `rho_t(alpha) = K G(alpha) / (pi alpha^2)`, `K = max(n_i, n_t)^2 / (n_i
//! - n_t)^2`,
//!
//! where G bounds masking over cosines, `G2 / (cos_i cos_o)`. Their inverses alpha_hat(tau), K as above:
//!
//! | | G | reflection | refraction |
//! |---|---|---|---|
//! | V-cavity | 1 | (4 pi tau)^(-1/2) | (K / (pi tau))^(1/2) |
//! | Smith, GGX | 4 / alpha^2 | (pi tau)^(-1/4) | (4 K / (pi tau))^(1/4) |
//! | Smith, Beckmann or cosine | 4 pi / alpha^2 | tau^(-1/4) | (4 K / tau)^(1/4) |
//!
//! The cosine distribution is [`kinds::PHONG`]; other distributions than these three take Beckmann's here, see
//! [`super::power_bounds`] for the exponential power distribution.
//!
//! Anisotropic: `1 / (pi alpha_x alpha_y)` is the peak and the smaller alpha bounds masking; the bound falls in both,
//! so that each axis may be raised to alpha_hat on its own.
//!
//! Where it holds (tests search adversarially, to elevations of 1e-8):
//! - separable Smith masking, GGX with alpha <= 1, the cosine distribution with alpha <= 1, Beckmann with alpha <=
//!   1/sqrt(2). Reflection is tight, at grazing mirror pairs. Refraction is loose by G: the core `|i.h o.h| / (i.h +
//!   eta o.h)^2` peaks at normal incidence, masking at grazing angles, and where both are large D is small.
//!   [`tight_refraction_bound`] is `K / (pi alpha^2)`, as for V-cavities, times what grazing normals add: `max(1, 4
//!   alpha^2)` for GGX (attained), `1 + 6 alpha^2` for Beckmann, `1 + 12 alpha^2` for the cosine distribution (largest
//!   values 1 + 5.8 alpha^2 and 1 + 11.6 alpha^2, at alpha = 1), for alpha up to 1 and relative indices up to 4; beyond
//!   them 1 is 1.6 for the latter two (1.52 as eta grows without end). Proved, GGX's but for two percent, by a
//!   reduction to two angles and monotone bounds over boxes of all four parameters:
//!   `kernel/tests/regularize_refraction_proof.rs`.
//! - Beckmann above 1/sqrt(2): the peak of D leaves the normal, a factor `4 alpha^4 exp(1/alpha^2 - 2)`, up to 1.47 at
//!   alpha = 1; GGX above 1: a factor alpha^4. [`peak_excess`] has both; alpha_hat is clamped to 1.
//! - V-cavity: a heuristic for normal incidence only, the BSDF diverges as 1/cos^2 at grazing mirror pairs.
//! - height-correlated Smith masking: no bound exists, G2 / (cos_i cos_o) diverges at grazing angles. The kernel's
//!   masking is separable.
//! - equal indices: K is infinite. Such a boundary is absent and is handled apart, not regularised.
//!
//! tau and the bounds are per steradian; `eta` is transmitted over incident index, and its inverse gives the same K.

use super::bandwidth::TAU_MAX;
use crate::math::float::{exp, sqrt};
use crate::scene::distribution as kinds;
use core::f32::consts::{FRAC_1_PI, PI};
use glam::Vec2;

/// Masking by V-cavities (Torrance and Sparrow 1967).
pub const V_CAVITY: u32 = 0;
/// Separable masking of Smith.
pub const SMITH: u32 = 1;

/// Largest alpha that regularisation yields.
pub const ALPHA_MAX: f32 = 1.0;

/// Smallest alpha that bounds take: a mirror's bound is [`TAU_MAX`].
const ALPHA_TINY: f32 = 1e-9;

/// Coefficient c of the bound of masking over both cosines: `c / alpha^2` for Smith.
#[inline]
fn smith_coefficient(distribution: u32) -> f32 {
    if distribution == kinds::GGX {
        4.0
    } else {
        4.0 * PI
    }
}

/// Bound G(alpha) of `G2 / (cos_i cos_o)`; `alpha` is the smaller of two axes.
#[inline]
pub fn masking_bound(masking: u32, distribution: u32, alpha: f32) -> f32 {
    if masking == V_CAVITY {
        return 1.0;
    }
    let alpha = alpha.max(ALPHA_TINY);
    smith_coefficient(distribution) / (alpha * alpha)
}

/// How far the largest D exceeds its value along the normal: 1 up to alpha = 1/sqrt(2) for Beckmann and 1 for GGX.
#[inline]
pub fn peak_excess(distribution: u32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    if distribution == kinds::GGX {
        if alpha > 1.0 { a2 * a2 } else { 1.0 }
    } else if distribution == kinds::PHONG || a2 <= 0.5 {
        1.0
    } else {
        // The peak is at cos^2 = 1 / (2 alpha^2).
        4.0 * a2 * a2 * exp(1.0 / a2 - 2.0)
    }
}

/// Largest relative squared index, `max(1, eta)^2 / (eta - 1)^2`; [`TAU_MAX`] at equal indices.
#[inline]
pub fn refraction_factor(eta: f32) -> f32 {
    let difference = eta - 1.0;
    let larger = if eta > 1.0 { eta } else { 1.0 };
    let ratio = larger / difference;
    // Equal indices divide by zero, and a large square overflows.
    if !(ratio * ratio < TAU_MAX) {
        return TAU_MAX;
    }
    ratio * ratio
}

/// Peak of D times the bound of masking.
#[inline]
fn microfacet_bound(masking: u32, distribution: u32, alpha: Vec2) -> f32 {
    let a = alpha.max(Vec2::splat(ALPHA_TINY));
    // Factor by factor: the product of four small roughnesses underflows.
    FRAC_1_PI / a.x / a.y * masking_bound(masking, distribution, a.x.min(a.y))
}

/// Equation 8: bound of a reflecting BSDF.
#[inline]
pub fn reflection_bound(masking: u32, distribution: u32, alpha: Vec2) -> f32 {
    (0.25 * microfacet_bound(masking, distribution, alpha)).min(TAU_MAX)
}

/// Equation 9: bound of a refracting BSDF, for radiance and for importance.
#[inline]
pub fn refraction_bound(masking: u32, distribution: u32, alpha: Vec2, eta: f32) -> f32 {
    let bound = microfacet_bound(masking, distribution, alpha);
    // In this order no product overflows.
    if bound > TAU_MAX {
        return TAU_MAX;
    }
    (bound * refraction_factor(eta)).min(TAU_MAX)
}

/// The roughness at which `coefficient / alpha^2` (V-cavity) or `coefficient / alpha^4` (Smith) is `tau`.
#[inline]
fn invert(masking: u32, coefficient: f32, tau: f32) -> f32 {
    if !(tau > 0.0) {
        return ALPHA_MAX;
    }
    let root = sqrt(coefficient / tau.max(1e-12).min(TAU_MAX));
    let alpha = if masking == V_CAVITY {
        root
    } else {
        sqrt(root)
    };
    if alpha < ALPHA_MAX { alpha } else { ALPHA_MAX }
}

/// Coefficient of the inverse powers of alpha in the bound.
#[inline]
fn coefficient(masking: u32, distribution: u32) -> f32 {
    if masking == V_CAVITY {
        FRAC_1_PI
    } else {
        FRAC_1_PI * smith_coefficient(distribution)
    }
}

/// alpha_hat(tau) of a reflecting BSDF: the smallest isotropic roughness with [`reflection_bound`] at most `tau`, at
/// most [`ALPHA_MAX`].
#[inline]
pub fn reflection_alpha(masking: u32, distribution: u32, tau: f32) -> f32 {
    invert(masking, 0.25 * coefficient(masking, distribution), tau)
}

/// alpha_hat(tau) of a refracting BSDF, at most [`ALPHA_MAX`].
#[inline]
pub fn refraction_alpha(masking: u32, distribution: u32, tau: f32, eta: f32) -> f32 {
    let c = coefficient(masking, distribution) * refraction_factor(eta);
    invert(masking, c, tau)
}

/// What `1 / alpha^2` is times in the tight bound of Beckmann's and of the cosine distribution: large indices turn grazing
/// directions into steep ones, which are not masked.
#[inline]
fn steep_share(eta: f32) -> f32 {
    if eta > 4.0 || eta < 0.25 { 1.6 } else { 1.0 }
}

/// What grazing normals add to `1 / alpha^2` there.
#[inline]
fn grazing_share(distribution: u32) -> f32 {
    if distribution == kinds::PHONG {
        12.0
    } else {
        6.0
    }
}

/// Bound of an isotropic refracting BSDF with separable Smith masking, without the looseness of equation 9.
#[inline]
pub fn tight_refraction_bound(distribution: u32, alpha: f32, eta: f32) -> f32 {
    let alpha = alpha.max(ALPHA_TINY);
    let inverse = 1.0 / (alpha * alpha);
    let k = FRAC_1_PI * refraction_factor(eta);
    let bound = if distribution == kinds::GGX {
        k * inverse.max(4.0)
    } else {
        k * (steep_share(eta) * inverse + grazing_share(distribution))
    };
    bound.min(refraction_bound(
        SMITH,
        distribution,
        Vec2::splat(alpha),
        eta,
    ))
}

/// alpha_hat(tau) of an isotropic refracting BSDF by [`tight_refraction_bound`], at most [`ALPHA_MAX`]: where grazing
/// normals alone exceed `tau` no roughness will do.
#[inline]
pub fn tight_refraction_alpha(distribution: u32, tau: f32, eta: f32) -> f32 {
    if !(tau > 0.0) {
        return ALPHA_MAX;
    }
    let x = PI * tau.min(TAU_MAX) / refraction_factor(eta);
    let inverse = if distribution == kinds::GGX {
        if x < 4.0 { 0.0 } else { x }
    } else {
        (x - grazing_share(distribution)) / steep_share(eta)
    };
    let alpha = if inverse > 1.0 {
        1.0 / sqrt(inverse)
    } else {
        ALPHA_MAX
    };
    // For the roughest lobes equation 9 may be the tighter.
    alpha.min(refraction_alpha(SMITH, distribution, tau, eta))
}

/// Both axes raised to `alpha_hat`, each on its own: a rougher axis keeps its look.
#[inline]
pub fn raise(alpha: Vec2, alpha_hat: f32) -> Vec2 {
    alpha.max(Vec2::splat(alpha_hat))
}
