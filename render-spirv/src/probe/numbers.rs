//! Functions of a few numbers: floats, Fresnel, regularisation, filters, random numbers.

use bytemuck::{Pod, Zeroable};
use halflight_kernel::bsdf::fresnel;
use halflight_kernel::glam::Vec2;
use halflight_kernel::math::{Rgb, filter, float, scaled::Scaled};
use halflight_kernel::regularize::heuristic::{self, PathDiffusion, SamplerQuality};
use halflight_kernel::regularize::{bandwidth, bounds, mollifier};
use halflight_kernel::sampler::{AnySampler, Sampler};

/// Arguments: numbers, then indices, kinds and seeds.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct NumberInput {
    /// Numbers, of which a function takes the first few.
    pub x: [f32; 8],
    /// Indices, kinds and seeds, likewise.
    pub k: [u32; 4],
}

/// What a function returns, zero beyond that.
pub type NumberOutput = [f32; 8];

/// Names of the functions.
#[allow(missing_docs)]
pub mod number {
    pub const SQRT: u32 = 0;
    pub const SIN: u32 = 1;
    pub const COS: u32 = 2;
    pub const TAN: u32 = 3;
    pub const ATAN: u32 = 4;
    pub const EXP: u32 = 5;
    pub const LN: u32 = 6;
    pub const CEIL: u32 = 7;
    pub const FLOOR: u32 = 8;
    pub const ATAN2: u32 = 9;
    pub const POW: u32 = 10;
    pub const ERF: u32 = 11;
    pub const ERFC_SCALED: u32 = 12;
    pub const ERF_INV: u32 = 13;
    pub const GAMMA_1P: u32 = 14;
    pub const INVERSE_GAMMA: u32 = 15;
    pub const SCALED_PRODUCT: u32 = 16;
    pub const FRESNEL_DIELECTRIC: u32 = 17;
    pub const FRESNEL_CONDUCTOR: u32 = 18;
    pub const FRESNEL_DIFFUSE: u32 = 19;
    pub const FILTER: u32 = 20;
    pub const SAMPLER: u32 = 21;
    pub const MOLLIFIER: u32 = 22;
    pub const MOLLIFIER_RADIUS: u32 = 23;
    pub const BANDWIDTH: u32 = 24;
    pub const BOUNDS: u32 = 25;
    pub const ALPHA_HAT: u32 = 26;
    pub const HEURISTICS: u32 = 27;
}

/// Evaluates function `function` of [`number`].
pub fn evaluate(function: u32, input: &NumberInput) -> NumberOutput {
    let [x, y, z, w, ..] = input.x;
    let [k, l, m, n] = input.k;
    match function {
        number::SQRT => one(float::sqrt(x)),
        number::SIN => one(float::sin(x)),
        number::COS => one(float::cos(x)),
        number::TAN => one(float::tan(x)),
        number::ATAN => one(float::atan(x)),
        number::EXP => one(float::exp(x)),
        number::LN => one(float::ln(x)),
        number::CEIL => one(float::ceil(x)),
        number::FLOOR => one(float::floor(x)),
        number::ATAN2 => one(float::atan2(x, y)),
        number::POW => one(float::pow(x, y)),
        number::ERF => one(float::erf(x)),
        number::ERFC_SCALED => one(float::erfc_scaled(x)),
        number::ERF_INV => one(float::erf_inv(x)),
        number::GAMMA_1P => one(float::gamma_1p(x)),
        number::INVERSE_GAMMA => one(float::inverse_gamma_distribution(x, y)),
        number::SCALED_PRODUCT => {
            let p = Scaled::ONE.times(x).times(y).times(z);
            let q = p.over(Scaled::ONE.times(w));
            four(p.mantissa, p.exponent as f32, q.ln_abs(), q.value())
        }
        number::FRESNEL_DIELECTRIC => {
            let (reflectance, cos_t) = fresnel::fresnel_dielectric(x, y);
            four(reflectance, cos_t, fresnel::relative_eta(x, y), 0.0)
        }
        number::FRESNEL_CONDUCTOR => {
            let [c, a, b, d, e, f, g, _] = input.x;
            let r = fresnel::fresnel_conductor(c, Rgb::new(a, b, d), Rgb::new(e, f, g));
            four(r.x, r.y, r.z, 0.0)
        }
        number::FRESNEL_DIFFUSE => one(fresnel::fresnel_diffuse_reflectance(x)),
        number::FILTER => {
            let parameters = [y, z, w];
            four(
                filter::eval(k, parameters, x),
                filter::radius(k, parameters),
                0.0,
                0.0,
            )
        }
        number::SAMPLER => sampler(k, l, m, n),
        number::MOLLIFIER => [
            mollifier::eval(k, l, x),
            mollifier::eval_scaled(k, l, x, y),
            mollifier::radial_cdf(k, l, x),
            mollifier::radial_moment(k, l, m),
            mollifier::second_moment(k, l),
            mollifier::square_norm(k, l),
            mollifier::normalization(k, l),
            0.0,
        ],
        number::MOLLIFIER_RADIUS => one(mollifier::sample_radius(k, l, x)),
        number::BANDWIDTH => [
            bandwidth::power_law(x, k, y),
            bandwidth::geometric(x, y, k),
            bandwidth::cone_tangent(z),
            bandwidth::cone_value(w),
            bandwidth::tau_schedule(z, k),
            bandwidth::largest_exponent(l),
            bandwidth::optimal_exponent(l),
            0.0,
        ],
        number::BOUNDS => {
            let alpha = Vec2::new(x, y);
            [
                bounds::masking_bound(k, l, x),
                bounds::peak_excess(l, x),
                bounds::refraction_factor(z),
                bounds::reflection_bound(k, l, alpha),
                bounds::refraction_bound(k, l, alpha, z),
                bounds::tight_refraction_bound(l, x, z),
                0.0,
                0.0,
            ]
        }
        number::ALPHA_HAT => {
            let raised = bounds::raise(Vec2::new(y, z), bounds::reflection_alpha(k, l, x));
            [
                bounds::reflection_alpha(k, l, x),
                bounds::refraction_alpha(k, l, x, w),
                bounds::tight_refraction_alpha(l, x, w),
                raised.x,
                raised.y,
                0.0,
                0.0,
                0.0,
            ]
        }
        number::HEURISTICS => heuristics(input.x),
        _ => [0.0; 8],
    }
}

fn one(x: f32) -> NumberOutput {
    four(x, 0.0, 0.0, 0.0)
}

fn four(x: f32, y: f32, z: f32, w: f32) -> NumberOutput {
    [x, y, z, w, 0.0, 0.0, 0.0, 0.0]
}

/// Numbers of both samplers, in the order in which a path mixes them.
fn sampler(kind: u32, seed: u32, pixel: u32, sample: u32) -> NumberOutput {
    let mut s = AnySampler::new(kind, seed, pixel, sample);
    let a = s.next_1d();
    let b = s.next_2d();
    let c = s.next_2d();
    let d = s.next_1d();
    let e = s.next_2d();
    [a, b.x, b.y, c.x, c.y, d, e.x, e.y]
}

/// The qualities of a path of three vertices.
fn heuristics(x: [f32; 8]) -> NumberOutput {
    let [rho0, rho1, d0, d1, curvature, tau, off, _] = x;
    let mut quality = SamplerQuality::EMPTY;
    quality.add(rho0, rho1, d0);
    quality.add(rho1, rho0, d1);
    let mut diffusion = PathDiffusion::SHARP;
    diffusion.scatter(rho0, curvature);
    diffusion.travel(d0);
    diffusion.scatter(rho1, curvature);
    diffusion.travel(d1);
    let q = quality.value();
    [
        q,
        heuristic::quality_threshold(tau, q),
        heuristic::smooth_quality_threshold(tau, q, off),
        diffusion.direction,
        diffusion.position,
        heuristic::diffusion_threshold(tau, &diffusion),
        0.0,
        0.0,
    ]
}
