//! Microfacet distributions: densities, masking, samples, local roughness.

use bytemuck::{Pod, Zeroable};
use halflight_kernel::bsdf::microfacet::Microfacets;
use halflight_kernel::glam::{Vec2, Vec3};

/// A distribution with directions and random numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MicrofacetInput {
    /// One of [`halflight_kernel::scene::distribution`].
    pub kind: u32,
    /// Width along both tangents.
    pub alpha: [f32; 2],
    /// Of the exponential power distribution.
    pub exponent: f32,
    /// A direction.
    pub w: [f32; 3],
    /// A unit normal.
    pub m: [f32; 3],
    /// Random numbers.
    pub u: [f32; 2],
}

/// What a function returns, zero beyond that.
pub type MicrofacetOutput = [f32; 8];

/// Names of the functions.
#[allow(missing_docs)]
pub mod microfacet {
    pub const VALUES: u32 = 0;
    pub const NORMAL: u32 = 1;
    pub const VISIBLE_NORMAL: u32 = 2;
}

/// Evaluates function `function` of [`microfacet`].
pub fn evaluate(function: u32, input: &MicrofacetInput) -> MicrofacetOutput {
    let facets = Microfacets::new(
        input.kind,
        Vec2::new(input.alpha[0], input.alpha[1]),
        input.exponent,
    );
    let w = Vec3::new(input.w[0], input.w[1], input.w[2]);
    let m = Vec3::new(input.m[0], input.m[1], input.m[2]);
    let u = Vec2::new(input.u[0], input.u[1]);
    match function {
        microfacet::VALUES => [
            facets.distribution(m),
            facets.projected_area(w),
            facets.smith_g1(w, m),
            facets.normal_pdf(m),
            facets.visible_normal_pdf(w, m),
            facets.visible_normal_weight(w, m),
            facets.local_alpha_squared(m),
            facets.ln_distribution_derivative(m),
        ],
        microfacet::NORMAL => normal(facets.sample_normal(u)),
        microfacet::VISIBLE_NORMAL => normal(facets.sample_visible_normal(w, u)),
        _ => [0.0; 8],
    }
}

fn normal(m: Vec3) -> MicrofacetOutput {
    [m.x, m.y, m.z, 0.0, 0.0, 0.0, 0.0, 0.0]
}
