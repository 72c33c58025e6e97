//! The constraints of a whole chain: J, its factors, and the path measure in half-vector space.
//!
//! Rows 0 to k hold the constraints of x_0 to x_k, endpoints included, so that J is square whatever is pinned: a pinned
//! position is an identity row and changes neither the determinant nor a solution (thesis equation 7.3 is the case of two
//! such ends); a pinned direction is a row that moves its endpoint.
//!
//! The change of variables (thesis equations 7.4 to 7.6): with all densities per area of the vertices,
//!
//! `prod G(x_i, x_{i+1}) |dX / dH| = G(x_0 <-> x_k) prod_{i=1}^{k-1} |do_i / dh_i| |o_i . n_i| q_i`,
//! `q_i = 1 / |h_i . n_i|` (projected), `|h_i . n_i|^3` (slope),
//!
//! where `G(x_0 <-> x_k)` is the generalised geometry term, `G(x_0, x_1) |det T_1|` between pinned positions and `|det T_0|`
//! from a pinned direction. G and o_i.n_i take the geometric normal, the half vector the shading normal. The left side has a
//! pole where two vertices meet, as in a corner, and the right side has not. Checked: the identity for both forms, all kinds
//! of vertices and ends.

use super::constraint::{Constraint, Edge, end_constraint, half_vector_form, inner_constraint};
use super::half_vector::half_vector;
use super::vertex::{ChainVertex, vertex_kind};
use crate::math::block_elimination;
use crate::math::block_tridiagonal::BlockLu;
use crate::math::float::abs;
use crate::math::scaled::Scaled;
use glam::{Mat2, Vec2};

/// The Jacobian of a chain of up to `N` vertices.
#[derive(Clone, Copy, Debug)]
pub struct ChainJacobian<const N: usize> {
    /// A_i.
    pub a: [Mat2; N],
    /// B_i.
    pub b: [Mat2; N],
    /// C_i.
    pub c: [Mat2; N],
    /// Half vectors, zero at pinned positions.
    pub h: [Vec2; N],
    /// Factors of J.
    pub lu: BlockLu<N>,
    /// Number of vertices, k + 1.
    pub len: usize,
    /// Whether all constraints exist. J may still be singular ([`ChainJacobian::is_regular`]).
    pub valid: bool,
}

impl<const N: usize> ChainJacobian<N> {
    /// The constraints of the first `len` vertices, in one of the forms of [`half_vector_form`], and their factors.
    #[inline]
    pub fn new(vertices: &[ChainVertex; N], len: usize, form: u32) -> ChainJacobian<N> {
        let mut chain = ChainJacobian::unfactored(vertices, len, form);
        if chain.valid {
            chain.lu = BlockLu::factor(&chain.a, &chain.b, &chain.c, len);
        }
        chain
    }

    /// The constraints without factors, which is enough for [`ChainJacobian::solve`].
    #[inline]
    pub fn unfactored(vertices: &[ChainVertex; N], len: usize, form: u32) -> ChainJacobian<N> {
        let mut chain = ChainJacobian {
            a: [Mat2::ZERO; N],
            b: [Mat2::ZERO; N],
            c: [Mat2::ZERO; N],
            h: [Vec2::ZERO; N],
            lu: BlockLu::SINGULAR,
            len,
            valid: true,
        };
        if len < 2 || len > N {
            chain.valid = false;
            return chain;
        }
        for i in 0..len {
            let row = constraint_at(vertices, len, i, form);
            chain.a[i] = row.a;
            chain.b[i] = row.b;
            chain.c[i] = row.c;
            chain.h[i] = row.h;
            chain.valid = chain.valid && row.valid;
        }
        chain
    }

    /// Solves J dX = dH in place for a single right-hand side; [`ChainJacobian::lu`] serves several. False, and zeros, without a
    /// finite solution.
    #[inline]
    pub fn solve(&self, x: &mut [Vec2; N]) -> bool {
        if !self.valid {
            for i in 0..N {
                x[i] = Vec2::ZERO;
            }
            return false;
        }
        block_elimination::solve(&self.a, &self.b, &self.c, self.len, x)
    }

    /// Whether J exists and has an inverse.
    #[inline]
    pub fn is_regular(&self) -> bool {
        self.valid && !self.lu.is_singular()
    }

    /// Estimate of the condition of J ([`BlockLu::condition`]).
    #[inline]
    pub fn condition(&self) -> f32 {
        self.lu.condition(&self.a, &self.b, &self.c)
    }

    /// J dX.
    #[inline]
    pub fn apply(&self, dx: &[Vec2; N]) -> [Vec2; N] {
        let mut dh = [Vec2::ZERO; N];
        let n = self.len.min(N);
        for i in 0..n {
            let mut sum = self.b[i] * dx[i];
            if i > 0 {
                sum += self.a[i] * dx[i - 1];
            }
            if i + 1 < n {
                sum += self.c[i] * dx[i + 1];
            }
            dh[i] = sum;
        }
        dh
    }

    /// |det J|, area of half vectors per area of vertices |dH / dX|; zero when singular.
    #[inline]
    pub fn half_vectors_per_vertex_area(&self) -> Scaled {
        if !self.valid {
            return Scaled::ZERO;
        }
        self.lu.determinant().abs()
    }

    /// `|det T_1| / |det T_{k-1}|`, how far x_1 moves when x_{k-1} does, to first order (thesis section 8.1.1); one without
    /// two inner vertices.
    #[inline]
    pub fn sensitivity(&self) -> f32 {
        if self.len < 4 {
            return 1.0;
        }
        let k = self.len - 1;
        self.lu
            .transfer_determinant(&self.c, 1, k - 1)
            .abs()
            .value()
    }
}

/// Row `i` of a chain of `len` vertices.
#[inline]
fn constraint_at<const N: usize>(
    vertices: &[ChainVertex; N],
    len: usize,
    i: usize,
    form: u32,
) -> Constraint {
    let last = len.wrapping_sub(1);
    if i >= N || last >= N || last == 0 {
        return Constraint::INVALID;
    }
    let x = vertices[i];
    if i == 0 || i >= last {
        let at = if i == 0 { 1.min(N - 1) } else { last - 1 };
        let neighbour = vertices[at];
        return end_constraint(&x, &neighbour, i >= last);
    }
    if i + 1 >= N {
        return Constraint::INVALID;
    }
    // Points in space have no tangents of their own; only endpoints are such.
    let previous = vertices[i - 1].facing(x.position);
    let next = vertices[i + 1].facing(x.position);
    if !x.is_inner() {
        return Constraint::INVALID;
    }
    inner_constraint(&previous, &x, &next, form)
}

/// G(x, y), both cosines over the squared distance, by geometric normals; zero for points that coincide.
#[inline]
pub fn geometry_term(x: &ChainVertex, y: &ChainVertex) -> f32 {
    let edge = Edge::new(x.position, y.position);
    x.cosine(edge.w) * y.cosine(edge.w) * edge.inverse_length * edge.inverse_length
}

/// The generalised geometry term `G(x_0 <-> x_k)`: `G(x_0, x_1) |det T_1|` from a pinned position (thesis equation 7.6),
/// `|det T_0|` from a pinned direction; towards a sensor with a pinned direction per unit of that direction's projection.
/// Zero when J is singular.
#[inline]
pub fn generalized_geometry_term<const N: usize>(
    vertices: &[ChainVertex; N],
    jacobian: &ChainJacobian<N>,
) -> Scaled {
    if !jacobian.is_regular() || jacobian.len < 2 || N < 2 {
        return Scaled::ZERO;
    }
    let last = jacobian.len - 1;
    let at_sensor = jacobian.lu.pivot_determinant(last).abs();
    let along = if vertices[0].kind == vertex_kind::PINNED_DIRECTION {
        jacobian.lu.transfer_determinant(&jacobian.c, 0, last)
    } else {
        jacobian
            .lu
            .transfer_determinant(&jacobian.c, 1, last)
            .times(geometry_term(&vertices[0], &vertices[1]))
    };
    along.abs().over(at_sensor)
}

/// The left side of the identity, `prod G(x_i, x_{i+1}) / |det J|`; zero when J is singular.
#[inline]
pub fn measure_by_geometry_terms<const N: usize>(
    vertices: &[ChainVertex; N],
    jacobian: &ChainJacobian<N>,
) -> Scaled {
    if !jacobian.is_regular() {
        return Scaled::ZERO;
    }
    let mut product = Scaled::ONE;
    let n = jacobian.len.min(N);
    for i in 1..n {
        product = product.times(geometry_term(&vertices[i - 1], &vertices[i]));
    }
    product.over(jacobian.half_vectors_per_vertex_area())
}

/// The right side of the identity: the density of the path measure in half-vector space, without the BSDFs. Zero when J is
/// singular.
#[inline]
pub fn half_vector_measure<const N: usize>(
    vertices: &[ChainVertex; N],
    jacobian: &ChainJacobian<N>,
    form: u32,
) -> Scaled {
    let mut product = generalized_geometry_term(vertices, jacobian);
    let n = jacobian.len.min(N);
    for i in 2..n {
        product = product.times(scattering_measure(
            &vertices[i - 2],
            &vertices[i - 1],
            &vertices[i],
            form,
        ));
    }
    product
}

/// `|do / dh| |o . n| q` of an inner vertex: projected solid angle of its outgoing direction per half vector in the form's
/// measure. For an index-matched vertex the constraint is (s.H, t.H) and the weight the ratio of the cosines to both normals.
#[inline]
pub fn scattering_measure(
    previous: &ChainVertex,
    x: &ChainVertex,
    next: &ChainVertex,
    form: u32,
) -> f32 {
    let wi = Edge::new(x.position, previous.position).w;
    let wo = Edge::new(x.position, next.position).w;
    if x.kind == vertex_kind::INDEX_MATCHED {
        let cos_o = abs(x.normal.dot(wo));
        return if cos_o > 1e-12 {
            x.cosine(wo) / cos_o
        } else {
            0.0
        };
    }
    let h = half_vector(wi, wo, x.eta, x.normal);
    let cos_h = abs(h.h.dot(x.normal));
    let q = if form == half_vector_form::SLOPE {
        cos_h * cos_h * cos_h
    } else if cos_h > 1e-12 {
        1.0 / cos_h
    } else {
        0.0
    };
    h.solid_angle_per_half_vector(wo, x.eta) * x.cosine(wo) * q
}
