//! Microfacet distributions, their separable Smith masking, and the sampling of normals.
//!
//! A distribution `D(m)` is the area of microfacets per solid angle of normals over area of macrosurface, so that the
//! integral of `D(m) m.z` is 1 (tested). Everything of Smith's theory follows from the area projected along `w`,
//!
//! `projected_area(w) = integral of D(m) max(w.m, 0) dm`, `G1(w) = w.z / projected_area(w)`,
//! `D_w(m) = D(m) max(w.m, 0) / projected_area(w)` (the visible normals).
//!
//! (Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs", equations 10, 16, 17.)
//! The projected area has no pole at grazing angles, which `G1 / w.z` has in its usual form; it is what each
//! distribution implements. Masking and shadowing are separable, `G2(wi, wo) = G1(wi) G1(wo)`.
//!
//! `alpha` is the width along x and y; each component is clamped to [`ALPHA_MIN`] and above. Normals are unit, in the
//! local frame with z up; a normal with `m.z <= 0` has `D = 0`. A further distribution is a file below this one with
//! the same four functions, and a branch in each function here.

pub mod beckmann;
pub mod ggx;

use crate::math::float::{abs, safe_sqrt};
use crate::scene::distribution as kinds;
use glam::{Vec2, Vec3};

/// Smallest roughness: below it the half vector of two `f32` directions does not resolve the lobe.
pub const ALPHA_MIN: f32 = 1e-4;

/// `alpha` within the domain of this module.
#[inline]
pub fn clamp_alpha(alpha: Vec2) -> Vec2 {
    Vec2::new(alpha.x.max(ALPHA_MIN), alpha.y.max(ALPHA_MIN))
}

/// `D(m)` of a distribution out of [`crate::scene::distribution`].
#[inline]
pub fn distribution(kind: u32, alpha: Vec2, m: Vec3) -> f32 {
    if m.z <= 0.0 {
        return 0.0;
    }
    let alpha = clamp_alpha(alpha);
    if kind == kinds::GGX {
        ggx::distribution(alpha, m)
    } else {
        beckmann::distribution(alpha, m)
    }
}

/// Area of the microfacets that face `w`, projected along `w`, per area of macrosurface: `|w.z| / G1`, at least
/// `|w.z|`, positive for every unit `w`. The side of `w` is not looked at.
#[inline]
pub fn projected_area(kind: u32, alpha: Vec2, w: Vec3) -> f32 {
    let alpha = clamp_alpha(alpha);
    // |w.z| tan(theta) times the roughness along the azimuth of w.
    let spread = safe_sqrt((alpha.x * w.x) * (alpha.x * w.x) + (alpha.y * w.y) * (alpha.y * w.y));
    let area = if kind == kinds::GGX {
        ggx::projected_area(abs(w.z), spread)
    } else {
        beckmann::projected_area(abs(w.z), spread)
    };
    area.max(f32::MIN_POSITIVE)
}

/// Smith's masking `G1(w, m)`: the visible fraction of the microfacets with normal `m` seen along `w`, zero when `w` is
/// not on the same side of `m` as of the macrosurface. `w` may be below the surface.
#[inline]
pub fn smith_g1(kind: u32, alpha: Vec2, w: Vec3, m: Vec3) -> f32 {
    if w.dot(m) * w.z <= 0.0 {
        return 0.0;
    }
    (abs(w.z) / projected_area(kind, alpha, w)).min(1.0)
}

/// A normal distributed as those visible from `wi`, `wi.z >= 0`; density [`visible_normal_pdf`].
#[inline]
pub fn sample_visible_normal(kind: u32, alpha: Vec2, wi: Vec3, u: Vec2) -> Vec3 {
    let alpha = clamp_alpha(alpha);
    // Stretched to unit roughness (Heitz and d'Eon 2014, "Importance Sampling Microfacet-Based BSDFs using the
    // Distribution of Visible Normals", section 3): the visible normals of alpha are those of 1, stretched back.
    let stretched = Vec3::new(alpha.x * wi.x, alpha.y * wi.y, wi.z.max(0.0));
    let length = safe_sqrt(stretched.length_squared());
    if length < 1e-18 {
        return Vec3::Z;
    }
    let w = stretched * (1.0 / length);
    let h = if kind == kinds::GGX {
        ggx::sample_visible_normal(w, u)
    } else {
        beckmann::sample_visible_normal(w, u)
    };
    unit_normal(alpha.x * h.x, alpha.y * h.y, h.z)
}

/// Density per solid angle of [`sample_visible_normal`].
#[inline]
pub fn visible_normal_pdf(kind: u32, alpha: Vec2, wi: Vec3, m: Vec3) -> f32 {
    let cos_i = wi.dot(m);
    if wi.z < 0.0 || cos_i <= 0.0 {
        return 0.0;
    }
    distribution(kind, alpha, m) * cos_i / projected_area(kind, alpha, wi)
}

/// A normal with density [`normal_pdf`], `D(m) m.z`.
#[inline]
pub fn sample_normal(kind: u32, alpha: Vec2, u: Vec2) -> Vec3 {
    let alpha = clamp_alpha(alpha);
    // Slopes of unit roughness.
    let slope = if kind == kinds::GGX {
        ggx::sample_slope(u)
    } else {
        beckmann::sample_slope(u)
    };
    unit_normal(alpha.x * slope.x, alpha.y * slope.y, 1.0)
}

/// Density per solid angle of [`sample_normal`].
#[inline]
pub fn normal_pdf(kind: u32, alpha: Vec2, m: Vec3) -> f32 {
    distribution(kind, alpha, m) * m.z
}

/// The unit vector along `(x, y, z)`, `z >= 0`; up when all vanish.
#[inline]
fn unit_normal(x: f32, y: f32, z: f32) -> Vec3 {
    let m = Vec3::new(x, y, z.max(0.0));
    let length = safe_sqrt(m.length_squared());
    if length < 1e-18 {
        return Vec3::Z;
    }
    m * (1.0 / length)
}
