//! Chains of vertices: the block-tridiagonal solver, constraints, Jacobians and measures in half-vector space.

use bytemuck::{Pod, Zeroable};
use halflight_kernel::glam::{Mat2, Vec2, Vec3};
use halflight_kernel::manifold::chain::{
    ChainJacobian, generalized_geometry_term, geometry_term, half_vector_measure,
};
use halflight_kernel::manifold::constraint::inner_constraint;
use halflight_kernel::manifold::vertex::ChainVertex;
use halflight_kernel::math::block_tridiagonal::BlockLu;

/// Block rows of a system.
pub const ROWS: usize = 6;

/// Vertices of a chain.
pub const VERTICES: usize = 5;

/// A block-tridiagonal system; blocks by columns.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SolveInput {
    /// Below the diagonal.
    pub a: [[f32; 4]; ROWS],
    /// On the diagonal.
    pub b: [[f32; 4]; ROWS],
    /// Above the diagonal.
    pub c: [[f32; 4]; ROWS],
    /// Right-hand side.
    pub h: [[f32; 2]; ROWS],
    /// Rows that there are.
    pub len: u32,
}

/// Two solutions of [`ROWS`] pairs, then ratios and flags; see [`solve`].
pub type SolveOutput = [f32; 32];

fn blocks(words: &[[f32; 4]; ROWS]) -> [Mat2; ROWS] {
    let mut out = [Mat2::ZERO; ROWS];
    for i in 0..ROWS {
        let m = words[i];
        out[i] = Mat2::from_cols(Vec2::new(m[0], m[1]), Vec2::new(m[2], m[3]));
    }
    out
}

/// The solutions of J x = h and of its transpose, the determinant, the condition, an element of the inverse and of the
/// transfer matrices.
pub fn solve(input: &SolveInput) -> SolveOutput {
    let (a, b, c) = (blocks(&input.a), blocks(&input.b), blocks(&input.c));
    let lu = BlockLu::<ROWS>::factor(&a, &b, &c, input.len as usize);
    let mut x = [Vec2::ZERO; ROWS];
    for i in 0..ROWS {
        x[i] = Vec2::new(input.h[i][0], input.h[i][1]);
    }
    let mut y = x;
    let is_solved = lu.solve(&mut x);
    let is_transposed = lu.solve_transposed(&mut y);
    let mut row = [Mat2::ZERO; ROWS];
    lu.last_row_of_inverse(&mut row);
    let mut transfer = [Mat2::ZERO; ROWS];
    lu.transfer(1, &mut transfer);
    let determinant = lu.determinant();
    let mut out = [0.0; 32];
    for i in 0..ROWS {
        out[2 * i] = x[i].x;
        out[2 * i + 1] = x[i].y;
        out[2 * ROWS + 2 * i] = y[i].x;
        out[2 * ROWS + 2 * i + 1] = y[i].y;
    }
    out[24] = determinant.mantissa;
    out[25] = determinant.exponent as f32;
    out[26] = row[0].x_axis.x;
    out[27] = row[0].y_axis.y;
    out[28] = transfer[0].x_axis.x;
    out[29] = transfer[0].y_axis.y;
    out[30] = lu.condition(&a, &b, &c);
    out[31] = if lu.is_singular() { 4.0 } else { 0.0 }
        + if is_solved { 2.0 } else { 0.0 }
        + if is_transposed { 1.0 } else { 0.0 };
    out
}

/// A vertex ([`ChainVertex`], in whose order the fields are).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[allow(missing_docs)]
pub struct VertexInput {
    pub position: [f32; 3],
    pub geometric_normal: [f32; 3],
    pub tangent_u: [f32; 3],
    pub tangent_v: [f32; 3],
    pub normal: [f32; 3],
    pub dn_u: [f32; 3],
    pub dn_v: [f32; 3],
    pub reference: [f32; 3],
    pub eta: f32,
    pub kind: u32,
}

/// A chain.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct ChainInput {
    /// Its vertices.
    pub vertices: [VertexInput; VERTICES],
    /// One of [`halflight_kernel::manifold::constraint::half_vector_form`].
    pub form: u32,
}

/// What a function returns, zero beyond that.
pub type ChainOutput = [f32; 16];

fn vector(v: [f32; 3]) -> Vec3 {
    Vec3::new(v[0], v[1], v[2])
}

fn vertex_of(v: &VertexInput) -> ChainVertex {
    ChainVertex {
        position: vector(v.position),
        geometric_normal: vector(v.geometric_normal),
        tangent_u: vector(v.tangent_u),
        tangent_v: vector(v.tangent_v),
        normal: vector(v.normal),
        dn_u: vector(v.dn_u),
        dn_v: vector(v.dn_v),
        reference: vector(v.reference),
        eta: v.eta,
        kind: v.kind,
        ..ChainVertex::NONE
    }
}

/// The constraint of the second vertex between the first and the third: A, B, C by columns, h, whether it exists, G.
pub fn constraint(input: &ChainInput) -> ChainOutput {
    let previous = vertex_of(&input.vertices[0]);
    let x = vertex_of(&input.vertices[1]);
    let next = vertex_of(&input.vertices[2]);
    let k = inner_constraint(&previous, &x, &next, input.form);
    [
        k.a.x_axis.x,
        k.a.x_axis.y,
        k.a.y_axis.x,
        k.a.y_axis.y,
        k.b.x_axis.x,
        k.b.x_axis.y,
        k.b.y_axis.x,
        k.b.y_axis.y,
        k.c.x_axis.x,
        k.c.x_axis.y,
        k.c.y_axis.x,
        k.c.y_axis.y,
        k.h.x,
        k.h.y,
        if k.valid { 1.0 } else { 0.0 },
        geometry_term(&previous, &x),
    ]
}

/// Logarithms of the chain's determinant, its generalised geometry term and its measure; its condition.
pub fn measure(input: &ChainInput) -> ChainOutput {
    let mut vertices = [ChainVertex::NONE; VERTICES];
    for i in 0..VERTICES {
        vertices[i] = vertex_of(&input.vertices[i]);
    }
    let jacobian = ChainJacobian::<VERTICES>::new(&vertices, VERTICES, input.form);
    let mut out = [0.0; 16];
    if !jacobian.is_regular() {
        return out;
    }
    out[0] = 1.0;
    out[1] = jacobian.half_vectors_per_vertex_area().ln_abs();
    out[2] = generalized_geometry_term(&vertices, &jacobian).ln_abs();
    out[3] = half_vector_measure(&vertices, &jacobian, input.form).ln_abs();
    out[4] = jacobian.condition();
    for i in 0..VERTICES {
        out[5 + 2 * i] = jacobian.h[i].x;
        out[6 + 2 * i] = jacobian.h[i].y;
    }
    out
}
