//! Weights of the strategies that can make a path, by recursion along its two subpaths.
//!
//! A path x_0 ... x_k can be made by any split into s vertices from the light and t = k + 1 - s from the sensor. With p_s
//! the density of strategy s, its weight is w_s = 1 / sum_j h(p_j / p_s), h(x) = x (balance heuristic) or x^2 (power
//! heuristic; Veach 1997, section 9.2). Neighbouring strategies differ in the density of one vertex only, so the sum is
//! gathered along the subpaths (Georgiev 2012, "Implementing Vertex Connection and Merging", section 4). For the last vertex
//! i of a subpath, with forward density p_i and reverse density r_i per area, the sum over all strategies in which this
//! subpath is shorter is
//!
//! ```text
//! S_i = h(r_i) [ d_vcm_i + h(r_w) d_vc_i ],
//! d_vcm_i = h(1 / p_i) if i - 1 and i can be connected, else 0
//! d_vc_i  = h(g_(i -> i-1) / p_i) [ d_vcm_(i-1) + h(r'_w) d_vc_(i-1) ]
//! ```
//!
//! where r_w is the density per solid angle at i of the direction to i - 1 and r'_w that at i - 1 of the direction to i - 2,
//! each with the walk coming from the other end, and g = cos / d^2 turns a density per solid angle into one per area. Then
//! w = 1 / (1 + S_light + S_camera).
//!
//! Cosines are those of geometric normals. At a discrete event both densities are the same discrete one and cancel, and
//! there is nothing to connect. Strategies that cannot be (a hit of a pinhole or of a light without extent, the light image
//! when it is off) leave their term out at the ends.

/// h of the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heuristic {
    /// Whether densities count by their squares.
    pub is_power: bool,
}

impl Heuristic {
    /// h(x) for x >= 0, finite.
    #[inline]
    pub fn of(self, x: f32) -> f32 {
        finite(if self.is_power { x * x } else { x })
    }
}

/// Largest value that a sum takes: beyond it a weight is zero to all digits.
const LARGEST: f32 = 1e30;

#[inline]
fn finite(x: f32) -> f32 {
    // Not a number also becomes the largest value.
    if x < LARGEST { x } else { LARGEST }
}

/// The gathered sums of a subpath.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PartialWeights {
    /// Of the strategy that is one vertex shorter, but for the reverse density of this vertex.
    pub d_vcm: f32,
    /// Of all that are shorter yet, but for the reverse densities of this vertex and the one before.
    pub d_vc: f32,
}

impl PartialWeights {
    /// Nothing to compete with.
    pub const NONE: PartialWeights = PartialWeights {
        d_vcm: 0.0,
        d_vc: 0.0,
    };

    /// After scattering along a direction that is no discrete one: `pdf` its density per solid angle, `pdf_reverse` that of
    /// the way back, `cosine` the geometric one.
    #[inline]
    pub fn scatter(self, h: Heuristic, pdf: f32, pdf_reverse: f32, cosine: f32) -> PartialWeights {
        PartialWeights {
            d_vcm: h.of(1.0 / pdf),
            d_vc: finite(h.of(cosine / pdf) * self.shorter(h, pdf_reverse)),
        }
    }

    /// After a discrete event.
    #[inline]
    pub fn scatter_delta(self, h: Heuristic, cosine: f32) -> PartialWeights {
        PartialWeights {
            d_vcm: 0.0,
            d_vc: finite(h.of(cosine) * self.d_vc),
        }
    }

    /// On arrival at a surface, `distance2` squared away under the geometric `cosine`.
    #[inline]
    pub fn arrive(self, h: Heuristic, distance2: f32, cosine: f32) -> PartialWeights {
        PartialWeights {
            d_vcm: finite(self.d_vcm * h.of(distance2 / cosine)),
            d_vc: finite(self.d_vc * h.of(1.0 / cosine)),
        }
    }

    /// The bracket of the header, for a density per solid angle of the way back.
    #[inline]
    pub fn shorter(self, h: Heuristic, pdf_reverse: f32) -> f32 {
        finite(self.d_vcm + h.of(pdf_reverse) * self.d_vc)
    }

    /// The sum over shorter subpaths, for the reverse density of the vertex per area and that of the way on per solid angle.
    #[inline]
    pub fn sum(self, h: Heuristic, pdf_area: f32, pdf_reverse: f32) -> f32 {
        finite(h.of(pdf_area) * self.shorter(h, pdf_reverse))
    }
}

/// The weight of a strategy, given the sums over those with a shorter light and with a shorter camera subpath.
#[inline]
pub fn weight(light: f32, camera: f32) -> f32 {
    1.0 / (1.0 + light + camera)
}
