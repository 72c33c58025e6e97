//! How far to step each half vector: the BSDF's width, the image's stratification, the spectrum's weights.
//!
//! - **BSDF** (thesis section 8.2.1). A Beckmann lobe is a Gaussian of standard deviation `alpha / sqrt(2)` per axis in slope
//!   units. The mean step per axis is `s = gamma alpha / sqrt(pi)`, and a Gaussian proposal with that mean has the deviation
//!   `s sqrt(pi / 2) = gamma alpha / sqrt(2)` ([`bsdf_deviation`]). The thesis's general formula "s = (2 / pi) |Sigma|" is a
//!   misprint (it has the dimension of s squared); its alpha / sqrt(pi) is right: `E|N(0, sigma)| = sigma sqrt(2 / pi)`.
//! - **Image** (section 8.2.2). One pixel moves x_{k-1} by `dx_u`, `dx_v`; a step of 2 % of the image moves it by that times
//!   the resolution. `R_0 = D_i^-1 [dx_u dx_v]` is the step of h_i alone that does so (equation 8.1), an ellipse with the axes
//!   and lengths of its singular values ([`image_step`]).
//! - **Spectrum** (section 8.2.3). The image's step is shared by `w_i = sigma_i / sum sigma_j` ([`spectrum_weights`]).
//! - **Proposal** (section 8.3): along each axis of the ellipse the smaller of `w_i` times the singular value and the BSDF's
//!   deviation, as a Gaussian on slopes or as a Phong lobe moved by a Moebius transformation on the disk. Both depend on the
//!   path, so a transition needs the proposals at both of its ends.
//!
//! Checked: E|step|, the ellipse against D_i, the weights' sum, the sampled proposal against its density.

use super::half_vector::projected_of_slope;
use super::vertex::ChainVertex;
use crate::manifold::disk_lobe::{DiskLobe, exponent_of_deviation};
use crate::manifold::slope_gaussian::SlopeGaussian;
use crate::math::block::{determinant2, invert};
use crate::math::float::{abs, atan2, safe_sqrt, sin_cos, sqrt};
use core::f32::consts::{FRAC_1_SQRT_2, FRAC_2_SQRT_PI};
use glam::{Mat2, Vec2, Vec3};

/// The thesis's gamma: a tenth of the optimal step, for visibility is not part of the analysis.
pub const GAMMA: f32 = 0.1;

/// Part of the image's size that a mutation should cross for good stratification.
pub const IMAGE_FRACTION: f32 = 0.02;

/// The roughness to give to a diffuse vertex.
pub const DIFFUSE_ALPHA: f32 = 1.0;

/// Largest deviation of a slope.
pub const LARGEST_DEVIATION: f32 = 1.7;

/// The thesis's mean step per axis, `gamma alpha / sqrt(pi)`, in slope units.
#[inline]
pub fn mean_step(alpha: f32, gamma: f32) -> f32 {
    0.5 * FRAC_2_SQRT_PI * gamma * alpha
}

/// The deviation of the Gaussian whose mean step is [`mean_step`]: `gamma alpha / sqrt(2)`.
#[inline]
pub fn bsdf_deviation(alpha: f32, gamma: f32) -> f32 {
    (FRAC_1_SQRT_2 * gamma * alpha)
        .max(0.0)
        .min(LARGEST_DEVIATION)
}

/// An ellipse of steps: its axis and the half lengths along it and across.
#[derive(Clone, Copy, Debug)]
pub struct StepEllipse {
    /// Unit direction of the first length; the second is a quarter turn further.
    pub axis: Vec2,
    /// Lengths, the longer first.
    pub length: Vec2,
}

impl StepEllipse {
    /// No limit.
    pub const UNLIMITED: StepEllipse = StepEllipse {
        axis: Vec2::X,
        length: Vec2::MAX,
    };
}

/// The ellipse onto which `m` maps the unit circle: singular values, and the direction of the first.
#[inline]
pub fn ellipse_of(m: Mat2) -> StepEllipse {
    let scale = m.x_axis.abs().max(m.y_axis.abs()).max_element();
    if !(scale > 1e-18 && scale < 1e18) {
        return StepEllipse {
            axis: Vec2::X,
            length: Vec2::ZERO,
        };
    }
    let m = m * (1.0 / scale);
    let s00 = m.x_axis.x * m.x_axis.x + m.y_axis.x * m.y_axis.x;
    let s11 = m.x_axis.y * m.x_axis.y + m.y_axis.y * m.y_axis.y;
    let s01 = m.x_axis.x * m.x_axis.y + m.y_axis.x * m.y_axis.y;
    let difference = s00 - s11;
    let root = safe_sqrt(difference * difference + 4.0 * s01 * s01);
    let largest = sqrt(0.5 * (s00 + s11 + root));
    let (sin, cos) = sin_cos(0.5 * atan2(2.0 * s01, difference));
    StepEllipse {
        axis: Vec2::new(cos, sin),
        // The smaller from the determinant: the difference of trace and root would cancel.
        length: Vec2::new(largest, (abs(determinant2(m)) / largest).min(largest)) * scale,
    }
}

/// The step of h_i alone that moves x_{k-1} by `dx_u` and `dx_v`: `D_i^-1 [dx_u dx_v]`. Where D_i has no inverse the vertex
/// does not move x_{k-1} in two dimensions, and the image does not limit its step.
#[inline]
pub fn image_step(d: Mat2, dx_u: Vec2, dx_v: Vec2) -> StepEllipse {
    let inverse = invert(d);
    if inverse.determinant == 0.0 {
        return StepEllipse::UNLIMITED;
    }
    ellipse_of(inverse.inverse * Mat2::from_cols(dx_u, dx_v))
}

/// The intersection of a ray with the tangent plane of `x`, as an offset in its tangents; zero for a ray parallel to the
/// plane. The difference of two pixels' offsets is a ray differential (Igehy 1999).
#[inline]
pub fn tangent_plane_offset(x: &ChainVertex, origin: Vec3, direction: Vec3) -> Vec2 {
    let cosine = direction.dot(x.geometric_normal);
    let t = (x.position - origin).dot(x.geometric_normal) / cosine;
    let d = origin + direction * t - x.position;
    let offset = Vec2::new(x.tangent_u.dot(d), x.tangent_v.dot(d));
    if abs(cosine) > 1e-6 && offset.length_squared() < f32::MAX {
        offset
    } else {
        Vec2::ZERO
    }
}

/// The BSDF's deviation along a direction: the section of its elliptic Gaussian, `1 / sqrt(d^T Sigma^-1 d)`.
#[inline]
pub fn deviation_along(x: &ChainVertex, direction: Vec2, gamma: f32) -> f32 {
    let s = Vec2::new(
        bsdf_deviation(x.alpha.x, gamma),
        bsdf_deviation(x.alpha.y, gamma),
    );
    let c = direction.dot(x.alpha_axis);
    let q = direction.perp_dot(x.alpha_axis);
    // s_x s_y / sqrt((c s_y)^2 + (q s_x)^2): zero when either is, along its axis.
    let below = safe_sqrt(c * c * s.y * s.y + q * q * s.x * s.x);
    if below > 1e-20 {
        s.x * s.y / below
    } else {
        s.x.min(s.y)
    }
}

/// `w_i = sigma_i / sum sigma_j` over the inner vertices of a chain; zero for specular vertices and all others.
#[inline]
pub fn spectrum_weights<const N: usize>(
    vertices: &[ChainVertex; N],
    len: usize,
    weights: &mut [f32; N],
) {
    let mut sum = 0.0;
    for i in 0..N {
        let x = &vertices[i];
        let is_perturbed = i > 0 && i + 1 < len && x.is_inner();
        weights[i] = if is_perturbed {
            0.5 * (bsdf_deviation(x.alpha.x, 1.0) + bsdf_deviation(x.alpha.y, 1.0))
        } else {
            0.0
        };
        sum += weights[i];
    }
    let inverse = if sum > 1e-20 { 1.0 / sum } else { 0.0 };
    for i in 0..N {
        weights[i] *= inverse;
    }
}

/// The proposal around the slope `h` of a vertex: the smaller of the BSDF's step and `weight` times the image's, per axis of
/// the image's ellipse (or of the BSDF where the image does not limit).
#[inline]
pub fn slope_proposal(
    x: &ChainVertex,
    h: Vec2,
    image: StepEllipse,
    weight: f32,
    gamma: f32,
) -> SlopeGaussian {
    let is_limited = image.length.x < f32::MAX;
    let axis = if is_limited { image.axis } else { x.alpha_axis };
    let bsdf = Vec2::new(
        deviation_along(x, axis, gamma),
        deviation_along(x, axis.perp(), gamma),
    );
    SlopeGaussian {
        center: h,
        axis,
        deviation: if is_limited {
            (image.length * weight).min(bsdf)
        } else {
            bsdf
        },
    }
}

/// The same proposal as a Phong lobe on the disk of projected half vectors, as in the original method; the deviations are
/// those of slopes at the pivot, where the Moebius transformation has the same Jacobian as the change to slopes.
#[inline]
pub fn disk_proposal(slope: &SlopeGaussian) -> DiskLobe {
    DiskLobe {
        center: projected_of_slope(slope.center),
        axis: slope.axis,
        exponent: Vec2::new(
            exponent_of_deviation(slope.deviation.x),
            exponent_of_deviation(slope.deviation.y),
        ),
    }
}
