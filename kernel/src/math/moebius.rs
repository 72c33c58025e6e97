//! The Moebius transformation of the unit disk that swaps the origin and a chosen point.
//!
//! `M_a(z) = (z - a) / (conj(a) z - 1)`, with points of the disk as complex numbers. It maps the disk onto itself and is its
//! own inverse: `M_a(M_a(z)) = z`, `M_a(0) = a`, `M_a(a) = 0`. A lobe around the origin becomes one around `a` that never
//! leaves the disk (Kaplanyan 2017, section 8.3). The map is conformal; its Jacobian, the ratio of areas, is
//! `|M_a'(z)|^2 = ((1 - |a|^2) / |1 - conj(a) z|^2)^2`.
//!
//! At `z = 0` that is `(1 - |a|^2)^2 = cos^4 theta`, the same as the ratio of areas from plane/plane to projected half
//! vectors: a lobe keeps its size in slope units wherever it is moved. Domain: `|a| < 1`, `|z| <= 1`; larger `|a|` is pulled
//! to [`LARGEST_PIVOT`]. Checked: involution, Jacobian against central differences, the disk mapped into itself.

use super::float::{safe_sqrt, sqr};
use glam::Vec2;

/// The pivot stays this far inside the disk, where the Jacobian at the origin is still 4e-12.
pub const LARGEST_PIVOT: f32 = 0.999_999;

/// The pivot within the domain, scaled onto the rim where it lies outside.
#[inline]
pub fn clamp_pivot(a: Vec2) -> Vec2 {
    let r2 = a.length_squared();
    if r2 <= LARGEST_PIVOT * LARGEST_PIVOT {
        a
    } else if r2 < f32::MAX {
        a * (LARGEST_PIVOT / safe_sqrt(r2))
    } else {
        Vec2::ZERO
    }
}

/// `conj(a) z`.
#[inline]
fn conjugate_product(a: Vec2, z: Vec2) -> Vec2 {
    Vec2::new(a.x * z.x + a.y * z.y, a.x * z.y - a.y * z.x)
}

/// `M_a(z)`.
#[inline]
pub fn moebius(a: Vec2, z: Vec2) -> Vec2 {
    let a = clamp_pivot(a);
    // (z - a) / d = (z - a) conj(d) / |d|^2; |d| >= 1 - |a| > 0 inside the disk.
    let d = conjugate_product(a, z) - Vec2::X;
    let d2 = d.length_squared();
    if !(d2 > 1e-14) {
        // z lies outside the disk, near the pole.
        return a;
    }
    conjugate_product(d, z - a) * (1.0 / d2)
}

/// Ratio of areas `|dM_a(z) / dz|`.
#[inline]
pub fn moebius_jacobian(a: Vec2, z: Vec2) -> f32 {
    let a = clamp_pivot(a);
    let d2 = (Vec2::X - conjugate_product(a, z)).length_squared();
    if !(d2 > 1e-14) {
        return 0.0;
    }
    sqr((1.0 - a.length_squared()) / d2)
}
