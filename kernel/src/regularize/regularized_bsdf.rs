//! The regularised BSDF: the model evaluated at a roughness that keeps it below tau, and the density that goes with it.
//!
//! `f_hat = f(max(alpha, alpha_hat(tau)))` (Jendersie and Grosch 2019, equation 1 and below), for connections and
//! merges only; walks sample the model as it is. Specular lobes become rough ones of roughness alpha_hat, so that they
//! have a value at all:
//!
//! | lobe | regularised |
//! |---|---|
//! | conductor, rough conductor | rough conductor |
//! | dielectric, rough dielectric | rough dielectric, alpha_hat of reflection or of refraction by the pair of directions |
//! | plastic, rough plastic, coat, rough coat | rough; only the coating is regularised |
//! | thin dielectric | constant cones of value tau around both discrete directions (thesis, section 6.2.2) |
//! | Phong, Ward, principled and other models of no microfacets, MERL, measured | unchanged: no roughness of known bound |
//! | diffuse, null, equal indices | unchanged: nothing to regularise, or no boundary |
//!
//! Refraction at isotropic boundaries takes the tight bound, which blurs less than equation 9 for the same tau (see
//! [`bounds`]).
//!
//! The exponential power distribution has no bound in the paper, its own is in [`super::power_bounds`].
//!
//! Multiple importance sampling takes the artificial density `p_hat = (f_hat / f) p` (equation 13), p that of the
//! technique which the walk would have used. It is the density of the regularised lobe times a ratio of masking, for
//! the technique:
//! - visible normals: `G1_alpha_hat(wo) / G1_alpha(wo)`, wo the sampled direction;
//! - all normals (`D cos`), and normals of V-cavities (Phong, exponential power): `G2_alpha_hat / G2_alpha`;
//! - a specular lobe: `G1_alpha_hat(wo)`, the limit alpha -> 0 of the first.
//!
//! G1 = |cos| / A with projected areas A, so that the ratio is A_alpha / A_alpha_hat, without a pole. p_hat is a
//! weight, not the density of a sampler: it integrates to less than one by the masking that regularisation adds. The
//! density that does is `lobe::pdf` of [`regularized_lobe`]. Per solid angle. Invariants (tests): `p_hat f = f_hat p`;
//! nothing changes for rough lobes or tau = TAU_MAX; the furnace of a regularised mirror tends to the mirror's as tau
//! grows.

use super::bandwidth::TAU_MAX;
use super::{bounds, cone, mollifier, power_bounds};
use crate::bsdf::microfacet::Microfacets;
use crate::bsdf::{Bsdf, Lobe, lobe, plastic, rough_dielectric, rough_plastic};
use crate::math::Rgb;
use crate::math::float::abs;
use crate::scene::{NONE, distribution as kinds, lobe_flag, lobe_kind};
use core::f32::consts::FRAC_1_PI;
use glam::{Vec2, Vec3};

/// Whether the boundary has equal indices, which leaves nothing to refract.
#[inline]
pub fn is_index_matched(lobe: &Lobe) -> bool {
    (lobe.kind == lobe_kind::DIELECTRIC || lobe.kind == lobe_kind::ROUGH_DIELECTRIC)
        && abs(lobe.eta.x - 1.0) <= rough_dielectric::INDEX_MATCHED
}

/// Whether both axes are equally rough, or smooth; only then the tight bound of refraction applies.
#[inline]
fn is_isotropic(lobe: &Lobe) -> bool {
    lobe.kind == lobe_kind::DIELECTRIC || lobe.alpha.x == lobe.alpha.y
}

/// alpha_hat(tau) of the lobe's own model; zero where nothing is regularised.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn alpha_hat(lobe: &Lobe, transmission: bool, tau: f32) -> f32 {
    if !(tau < TAU_MAX) || is_index_matched(lobe) {
        return 0.0;
    }
    let refracts = lobe.kind == lobe_kind::DIELECTRIC || lobe.kind == lobe_kind::ROUGH_DIELECTRIC;
    if !refracts && !reflects_at_microfacets(lobe.kind) {
        return 0.0;
    }
    let distribution = distribution_of(lobe);
    if distribution == kinds::EXPONENTIAL_POWER {
        let factor = if refracts && transmission {
            4.0 * bounds::refraction_factor(lobe.eta.x)
        } else {
            1.0
        };
        return power_bounds::alpha_hat(unit_bound(lobe) * factor, lobe.exponent, tau);
    }
    if !(refracts && transmission) {
        return bounds::reflection_alpha(bounds::SMITH, distribution, tau);
    }
    if is_isotropic(lobe) {
        bounds::tight_refraction_alpha(distribution, tau, lobe.eta.x)
    } else {
        bounds::refraction_alpha(bounds::SMITH, distribution, tau, lobe.eta.x)
    }
}

/// The distribution that the lobe has, or that a specular one is given: one whose visible normals are Smith's.
#[inline]
pub(super) fn distribution_of(lobe: &Lobe) -> u32 {
    if has_microfacets(lobe.kind) || lobe.distribution == kinds::GGX {
        lobe.distribution
    } else {
        kinds::BECKMANN
    }
}

/// `D(n) / (4 A^2)` at alpha = 1, A the projected area at grazing angles: U of [`super::power_bounds`].
#[inline]
fn unit_bound(lobe: &Lobe) -> f32 {
    let facets = Microfacets::new(lobe.distribution, Vec2::ONE, lobe.exponent);
    let area = facets.projected_area(Vec3::X);
    0.25 * facets.distribution(Vec3::Z) / (area * area)
}

/// The lobe whose value is at most `tau` for reflection or for `transmission` (times its colour). Thin dielectrics,
/// which have no rough model, stay as they are: see [`eval_cosine_pdf`].
pub fn regularized_lobe(lobe: &Lobe, transmission: bool, tau: f32) -> Lobe {
    let alpha = alpha_hat(lobe, transmission, tau);
    if alpha <= 0.0 {
        return *lobe;
    }
    roughened(lobe, alpha)
}

/// The lobe with microfacets of at least the roughness `alpha`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(super) fn roughened(lobe: &Lobe, alpha: f32) -> Lobe {
    let mut r = *lobe;
    let rough = match lobe.kind {
        lobe_kind::CONDUCTOR => lobe_kind::ROUGH_CONDUCTOR,
        lobe_kind::DIELECTRIC => lobe_kind::ROUGH_DIELECTRIC,
        lobe_kind::PLASTIC => lobe_kind::ROUGH_PLASTIC,
        lobe_kind::COAT => lobe_kind::ROUGH_COAT,
        _ => NONE,
    };
    if rough == NONE {
        r.alpha = bounds::raise(lobe.alpha, alpha);
        if r.alpha.x == r.alpha.y && lobe.alpha.x != lobe.alpha.y {
            // Normals of an anisotropic Phong lobe are sampled in another way than those of an isotropic one, and p_hat
            // belongs to the sampler of the lobe: it stays anisotropic by a few rounding errors.
            r.alpha.y *= 1.000_001;
        }
        return r;
    }
    r.kind = rough;
    r.distribution = distribution_of(lobe);
    r.alpha = Vec2::splat(alpha);
    r.flags &= !lobe_flag::SAMPLE_ALL_NORMALS;
    // Without a table the rough coating transmits as the smooth one does.
    r.table = NONE;
    r
}

/// Density p_hat of `regularized` over that of its own sampler: A_alpha / A_alpha_hat of the directions that its
/// technique masks. Directions in the frame of the lobe's model.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn masking_ratio(lobe: &Lobe, regularized: &Lobe, wi: Vec3, wo: Vec3) -> f32 {
    if !has_microfacets(regularized.kind) {
        return 1.0;
    }
    let ratio = ratio_along(lobe, regularized, wo);
    let all = lobe.flags & regularized.flags & lobe_flag::SAMPLE_ALL_NORMALS != 0;
    if all || !regularized.microfacets().has_smith_normals() {
        ratio * ratio_along(lobe, regularized, wi)
    } else {
        ratio
    }
}

#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn ratio_along(lobe: &Lobe, regularized: &Lobe, w: Vec3) -> f32 {
    own_area(lobe, w) / regularized.microfacets().projected_area(w)
}

/// Projected area A_alpha of the lobe itself.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(super) fn own_area(lobe: &Lobe, w: Vec3) -> f32 {
    // A smooth surface is not masked: its projected area is the cosine.
    if has_microfacets(lobe.kind) {
        lobe.microfacets().projected_area(w)
    } else {
        abs(w.z)
    }
}

#[inline]
fn has_microfacets(kind: u32) -> bool {
    kind == lobe_kind::ROUGH_CONDUCTOR
        || kind == lobe_kind::ROUGH_DIELECTRIC
        || kind == lobe_kind::ROUGH_PLASTIC
        || kind == lobe_kind::ROUGH_COAT
}

/// Whether the lobe only reflects, at microfacets or at a smooth surface.
#[inline]
fn reflects_at_microfacets(kind: u32) -> bool {
    kind == lobe_kind::CONDUCTOR
        || kind == lobe_kind::ROUGH_CONDUCTOR
        || kind == lobe_kind::PLASTIC
        || kind == lobe_kind::ROUGH_PLASTIC
        || kind == lobe_kind::COAT
        || kind == lobe_kind::ROUGH_COAT
}

/// f_hat |cos| of one lobe, not yet multiplied by its weight, and p_hat.
pub fn eval_cosine_pdf(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3, tau: f32) -> (Rgb, f32) {
    if !(tau < TAU_MAX) {
        return lobe::eval_cosine_pdf(lobe, data, wi, wo);
    }
    if lobe.kind == lobe_kind::THIN_DIELECTRIC {
        return thin_dielectric(lobe, data, wi, wo, tau);
    }
    let regularized = regularized_lobe(lobe, wi.z * wo.z < 0.0, tau);
    let (f, p) = lobe::eval_cosine_pdf(&regularized, data, wi, wo);
    (f, density(lobe, &regularized, data, [wi, wo], p))
}

/// p_hat of wo for wi where the sampler of the regularised lobe has the density `p`.
#[inline]
pub(super) fn density(
    lobe: &Lobe,
    regularized: &Lobe,
    data: &[f32],
    [wi, wo]: [Vec3; 2],
    p: f32,
) -> f32 {
    if p <= 0.0 {
        return 0.0;
    }
    let model = lobe::inner_pair(lobe, data, wi, wo);
    let pair = [model.wi, model.wo];
    density_of(lobe, regularized, data, pair, model.jacobian, p)
}

/// p_hat where the sampler of the regularised lobe has the density `p`; `wi` and `wo` in the frame of the model.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(super) fn density_of(
    lobe: &Lobe,
    regularized: &Lobe,
    data: &[f32],
    [wi, wo]: [Vec3; 2],
    jacobian: f32,
    p: f32,
) -> f32 {
    let ratio = masking_ratio(lobe, regularized, wi, wo);
    if regularized.kind != lobe_kind::ROUGH_PLASTIC {
        return p * ratio;
    }
    // The base is sampled as before.
    let reflected = 1.0 - rough_plastic::transmitted_share(regularized, data, wi.z);
    let q = plastic::specular_probability(regularized, wi.z, reflected);
    let base = ((1.0 - q) * wo.z.max(0.0) * FRAC_1_PI * jacobian).min(p);
    base + (p - base) * ratio
}

/// Cones of value `tau` around the reflected and the transmitted direction. What a cone has below the horizon is lost.
fn thin_dielectric(lobe: &Lobe, data: &[f32], wi: Vec3, wo: Vec3, tau: f32) -> (Rgb, f32) {
    let model = lobe::inner_pair(lobe, data, wi, wo);
    if !model.valid {
        return (Rgb::ZERO, 0.0);
    }
    let (colour, p) = thin_cones(lobe, model.wi, model.wo, tau);
    (colour * model.factor * p, p * model.jacobian)
}

/// The colour of the event that leads from `wi` to the side of `wo`, and the value of its cone times its probability, in the
/// frame of the model.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub(super) fn thin_cones(lobe: &Lobe, wi: Vec3, wo: Vec3, tau: f32) -> (Rgb, f32) {
    // The probability of each event is that of the sampler, which draws reflection first.
    let reflection = crate::bsdf::thin_dielectric::sample(lobe, wi, 0.0, Vec2::ZERO);
    let reflects = wi.z * wo.z > 0.0;
    let share = if reflection.wo.z * wi.z > 0.0 {
        reflection.pdf
    } else {
        0.0
    };
    let (axis, probability, colour) = if reflects {
        let mirrored = Vec3::new(-wi.x, -wi.y, wi.z);
        (mirrored, share, lobe.specular_reflectance)
    } else {
        (-wi, 1.0 - share, lobe.specular_transmittance)
    };
    let cap = cone::one_minus_cos_of_tau(tau);
    let p = probability * cone::eval(mollifier::CONSTANT, axis, wo, cap);
    (colour, p)
}

/// f_hat |cos| and p_hat of a material: the weighted sums over its lobes.
pub fn mixture_eval_cosine_pdf(
    bsdf: &Bsdf,
    data: &[f32],
    wi: Vec3,
    wo: Vec3,
    tau: f32,
) -> (Rgb, f32) {
    let mut f = Rgb::ZERO;
    let mut p = 0.0;
    for i in 0..bsdf.lobe_count() {
        let lobe = bsdf.lobe_at(i);
        let (lobe_f, lobe_p) = eval_cosine_pdf(lobe, data, wi, wo, tau);
        f += lobe_f * lobe.weight;
        p += lobe_p * bsdf.selection(i);
    }
    (f, p)
}

/// Bound of the lobe's own value for reflection or for `transmission`, per steradian; [`TAU_MAX`] for a discrete
/// direction and where none is known. Coats, which only attenuate, are left out. Oren and Nayar's model has no
/// bound: at equal elevations it is up to 1.1 times Lambert's value at 45 degrees, 1.7 at 20, 3 at 10 and 24 at 1. Twice that value is
/// taken, which holds from 17 degrees on. The heuristics use it, where a sharper path than it seems costs noise and no bias.
pub fn bound(lobe: &Lobe, transmission: bool) -> f32 {
    let diffuse = lobe.reflectance.max_element() * FRAC_1_PI;
    if transmission && lobe.kind == lobe_kind::ROUGH_DIELECTRIC && !is_index_matched(lobe) {
        if lobe.distribution == kinds::EXPONENTIAL_POWER {
            let factor = 4.0 * bounds::refraction_factor(lobe.eta.x);
            let bound = reflection(lobe);
            return if bound < TAU_MAX / factor {
                bound * factor
            } else {
                TAU_MAX
            };
        }
        return if is_isotropic(lobe) {
            bounds::tight_refraction_bound(lobe.distribution, lobe.alpha.x, lobe.eta.x)
        } else {
            bounds::refraction_bound(bounds::SMITH, lobe.distribution, lobe.alpha, lobe.eta.x)
        };
    }
    match lobe.kind {
        lobe_kind::DIELECTRIC
        | lobe_kind::ROUGH_DIELECTRIC
        | lobe_kind::THIN_DIELECTRIC
        | lobe_kind::NULL => {
            if lobe.kind == lobe_kind::ROUGH_DIELECTRIC && !is_index_matched(lobe) {
                reflection(lobe)
            } else {
                TAU_MAX
            }
        }
        lobe_kind::DIFFUSE_TRANSMISSION if transmission => {
            lobe.specular_transmittance.max_element() * FRAC_1_PI
        }
        lobe_kind::DIFFUSE_TRANSMISSION => 0.0,
        lobe_kind::THIN_TRANSMISSION if !transmission => 0.0,
        lobe_kind::THIN_TRANSMISSION | lobe_kind::HANRAHAN_KRUEGER => TAU_MAX,
        _ if transmission => 0.0,
        lobe_kind::DIFFUSE => diffuse,
        lobe_kind::ROUGH_DIFFUSE => 2.0 * diffuse,
        lobe_kind::ROUGH_CONDUCTOR | lobe_kind::ROUGH_COAT => reflection(lobe),
        lobe_kind::ROUGH_PLASTIC => {
            (reflection(lobe) + plastic::base(lobe).max_element()).min(TAU_MAX)
        }
        _ => TAU_MAX,
    }
}

/// Bound of reflection at the lobe's microfacets.
#[inline]
fn reflection(lobe: &Lobe) -> f32 {
    if lobe.distribution != kinds::EXPONENTIAL_POWER {
        let bound = bounds::reflection_bound(bounds::SMITH, lobe.distribution, lobe.alpha);
        let excess = bounds::peak_excess(lobe.distribution, lobe.alpha.max_element());
        return (bound * excess).min(TAU_MAX);
    }
    let alpha = lobe.microfacets().alpha;
    let least = alpha.x.min(alpha.y);
    let excess = power_bounds::peak_excess(alpha.x.max(alpha.y), lobe.exponent);
    (unit_bound(lobe) / alpha.x / alpha.y / (least * least) * excess).min(TAU_MAX)
}

/// [`bound`] of a material: the weighted sum over its lobes, at most [`TAU_MAX`].
pub fn mixture_bound(bsdf: &Bsdf, transmission: bool) -> f32 {
    let mut sum = 0.0;
    for i in 0..bsdf.lobe_count() {
        let lobe = bsdf.lobe(i);
        sum += bound(&lobe, transmission) * lobe.weight;
    }
    if sum < TAU_MAX { sum } else { TAU_MAX }
}
