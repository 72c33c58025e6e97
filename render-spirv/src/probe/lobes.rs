//! Probes of single lobes: value and density, samples, albedo, bounds.

use bytemuck::{Pod, Zeroable};
use halflight_kernel::bsdf::{Coat, Lobe, event, lobe};
use halflight_kernel::glam::{Vec2, Vec3};
use halflight_kernel::math::Frame;
use halflight_kernel::regularize::regularized_bsdf;
use halflight_kernel::scene::MAX_COATS;
use halflight_kernel::scene::lobe_kind;

/// A coat.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct CoatInput {
    /// Index over that of its surroundings.
    pub eta: f32,
    /// Absorption coefficient times thickness.
    pub optical_depth: [f32; 3],
    /// Roughness, for the table.
    pub alpha: f32,
    /// First word of its table, or `NONE`.
    pub table: u32,
    /// Rows of the table.
    pub table_rows: u32,
}

/// A lobe with its parameters looked up ([`Lobe`], in whose order the fields are), directions, and random numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct LobeInput {
    pub kind: u32,
    pub distribution: u32,
    pub flags: u32,
    /// Normal of the perturbed frame.
    pub normal: [f32; 3],
    /// 1 with a perturbed frame.
    pub has_frame: u32,
    pub reflectance: [f32; 3],
    pub specular_reflectance: [f32; 3],
    pub specular_transmittance: [f32; 3],
    pub eta: [f32; 3],
    pub k: [f32; 3],
    pub alpha: [f32; 2],
    pub table: u32,
    pub table_rows: u32,
    pub internal_reflectance: f32,
    pub optical_depth: [f32; 3],
    pub coat_count: u32,
    pub coats: [CoatInput; MAX_COATS],
    pub exponent: f32,
    pub mode: u32,
    /// The known direction.
    pub wi: [f32; 3],
    /// The other one.
    pub wo: [f32; 3],
    /// Random numbers: the choice of an event, then a point.
    pub u: [f32; 3],
    /// Largest value of a regularised lobe.
    pub tau: f32,
}

/// What a function returns, zero beyond that.
pub type LobeOutput = [f32; 12];

fn vector(v: [f32; 3]) -> Vec3 {
    Vec3::new(v[0], v[1], v[2])
}

fn coat_of(c: &CoatInput) -> Coat {
    Coat {
        eta: c.eta,
        optical_depth: vector(c.optical_depth),
        alpha: c.alpha,
        table: c.table,
        table_rows: c.table_rows,
    }
}

/// The kernel's lobe, known by shader compilers to be within `features` ([`halflight_kernel::scene::features`]).
pub fn lobe_of(i: &LobeInput, features: u32) -> Lobe {
    #[cfg(not(target_arch = "spirv"))]
    let _ = features;
    Lobe {
        kind: i.kind,
        distribution: i.distribution,
        flags: i.flags,
        weight: 1.0,
        frame: Frame::from_normal(vector(i.normal)),
        has_frame: i.has_frame != 0,
        reflectance: vector(i.reflectance),
        specular_reflectance: vector(i.specular_reflectance),
        specular_transmittance: vector(i.specular_transmittance),
        eta: vector(i.eta),
        k: vector(i.k),
        alpha: Vec2::new(i.alpha[0], i.alpha[1]),
        table: i.table,
        table_rows: i.table_rows,
        internal_reflectance: i.internal_reflectance,
        optical_depth: vector(i.optical_depth),
        coat_count: i.coat_count,
        coats: [coat_of(&i.coats[0]), coat_of(&i.coats[1])],
        exponent: i.exponent,
        mode: i.mode,
        #[cfg(target_arch = "spirv")]
        features,
    }
}

/// Value times cosine, density, and the weight for the choice between lobes.
pub fn value(i: &LobeInput, data: &[f32], features: u32) -> LobeOutput {
    let lobe = lobe_of(i, features);
    let (wi, wo) = (vector(i.wi), vector(i.wo));
    let (f, pdf) = lobe::eval_cosine_pdf(&lobe, data, wi, wo);
    let colour = lobe::albedo(&lobe, data, wi);
    [
        f.x,
        f.y,
        f.z,
        pdf,
        colour.x,
        colour.y,
        colour.z,
        lobe::selection_weight(&lobe, data, wi),
        0.0,
        0.0,
        0.0,
        0.0,
    ]
}

/// Kinds of which shaders find a sample's direction only: its value and density are those of [`value`].
fn is_unweighted(kind: u32) -> bool {
    kind == lobe_kind::ROUGH_PLASTIC
        || kind == lobe_kind::ROUGH_COAT
        || kind == lobe_kind::MERL
        || kind == lobe_kind::DIFFRACTING_CONDUCTOR
}

/// A sample; without one the direction, which is then undefined, is zero, and so are weight and density of kinds that
/// shaders leave unweighted.
pub fn sample(i: &LobeInput, data: &[f32], features: u32) -> LobeOutput {
    let lobe = lobe_of(i, features);
    let wi = vector(i.wi);
    let mut s = lobe::sample(&lobe, data, wi, i.u[0], Vec2::new(i.u[1], i.u[2]));
    if is_unweighted(lobe.kind) {
        // They reflect only, and weighting ends what lies below the surface.
        let is_above = s.pdf > 0.0 && s.wo.z * wi.z > 0.0;
        s.pdf = 0.0;
        s.weight = Vec3::ZERO;
        s.event = if is_above { event::REFLECTION } else { 0 };
    }
    let wo = if s.event != 0 { s.wo } else { Vec3::ZERO };
    [
        wo.x,
        wo.y,
        wo.z,
        s.weight.x,
        s.weight.y,
        s.weight.z,
        s.pdf,
        s.eta,
        s.event as f32,
        0.0,
        0.0,
        0.0,
    ]
}

/// Roughness of the regularised lobe for reflection and transmission, its bounds, and what of it the density takes.
pub fn bounds(i: &LobeInput, _data: &[f32], features: u32) -> LobeOutput {
    let lobe = lobe_of(i, features);
    let (wi, wo) = (vector(i.wi), vector(i.wo));
    let transmission = wi.z * wo.z < 0.0;
    let regularized = regularized_bsdf::regularized_lobe(&lobe, transmission, i.tau);
    [
        regularized_bsdf::alpha_hat(&lobe, false, i.tau),
        regularized_bsdf::alpha_hat(&lobe, true, i.tau),
        regularized_bsdf::bound(&lobe, false),
        regularized_bsdf::bound(&lobe, true),
        regularized.kind as f32,
        regularized.alpha.x,
        regularized.alpha.y,
        regularized_bsdf::masking_ratio(&lobe, &regularized, wi, wo),
        0.0,
        0.0,
        0.0,
        0.0,
    ]
}
