//! Multiple importance sampling weights, by recursion along the two subpaths.
//!
//! A path x_0 ... x_k can be sampled by any split into s vertices from the light and t = k + 1 - s from the sensor. With p_s
//! the density of strategy s, its weight is w_s = 1 / sum_j h(p_j / p_s), h(x) = x (balance heuristic) or x^2 (power
//! heuristic; Veach 1997, section 9.2). Neighbouring strategies differ in the density of one vertex only, so the sum is
//! accumulated along the subpaths (Georgiev 2012, "Implementing Vertex Connection and Merging", section 4). For the last
//! vertex i of a subpath, with forward density p_i and reverse density r_i per area, the sum over all strategies in which
//! this subpath is shorter is
//!
//! ```text
//! S_i = h(r_i) [ d_vcm_i + h(r_w) d_vc_i ],
//! d_vcm_i = h(1 / p_i) if i - 1 and i can be connected, else 0
//! d_vc_i  = h(g_(i -> i-1) / p_i) [ d_vcm_(i-1) + h(r'_w) d_vc_(i-1) ]
//! ```
//!
//! where r_w is the density per solid angle at i of the direction to i - 1 and r'_w that at i - 1 of the direction to i - 2,
//! each for a walk that comes from the other end of the path, and g = cos / d^2 converts a density per solid angle into one
//! per area. Then w = 1 / (1 + S_light + S_camera).
//!
//! Merging (Georgiev et al. 2012; Hachisuka, Pantaleoni and Jensen 2012) makes the path by sampling vertex i from both ends and
//! accepting points that lie within a disk of radius r of each other. With n light walks to merge with, its density is that
//! of connecting i and i + 1, p_(i+1), times eta r_i, eta = pi r^2 n: so each vertex that is not specular adds h(eta) to
//! the bracket that its reverse density multiplies,
//!
//! ```text
//! S_i = h(r_i) [ h(eta) + d_vcm_i + h(r_w) d_vc_i ],
//! d_vc_i  = h(g_(i -> i-1) / p_i) [ h(eta) + d_vcm_(i-1) + h(r'_w) d_vc_(i-1) ],
//! ```
//!
//! where eta may differ from vertex to vertex ([`super::photon_density`]), and merging at i competes with `[d_vcm_i + h(r_w) d_vc_i] / h(eta)` from each side. What SmallVCM carries apart as dVM is
//! d_vc / h(eta). Where nothing is connected all d_vcm are zero.
//!
//! Cosines are those with geometric normals. At a specular vertex both densities are the same discrete probability and
//! cancel, and no connection is possible. Strategies that do not exist (hitting a pinhole or a light without extent; light
//! images when they are off) leave out their term at the ends of the recursion.

use bytemuck::{Pod, Zeroable};

/// The heuristic: the function h above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heuristic {
    /// Power heuristic with exponent 2 if true, balance heuristic if false.
    pub is_power: bool,
    /// eta above: the area within which photons are merged times the number of light walks that leave them; zero without
    /// merging.
    pub merging: f32,
    /// Whether subpaths are connected, to each other and to sampled points of emitters and of the lens.
    pub connects: bool,
}

impl Heuristic {
    /// Connections alone, by the balance heuristic.
    pub const BALANCE: Heuristic = Heuristic {
        is_power: false,
        merging: 0.0,
        connects: true,
    };

    /// Connections alone, by the power heuristic.
    pub const POWER: Heuristic = Heuristic {
        is_power: true,
        ..Heuristic::BALANCE
    };

    /// h(x) for x >= 0, finite.
    #[inline]
    pub fn of(self, x: f32) -> f32 {
        finite(if self.is_power { x * x } else { x })
    }

    /// h(x) for a strategy that connects: zero where there is none.
    #[inline]
    pub fn of_connection(self, x: f32) -> f32 {
        if self.connects { self.of(x) } else { 0.0 }
    }
}

/// Largest value of a sum: a weight beyond it is zero for all purposes.
const LARGEST: f32 = 1e30;

#[inline]
fn finite(x: f32) -> f32 {
    // The comparison also sends a NaN to the largest value.
    if x < LARGEST { x } else { LARGEST }
}

/// The partial sums of a subpath, d_vcm and d_vc above.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct PartialWeights {
    /// Term of the strategy that is shorter by one vertex, without the reverse density of this vertex.
    pub d_vcm: f32,
    /// Terms of all strategies that are shorter still, without the reverse densities of this vertex and of the previous one.
    pub d_vc: f32,
}

impl PartialWeights {
    /// No other strategy.
    pub const NONE: PartialWeights = PartialWeights {
        d_vcm: 0.0,
        d_vc: 0.0,
    };

    /// After non-specular scattering: `pdf` is the density per solid angle of the sampled direction, `pdf_reverse` that of the
    /// incident direction for a walk from the other end, `cosine` the geometric cosine of the sampled direction.
    #[inline]
    pub fn scatter(self, h: Heuristic, pdf: f32, pdf_reverse: f32, cosine: f32) -> PartialWeights {
        PartialWeights {
            d_vcm: h.of_connection(1.0 / pdf),
            d_vc: finite(h.of(cosine / pdf) * self.shorter_or_merged(h, pdf_reverse)),
        }
    }

    /// After specular scattering.
    #[inline]
    pub fn scatter_delta(self, h: Heuristic, cosine: f32) -> PartialWeights {
        PartialWeights {
            d_vcm: 0.0,
            d_vc: finite(h.of(cosine) * self.d_vc),
        }
    }

    /// At the next surface: multiplies by the geometry terms of the edge, whose squared length is `distance2` and whose
    /// geometric cosine at that surface is `cosine`.
    #[inline]
    pub fn arrive(self, h: Heuristic, distance2: f32, cosine: f32) -> PartialWeights {
        PartialWeights {
            d_vcm: finite(self.d_vcm * h.of(distance2 / cosine)),
            d_vc: finite(self.d_vc * h.of(1.0 / cosine)),
        }
    }

    /// The bracket of S_i above; `pdf_reverse` is the density r_w per solid angle.
    #[inline]
    pub fn shorter(self, h: Heuristic, pdf_reverse: f32) -> f32 {
        finite(self.d_vcm + h.of(pdf_reverse) * self.d_vc)
    }

    /// S_i above, for the reverse density `pdf_area` of the vertex per area and the density `pdf_reverse` per solid angle with
    /// which the path goes on to the previous vertex.
    #[inline]
    pub fn sum(self, h: Heuristic, pdf_area: f32, pdf_reverse: f32) -> f32 {
        finite(h.of(pdf_area) * self.shorter_or_merged(h, pdf_reverse))
    }

    /// The bracket of S_i with the strategy that merges at this vertex.
    #[inline]
    fn shorter_or_merged(self, h: Heuristic, pdf_reverse: f32) -> f32 {
        finite(self.shorter(h, pdf_reverse) + h.of(h.merging))
    }

    /// The sum over all strategies with a shorter subpath, for the strategy that merges at this vertex; `pdf_reverse` as in
    /// [`PartialWeights::sum`].
    #[inline]
    pub fn shorter_over_merged(self, h: Heuristic, pdf_reverse: f32) -> f32 {
        finite(self.shorter(h, pdf_reverse) * h.of(1.0 / h.merging))
    }
}

/// The weight of a strategy, given the sums over strategies with a shorter light and with a shorter camera subpath.
#[inline]
pub fn weight(light: f32, camera: f32) -> f32 {
    1.0 / (1.0 + light + camera)
}
