//! The transmittance of a rough dielectric boundary, tabulated.
//!
//! T(cos, alpha) = integral of D_w(m) (1 - F(w . m)) G1(wt) dm over the visible normals, wt the refraction at m, has no
//! closed form. A host fills a table with [`fill`]; without one the smooth boundary's 1 - F stands in, which is Tungsten's
//! choice. A row holds [`ENTRIES`] values of T at cos = i / (entries - 1), linear in between, and one more word, the
//! internal reflectance of the boundary at the row's roughness ([`row_internal_reflectance`]). A constant roughness needs
//! one row; a texture reads [`ROWS`] rows at alpha = (j / (rows - 1))^2, linear in sqrt(alpha), clamped at alpha = 1.
//!
//! Domain: alpha and cosines are clamped to [0, 1]; the index is interior over exterior. Invariants (tests): a table row
//! equals the quadrature at its nodes, and the many-row table is within 0.012 of the one-row table at roughnesses
//! between its rows.

use super::fresnel::{fresnel_dielectric, reflect, refract};
use super::microfacet::{self, Microfacets};
use crate::math::{element, float};
use crate::scene::NONE;
use glam::{Vec2, Vec3};

/// Values of transmittance in a row.
pub const ENTRIES: usize = 64;
/// Words of a row: the transmittances and the internal reflectance.
pub const ROW: usize = ENTRIES + 1;
/// Rows of a table for a texture of roughnesses.
pub const ROWS: usize = 16;

/// Share of the light from cosine `cos` that passes the boundary; the smooth boundary's where `table` is NONE.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn transmittance(data: &[f32], table: u32, rows: u32, eta: f32, alpha: f32, cos: f32) -> f32 {
    if table == NONE {
        return 1.0 - fresnel_dielectric(cos, eta).0;
    }
    const LAST: u32 = ENTRIES as u32 - 1;
    let x = cos.max(0.0).min(1.0) * LAST as f32;
    let i = float::to_index(x).min(LAST - 1);
    let t = x - i as f32;
    let at = table + i;
    if rows <= 1 {
        return float::lerp(element(data, at), element(data, at + 1), t);
    }
    let (row, s) = row_of(rows, alpha);
    let at = at + row * ROW as u32;
    let next = at + ROW as u32;
    float::lerp(
        float::lerp(element(data, at), element(data, at + 1), t),
        float::lerp(element(data, next), element(data, next + 1), t),
        s,
    )
}

/// Share of diffuse light from inside that the boundary reflects back, from a table of two or more rows.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn internal_reflectance(data: &[f32], table: u32, rows: u32, alpha: f32) -> f32 {
    let (row, s) = row_of(rows, alpha);
    let at = table.wrapping_add(row * ROW as u32 + ENTRIES as u32);
    float::lerp(
        element(data, at),
        element(data, at.wrapping_add(ROW as u32)),
        s,
    )
}

/// The row below `alpha` and the position between it and the next.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
fn row_of(rows: u32, alpha: f32) -> (u32, f32) {
    let rows = rows.max(2);
    let x = float::sqrt(alpha.max(0.0).min(1.0)) * (rows - 1) as f32;
    let row = float::to_index(x).min(rows - 2);
    (row, x - row as f32)
}

/// Nodes per axis of the quadrature over visible normals: absolute error below 2e-3 at grazing angles, 1e-4 elsewhere.
#[cfg(not(target_arch = "spirv"))]
const QUADRATURE: u32 = 48;

/// Mean of `f(m)` over the normals visible from `wi`, by the midpoint rule over the sampler's square. Runs on the host
/// when a scene is built: it accumulates in f64, which shaders lack.
#[cfg(not(target_arch = "spirv"))]
fn mean_over_visible_normals(kind: u32, alpha: f32, wi: Vec3, f: impl Fn(Vec3) -> f32) -> f32 {
    let facets = Microfacets::new(kind, Vec2::splat(alpha), 1.0);
    let step = 1.0 / QUADRATURE as f32;
    let mut sum = 0.0_f64;
    for i in 0..QUADRATURE {
        for j in 0..QUADRATURE {
            let u = Vec2::new((i as f32 + 0.5) * step, (j as f32 + 0.5) * step);
            let m = facets.sample_visible_normal(wi, u);
            sum += f64::from(f(m) * facets.visible_normal_weight(wi, m));
        }
    }
    // Phong borrows its masking: at grazing angles its visible normals have a mass above one.
    ((sum / f64::from(QUADRATURE * QUADRATURE)) as f32).min(1.0)
}

/// A direction with cosine `cos`, kept off the horizon.
#[cfg(not(target_arch = "spirv"))]
fn direction_at_cosine(cos: f32) -> Vec3 {
    let cos = cos.max(1e-6).min(1.0);
    Vec3::new(float::safe_sqrt((1.0 - cos) * (1.0 + cos)), 0.0, cos)
}

/// Transmittance of a rough dielectric boundary for light from outside at cosine `cos`; `eta` interior over
/// exterior.
#[cfg(not(target_arch = "spirv"))]
pub fn boundary_transmittance(kind: u32, alpha: f32, eta: f32, cos: f32) -> f32 {
    let wi = direction_at_cosine(cos);
    let width = microfacet::clamp_alpha(Vec2::splat(alpha));
    mean_over_visible_normals(kind, alpha, wi, |m| {
        let cos_i = wi.dot(m);
        let (reflected, cos_t) = fresnel_dielectric(cos_i, eta);
        let wt = refract(wi, m, cos_t, eta);
        if cos_i <= 0.0 || wt.z >= 0.0 {
            return 0.0;
        }
        (1.0 - reflected) * microfacet::smith_g1(kind, width, wt, m)
    })
}

/// Share of the light from inside at cosine `cos` that a rough dielectric boundary reflects back inside; `eta` interior
/// over exterior.
#[cfg(not(target_arch = "spirv"))]
pub fn boundary_internal_reflectance(kind: u32, alpha: f32, eta: f32, cos: f32) -> f32 {
    let wi = direction_at_cosine(cos);
    let width = microfacet::clamp_alpha(Vec2::splat(alpha));
    mean_over_visible_normals(kind, alpha, wi, |m| {
        let cos_i = wi.dot(m);
        let wo = reflect(wi, m);
        if cos_i <= 0.0 || wo.z <= 0.0 {
            return 0.0;
        }
        // The side of the interior is that of negative cosines.
        fresnel_dielectric(-cos_i, eta).0 * microfacet::smith_g1(kind, width, wo, m)
    })
}

/// F_int of a rough boundary for [`crate::scene::LobeRecord::internal_reflectance`]: the cosine-weighted mean of
/// [`boundary_internal_reflectance`].
///
/// It is the plain mean of 2 cos R over the [`ENTRIES`] nodes, both ends included, because the images that people compare
/// with are made so; the trapezoidal rule, with one node less in the divisor, gives values 1.6 % higher.
#[cfg(not(target_arch = "spirv"))]
pub fn row_internal_reflectance(kind: u32, alpha: f32, eta: f32) -> f32 {
    let mut sum = 0.0;
    for i in 0..ENTRIES {
        let cos = i as f32 / (ENTRIES - 1) as f32;
        sum += 2.0 * cos * boundary_internal_reflectance(kind, alpha, eta, cos);
    }
    sum / ENTRIES as f32
}

/// Fills one row ([`ROW`] words) for the isotropic roughness `alpha`.
#[cfg(not(target_arch = "spirv"))]
pub fn fill_row(kind: u32, alpha: f32, eta: f32, row: &mut [f32]) {
    for i in 0..ENTRIES {
        row[i] = boundary_transmittance(kind, alpha, eta, i as f32 / (ENTRIES - 1) as f32);
    }
    row[ENTRIES] = row_internal_reflectance(kind, alpha, eta);
}

/// Fills the [`ROWS`] rows ([`ROWS`] times [`ROW`] words) of a table over the roughness.
#[cfg(not(target_arch = "spirv"))]
pub fn fill(kind: u32, eta: f32, table: &mut [f32]) {
    for j in 0..ROWS {
        let root = j as f32 / (ROWS - 1) as f32;
        fill_row(kind, root * root, eta, &mut table[j * ROW..(j + 1) * ROW]);
    }
}
