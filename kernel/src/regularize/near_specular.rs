//! Which rough lobes count as specular where path space is regularised: those of which all but a small part would lie within the
//! blur that a specular one is given.
//!
//! A blur of radius r fills a cap of half angle `epsilon = atan(r / l)` at the distance l. A microfacet whose normal leaves the
//! macroscopic one by theta turns light by 2 theta, so that a lobe has the share q within the cap, at normal incidence, if
//!
//! ```text
//! alpha <= tan(epsilon / 2) / k(q),   k = sqrt(q / (1 - q))   for GGX,
//!                                     k = sqrt(-ln(1 - q))    for Beckmann:
//! ```
//!
//! tan(theta) = alpha k(q) is the quantile of the slope. (Mitsuba 0.6 forgets the root of the latter.) The distance is the radius
//! of the scene, as in Jendersie and Grosch 2019, section 3.4, so that a lobe is the same whatever it is connected to. Such a
//! lobe is sampled and blurred as the specular one is; since r goes to zero, each lobe is itself from some sample on.
//!
//! Invariants (tests): the share q of the sampled normals turns light by no more than epsilon at that alpha; none below it is left
//! out.

use crate::bsdf::Lobe;
use crate::math::float::{ln_1p, sqrt};
use crate::scene::distribution as kinds;

/// Share of a lobe that has to lie within the blur, unless something else is asked for.
pub const DEFAULT_QUANTILE: f32 = 0.9;

/// k above, infinite for a share of one, and for the exponential power distribution, whose tails may be of any length.
#[inline]
pub fn slope_quantile(distribution: u32, quantile: f32) -> f32 {
    if distribution == kinds::EXPONENTIAL_POWER {
        return f32::INFINITY;
    }
    let q = quantile.max(0.0).min(1.0);
    if distribution == kinds::BECKMANN {
        sqrt(-ln_1p(-q))
    } else {
        // Longer tails than those of Phong's.
        sqrt(q / (1.0 - q))
    }
}

/// Half the angle of the cap that a disk of radius `radius` fills at `distance`: tan(epsilon / 2).
#[inline]
pub fn half_tangent(radius: f32, distance: f32) -> f32 {
    if !(radius > 0.0) {
        return 0.0;
    }
    if !(distance > 0.0) {
        return 1.0;
    }
    let t = radius / distance;
    t / (1.0 + sqrt(1.0 + t * t))
}

/// Whether a rough lobe counts as specular.
#[inline]
pub fn is_near_specular(lobe: &Lobe, quantile: f32, half_tangent: f32) -> bool {
    let alpha = lobe.microfacets().alpha.max_element();
    alpha * slope_quantile(lobe.distribution, quantile) <= half_tangent
}
