//! The constraint of one vertex: its half vector and the derivatives by the positions of three vertices.
//!
//! ```text
//!     x_{i-1}                x_{i+1}         H = wi + eta wo,   h = H / |H| or H / (H.n)
//!         \  A_i    B_i   C_i /
//!       wi \       n_i       / wo            A_i = dh_i / dx_{i-1}   (2x2, columns: tangents of x_{i-1})
//!           \       |  h_i  /                B_i = dh_i / dx_i
//!            \      | /    /                 C_i = dh_i / dx_{i+1}
//!   ----------\-----|/----/----------  x_i
//! ```
//!
//! With P_w(x) = x - w (w.x), li and lo the lengths of the edges:
//! - dH / dx_{i-1} = P_wi(x) / li
//! - dH / dx_{i+1} = eta P_wo(x) / lo
//! - dH / dx_i = -(P_wi(x) / li + eta P_wo(x) / lo)
//!
//! Projected: `dh = (dH - h (h.dH)) / |H|`, column `(s.dh + h.s_x, t.dh + h.t_x)`. Slope: `h = H / (H.n)`,
//! `dh = dH / (H.n)`, `dh -= h (n.dh + h.n_x)`, the same column. `s_x`, `t_x`, `n_x` are the exact derivatives of the frame
//! and vanish for A and C. Jakob and Marschner 2012, section 4; the extension to shading normals that are not the geometric
//! ones is in the exact `s_x`, `t_x` of [`super::vertex`].
//!
//! An index-matched vertex has no half vector: its constraint is `(s.H, t.H) = 0`, not normalised. An endpoint with a pinned
//! direction constrains the direction of its edge, (s.w, t.w). A pinned position has B = 1 and A = C = 0: it never moves.
//!
//! Domain: edges longer than zero, |H| > 0, and h above the horizon by [`GRAZING`] for slopes; else the constraint is not
//! `valid` and its blocks are zero. Checked: every block of both forms against central differences in f64, on chains of
//! quadrics and meshes with shading normals.

use super::half_vector::SHORTEST;
use super::vertex::{ChainVertex, FrameDerivatives, vertex_kind};
use crate::math::Frame;
use crate::math::float::{abs, safe_sqrt};
use glam::{Mat2, Vec2, Vec3};

/// Which coordinates a half vector has.
pub mod half_vector_form {
    /// h_perp, on the unit disk.
    pub const PROJECTED: u32 = 0;
    /// h_pp, on the plane.
    pub const SLOPE: u32 = 1;
}

/// Least cosine between h and n for a slope.
pub const GRAZING: f32 = 1e-4;

/// Half vector and derivative blocks of a vertex.
#[derive(Clone, Copy, Debug)]
pub struct Constraint {
    /// By the previous vertex.
    pub a: Mat2,
    /// By the vertex itself.
    pub b: Mat2,
    /// By the next vertex.
    pub c: Mat2,
    /// The half vector's coordinates, zero for a pinned position.
    pub h: Vec2,
    /// Whether the constraint exists.
    pub valid: bool,
}

impl Constraint {
    /// A vertex that never moves.
    pub const FIXED: Constraint = Constraint {
        a: Mat2::ZERO,
        b: Mat2::IDENTITY,
        c: Mat2::ZERO,
        h: Vec2::ZERO,
        valid: true,
    };
    /// No constraint.
    pub const INVALID: Constraint = Constraint {
        a: Mat2::ZERO,
        b: Mat2::ZERO,
        c: Mat2::ZERO,
        h: Vec2::ZERO,
        valid: false,
    };
}

/// A unit direction along an edge and the inverse of its length; zero for a degenerate edge.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    /// Direction.
    pub w: Vec3,
    /// 1 / length.
    pub inverse_length: f32,
}

impl Edge {
    /// From one point to another.
    #[inline]
    pub fn new(from: Vec3, to: Vec3) -> Edge {
        let d = to - from;
        let length = safe_sqrt(d.length_squared());
        if !(length > 1e-15 && length < 1e15) {
            return Edge {
                w: Vec3::ZERO,
                inverse_length: 0.0,
            };
        }
        let inverse_length = 1.0 / length;
        Edge {
            w: d * inverse_length,
            inverse_length,
        }
    }

    /// P_w(x) / length.
    #[inline]
    fn projected_per_length(&self, x: Vec3) -> Vec3 {
        (x - self.w * self.w.dot(x)) * self.inverse_length
    }
}

/// The map from dH to dh of one vertex.
#[derive(Clone, Copy)]
struct Chart {
    frame: Frame,
    /// h, of the length that its form gives it.
    h: Vec3,
    /// n for slopes, h for the projected form, zero without normalisation: what dh loses along h.
    along: Vec3,
    scale: f32,
}

impl Chart {
    #[inline]
    fn column(&self, dh: Vec3) -> Vec2 {
        let dh = dh * self.scale;
        let dh = dh - self.h * self.along.dot(dh);
        Vec2::new(self.frame.s.dot(dh), self.frame.t.dot(dh))
    }

    /// For a move of the vertex itself, which turns its frame; `n_x` only for slopes.
    #[inline]
    fn own_column(&self, dh: Vec3, s_x: Vec3, t_x: Vec3, n_x: Vec3) -> Vec2 {
        let dh = dh * self.scale;
        let dh = dh - self.h * (self.along.dot(dh) + self.h.dot(n_x));
        Vec2::new(
            self.frame.s.dot(dh) + self.h.dot(s_x),
            self.frame.t.dot(dh) + self.h.dot(t_x),
        )
    }
}

/// Coordinates of a half vector.
#[derive(Clone, Copy, Debug)]
pub struct Coordinates {
    /// The half vector.
    pub h: Vec2,
    /// Whether there is one.
    pub valid: bool,
}

/// The half vector of [`inner_constraint`] alone.
#[inline]
pub fn inner_half_vector(previous: Vec3, x: &ChainVertex, next: Vec3, form: u32) -> Coordinates {
    let none = Coordinates {
        h: Vec2::ZERO,
        valid: false,
    };
    let i = Edge::new(x.position, previous);
    let o = Edge::new(x.position, next);
    if i.inverse_length == 0.0 || o.inverse_length == 0.0 {
        return none;
    }
    let sum = i.w + o.w * x.eta;
    let frame = x.frame();
    let mut scale = 1.0;
    if x.kind != vertex_kind::INDEX_MATCHED {
        let length = safe_sqrt(sum.length_squared());
        let height = sum.dot(frame.n);
        if !(length > SHORTEST) || !(abs(height) > GRAZING * length) {
            return none;
        }
        scale = if form == half_vector_form::SLOPE {
            1.0 / height
        } else {
            let sign = if height < 0.0 { -1.0 } else { 1.0 };
            sign / length
        };
    }
    let h = sum * scale;
    Coordinates {
        h: Vec2::new(frame.s.dot(h), frame.t.dot(h)),
        valid: true,
    }
}

/// The constraint of the inner vertex `x` between its neighbours.
#[inline]
pub fn inner_constraint(
    previous: &ChainVertex,
    x: &ChainVertex,
    next: &ChainVertex,
    form: u32,
) -> Constraint {
    let i = Edge::new(x.position, previous.position);
    let o = Edge::new(x.position, next.position);
    if i.inverse_length == 0.0 || o.inverse_length == 0.0 {
        return Constraint::INVALID;
    }
    let eta = x.eta;
    let sum = i.w + o.w * eta;
    let frame = x.frame();
    let mut n_x = (Vec3::ZERO, Vec3::ZERO);
    let chart = if x.kind == vertex_kind::INDEX_MATCHED {
        Chart {
            frame,
            h: sum,
            along: Vec3::ZERO,
            scale: 1.0,
        }
    } else {
        let length = safe_sqrt(sum.length_squared());
        let height = sum.dot(frame.n);
        if !(length > SHORTEST) || !(abs(height) > GRAZING * length) {
            return Constraint::INVALID;
        }
        if form == half_vector_form::SLOPE {
            n_x = (x.dn_u, x.dn_v);
            Chart {
                frame,
                h: sum * (1.0 / height),
                along: frame.n,
                scale: 1.0 / height,
            }
        } else {
            let scale = if height < 0.0 { -1.0 } else { 1.0 } / length;
            Chart {
                frame,
                h: sum * scale,
                along: sum * scale,
                scale,
            }
        }
    };
    let turning: FrameDerivatives = x.frame_derivatives(&frame);
    let own =
        |tangent: Vec3| -(i.projected_per_length(tangent) + o.projected_per_length(tangent) * eta);
    Constraint {
        a: Mat2::from_cols(
            chart.column(i.projected_per_length(previous.tangent_u)),
            chart.column(i.projected_per_length(previous.tangent_v)),
        ),
        b: Mat2::from_cols(
            chart.own_column(own(x.tangent_u), turning.s_u, turning.t_u, n_x.0),
            chart.own_column(own(x.tangent_v), turning.s_v, turning.t_v, n_x.1),
        ),
        c: Mat2::from_cols(
            chart.column(o.projected_per_length(next.tangent_u) * eta),
            chart.column(o.projected_per_length(next.tangent_v) * eta),
        ),
        h: Vec2::new(frame.s.dot(chart.h), frame.t.dot(chart.h)),
        valid: true,
    }
}

/// The constraint of an endpoint towards its only neighbour; the neighbour's block is in `a` for the last vertex of a chain
/// and in `c` for the first.
#[inline]
pub fn end_constraint(x: &ChainVertex, neighbour: &ChainVertex, is_last: bool) -> Constraint {
    if x.kind != vertex_kind::PINNED_DIRECTION {
        return Constraint::FIXED;
    }
    let edge = Edge::new(x.position, neighbour.position);
    if edge.inverse_length == 0.0 {
        return Constraint::INVALID;
    }
    // The frame is fixed in space: a plane across the pinned direction.
    let (s, t) = (x.tangent_u, x.tangent_v);
    let column = |d: Vec3| Vec2::new(s.dot(d), t.dot(d));
    let own = Mat2::from_cols(
        -column(edge.projected_per_length(x.tangent_u)),
        -column(edge.projected_per_length(x.tangent_v)),
    );
    let other = Mat2::from_cols(
        column(edge.projected_per_length(neighbour.tangent_u)),
        column(edge.projected_per_length(neighbour.tangent_v)),
    );
    Constraint {
        a: if is_last { other } else { Mat2::ZERO },
        b: own,
        c: if is_last { Mat2::ZERO } else { other },
        h: column(edge.w),
        valid: true,
    }
}
