//! Virtual merging: regularisation by a random acceptance instead of a rougher model.
//!
//! To connect a vertex along w, its BSDF is sampled once; if the sample lies in the cone of value tau around w, the
//! connection contributes `tau f_s |cos_s| / p_s`, else nothing (Jendersie and Grosch 2019, section 3.6, after
//! Kaplanyan and Dachsbacher 2013). Its expectation is the BSDF convolved with the constant cone,
//!
//! `E = integral f(w') |cos'| tau [w' in cone(w)] dw'`,
//!
//! because the cone's solid angle is 1 / tau. It keeps the model's shape where the mollified one redistributes energy
//! into its tails, at the price of variance and of two more random numbers, and it works for any BSDF, discrete
//! directions included. For multiple importance sampling the density at the vertex is replaced by tau, which is what
//! the acceptance makes of the sampler's own p_s; not optimal, the paper says. Invariant (tests): the mean of a
//! diffuse lobe is its value, that of a mirror the cone's.

use super::cone;
use crate::bsdf::BsdfSample;
use crate::math::Rgb;
use glam::Vec3;

/// What a virtual merge yields.
#[derive(Clone, Copy, Debug)]
pub struct VirtualMerge {
    /// Stands for f |cos| of the connection.
    pub value: Rgb,
    /// Stands for the density of the vertex; zero when rejected.
    pub pdf: f32,
}

impl VirtualMerge {
    /// Rejected.
    pub const NONE: VirtualMerge = VirtualMerge {
        value: Rgb::ZERO,
        pdf: 0.0,
    };
}

/// Accepts or rejects the connection along the unit vector `w` by the sample `s` of its BSDF.
#[inline]
pub fn virtual_merge(s: &BsdfSample, w: Vec3, tau: f32) -> VirtualMerge {
    if s.pdf <= 0.0 || !(tau > 0.0) {
        return VirtualMerge::NONE;
    }
    let tau = tau.min(super::bandwidth::TAU_MAX);
    // 1 - cos from the chord, which keeps its digits for narrow cones.
    let distance = 0.5 * (s.wo - w).length_squared();
    if distance >= cone::one_minus_cos_of_tau(tau) {
        return VirtualMerge::NONE;
    }
    // Below a quarter of 1 / pi the cone is the whole sphere and cannot be larger.
    let value = cone::eval(
        super::mollifier::CONSTANT,
        s.wo,
        s.wo,
        cone::one_minus_cos_of_tau(tau),
    );
    VirtualMerge {
        value: s.weight * value,
        pdf: value,
    }
}
