//! V-cavities: masking that depends on the normal, and the normals that such a surface shows.
//!
//! Cook and Torrance 1982, "A Reflectance Model for Computer Graphics", in the terms of Heitz and d'Eon 2014,
//! "Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals": microfacets come in pairs,
//! `m` and its mirror image `m'` in z, and mask nothing but each other. Then `G1(w, m) = min(1, 2 m.z w.z / w.m)` and the
//! visible normals have the density `D(m) m.z min(2, w.m / (m.z w.z))`: of a pair drawn from `D(m) m.z`, one is taken in
//! proportion to the area that it turns towards `w`. It needs no integral over `D`, so it holds for every distribution
//! with `D(m) = D(m')`.
//!
//! Where the azimuth of normals is uniform at every slope `s`, the azimuth against `w` has density
//! `clamp(1 - e cos(phi), 0, 2) / (2 pi)` with `e = s tan(theta_w)`: [`sample_azimuth`] inverts its integral, which for
//! `e < 1` is Kepler's equation. Invariants (tests): chi-square, normalisation, every sampled normal faces `w`.

use crate::math::float::{abs, atan2, pow, safe_sqrt, sin_cos};
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

/// Masking of the normal `m`, `m.z > 0`, seen along `w`; zero where the sides of `w` disagree.
#[inline]
pub fn g1(w: Vec3, m: Vec3) -> f32 {
    let cos = w.dot(m);
    if cos * w.z <= 0.0 || m.z <= 0.0 {
        return 0.0;
    }
    (2.0 * m.z * abs(w.z) / abs(cos)).min(1.0)
}

/// Masking and shadowing together: the same cavity serves both directions, so the smaller counts (reflection).
#[inline]
pub fn g2(wi: Vec3, wo: Vec3, m: Vec3) -> f32 {
    g1(wi, m).min(g1(wo, m))
}

/// `m.z min(2, w.m / (m.z w.z))` for `w.m > 0`: density of the visible normals over `D(m)`.
#[inline]
pub fn facing_area(w: Vec3, m: Vec3) -> f32 {
    let cos = w.dot(m);
    if cos >= 2.0 * m.z * w.z {
        2.0 * m.z
    } else {
        cos / w.z
    }
}

/// A slope of length `radius` at an azimuth in proportion to the area that it turns towards `w`, in the units to which
/// `w` is stretched (not normalised); `u` is uniform. Returns the normal's `m.xy / m.z`.
#[cfg_attr(not(target_arch = "spirv"), inline)]
pub fn sample_azimuth(w: Vec3, radius: f32, u: f32) -> Vec2 {
    let across = safe_sqrt(w.x * w.x + w.y * w.y);
    let (c, s) = if across > 0.0 {
        (w.x / across, w.y / across)
    } else {
        (1.0, 0.0)
    };
    // Both halves of the circle are alike: the first bit of u chooses.
    let (side, u) = if u < 0.5 {
        (1.0, 2.0 * u)
    } else {
        (-1.0, 2.0 * u - 1.0)
    };
    // phi is the azimuth of the slope, pi away from that of the normal.
    let (sin_phi, cos_phi) = sin_cos(azimuth(radius * across, w.z, PI * u));
    let (x, y) = (-radius * cos_phi, radius * sin_phi * side);
    Vec2::new(c * x - s * y, s * x + c * y)
}

/// Solves `integral of clamp(1 - e cos(t), 0, 2) dt from 0 to phi = target` for `e = a / z`, `target` in [0, pi].
///
/// The density rises on [0, pi], the integral is convex: from the right of the solution, Newton's method descends to
/// it. The starting points come from lower bounds of the integral.
#[inline]
fn azimuth(a: f32, z: f32, target: f32) -> f32 {
    // Grazing: e beyond 1e6 turns everything towards w.
    let e = if a < 1e6 * z { a / z } else { 1e6 };
    if e <= 1e-6 {
        return target;
    }
    // Where the density begins, and its integral up to there in the form phi - e sin(phi).
    let (sin0, start) = if e > 1.0 {
        let sin0 = safe_sqrt((e - 1.0) * (e + 1.0)) / e;
        (sin0, atan2(safe_sqrt((e - 1.0) * (e + 1.0)), 1.0))
    } else {
        (0.0, 0.0)
    };
    let end = PI - start;
    // The saturated part has density 2 up to pi.
    let below = end - start;
    if target >= below {
        return (end + 0.5 * (target - below)).min(PI);
    }
    let middle = 0.5 * PI;
    let half = (middle - start) - e * (1.0 - sin0);
    let mut phi = end;
    if target < half {
        // 1 - e cos(t) >= 2 e (t^2 - start^2) / pi^2 + max(1 - e, 0).
        phi = middle.min(start + pow(1.5 * PI * PI * target / e, 1.0 / 3.0));
        if start > 0.0 {
            phi = phi.min(start + safe_sqrt(0.5 * PI * PI * target / (e * start)));
        } else if e < 1.0 {
            phi = phi.min(target / (1.0 - e));
        }
    }
    for _ in 0..8 {
        // sin(phi) - sin(start) as a product, without cancellation.
        let (s_half, _) = sin_cos(0.5 * (phi - start));
        let (s_mean, c_mean) = sin_cos(0.5 * (phi + start));
        let value = (phi - start) - 2.0 * e * c_mean * s_half;
        // 1 - e cos(phi): for e > 1, e (cos(start) - cos(phi)).
        let density = if e > 1.0 {
            2.0 * e * s_mean * s_half
        } else {
            let (s, _) = sin_cos(0.5 * phi);
            (1.0 - e) + 2.0 * e * s * s
        };
        if density <= 0.0 {
            break;
        }
        let step = (value - target) / density;
        phi = (phi - step).max(start).min(end);
        if abs(step) < 1e-6 * phi {
            break;
        }
    }
    phi
}
