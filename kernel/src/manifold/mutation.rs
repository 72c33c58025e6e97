//! A mutation in half-vector space: the walk with its test of reversibility, or a jump between sub-manifolds.
//!
//! From the path X and proposed half vectors H':
//! - the walk finds Y, and the walk from Y to the half vectors of X finds X again: a *walk*. Its densities per area of
//!   vertices are `p(H' | H) |det J(Y)|` and `p(H | H') |det J(X)|`.
//! - the walk finds Y but does not come back: nothing. X lies in another sub-manifold than Y.
//! - the walk fails: the first prediction, projected once, may be a valid path Y: a *jump* (thesis section 8.1.2). Its
//!   density per area is that of the predicted points on the tangent planes of X, carried along the rays to the points found,
//!
//!   `p(H' | H) |det J(X)| prod_i G(y_{i-1}, y_i) / G(y_{i-1}, x'_i)`,
//!
//!   with x'_i in the tangent plane of x_i and i counted from the end where the projection starts. The way back is the same
//!   construction: the points x'_i are where the rays of X meet the tangent planes of Y, and its half vectors are
//!   `H(Y) + J(Y) dX`. It exists only if the walk from Y to them fails as well. That is the condition under which a jump
//!   would be made from Y, so the pair is in detailed balance.
//!
//! Misprint: the thesis writes `|dX / dH| = |J|^-1` in the first density. A density per area is `p_H |dH / dX|`, with |det J|.
//!
//! Checked: the densities of jumps against a histogram of projected predictions; the way back leads to X.

use super::chain::ChainJacobian;
use super::constraint::Edge;
use super::projection::{is_edge_free, project};
use super::vertex::{ChainVertex, vertex_kind};
use super::walk::{
    WalkOptions, is_same_path, predict, residual, starts_at_sensor, walk, walk_status,
};
use crate::math::block_tridiagonal::determinant2;
use crate::math::float::abs;
use crate::math::scaled::Scaled;
use crate::scene::{SceneView, Traverse};
use glam::{Vec2, Vec3};

/// What a mutation has come to.
pub mod mutation_kind {
    /// No path.
    pub const FAILED: u32 = 0;
    /// A path was found, from which the walk does not come back.
    pub const NOT_REVERSIBLE: u32 = 1;
    /// A reversible walk.
    pub const WALK: u32 = 2;
    /// A jump to another sub-manifold.
    pub const JUMP: u32 = 3;
}

/// A proposed path.
#[derive(Clone, Copy, Debug)]
pub struct Mutation<const N: usize> {
    /// The path, for walks and jumps.
    pub vertices: [ChainVertex; N],
    /// Its constraints.
    pub jacobian: ChainJacobian<N>,
    /// One of [`mutation_kind`].
    pub kind: u32,
    /// How the walk ended: one of [`walk_status`].
    pub walk_status: u32,
    /// Iterations of the walk.
    pub iterations: u32,
    /// Iterations of the walk back.
    pub reverse_iterations: u32,
    /// Half vectors that lead back: those of the old path for walks.
    pub reverse_target: [Vec2; N],
    /// Density per area of vertices over density of the proposed half vectors.
    pub forward_factor: Scaled,
    /// The same for the way back, to multiply the density of `reverse_target` around the new path.
    pub reverse_factor: Scaled,
}

/// Proposes the path with half vectors `target`.
pub fn mutate<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    start: &[ChainVertex; N],
    jacobian: &ChainJacobian<N>,
    target: &[Vec2; N],
    options: &WalkOptions,
) -> Mutation<N> {
    let there = walk(view, start, jacobian, target, options);
    let mut out = Mutation {
        vertices: there.vertices,
        jacobian: *jacobian,
        kind: mutation_kind::FAILED,
        walk_status: there.status,
        iterations: there.iterations,
        reverse_iterations: 0,
        reverse_target: jacobian.h,
        forward_factor: Scaled::ZERO,
        reverse_factor: Scaled::ZERO,
    };
    if !there.is_converged() {
        jump(view, start, jacobian, target, options, &mut out);
        return out;
    }
    let len = jacobian.len;
    let found = ChainJacobian::new(&there.vertices, len, options.form);
    let back = walk(view, &there.vertices, &found, &jacobian.h, options);
    out.jacobian = found;
    out.reverse_iterations = back.iterations;
    out.kind = mutation_kind::NOT_REVERSIBLE;
    if back.is_converged() && is_same_path(&back.vertices, start, len, options) {
        out.kind = mutation_kind::WALK;
        out.forward_factor = density_factor(&found);
        out.reverse_factor = density_factor(jacobian);
    }
    out
}

/// |det J| over the inner vertices: rows of pinned directions are eliminated with their endpoints.
#[inline]
fn density_factor<const N: usize>(jacobian: &ChainJacobian<N>) -> Scaled {
    if !jacobian.is_regular() || jacobian.len < 2 || jacobian.len > N {
        return Scaled::ZERO;
    }
    let ends = Scaled::ONE
        .times(determinant2(jacobian.b[0]))
        .times(determinant2(jacobian.b[jacobian.len - 1]));
    jacobian.half_vectors_per_vertex_area().over(ends.abs())
}

/// The jump that the failed walk leaves.
fn jump<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    start: &[ChainVertex; N],
    jacobian: &ChainJacobian<N>,
    target: &[Vec2; N],
    options: &WalkOptions,
    out: &mut Mutation<N>,
) {
    let len = jacobian.len;
    if len < 3 || len > N || !jacobian.is_regular() {
        return;
    }
    let from_sensor = starts_at_sensor(jacobian);
    let mut dx = residual(jacobian, target);
    if !jacobian.lu.solve(&mut dx) {
        return;
    }
    let predicted = predict(start, &dx, 1.0);
    let trial = project(view, start, len, &predicted, from_sensor);
    if !trial.valid || !is_closed(view, &trial.vertices, len, from_sensor) {
        return;
    }
    let found = ChainJacobian::new(&trial.vertices, len, options.form);
    if !found.is_regular() {
        return;
    }
    let back_from_sensor = starts_at_sensor(&found);
    let back = retrace_prediction(&trial.vertices, start, len, &found, back_from_sensor);
    if !back.valid {
        return;
    }
    // Pinned ends keep exactly what they are pinned to.
    let moved = found.apply(&back.offsets);
    let mut reverse_target = found.h;
    for i in 1..(len - 1).min(N) {
        reverse_target[i] = found.h[i] + moved[i];
    }
    let reverse = walk(view, &trial.vertices, &found, &reverse_target, options);
    out.reverse_iterations = reverse.iterations;
    if reverse.status == walk_status::CONVERGED {
        return;
    }
    let forward = projection_factor(start, &trial.vertices, len, &predicted, from_sensor);
    let backward = projection_factor(
        &trial.vertices,
        start,
        len,
        &back.predicted,
        back_from_sensor,
    );
    let forward = times_scaled(density_factor(jacobian), forward);
    let backward = times_scaled(density_factor(&found), backward);
    if forward.mantissa == 0.0 || backward.mantissa == 0.0 {
        return;
    }
    out.kind = mutation_kind::JUMP;
    out.vertices = trial.vertices;
    out.jacobian = found;
    out.reverse_target = reverse_target;
    out.forward_factor = forward;
    out.reverse_factor = backward;
}

#[inline]
fn times_scaled(x: Scaled, y: Scaled) -> Scaled {
    let mut p = x.times(y.mantissa);
    if p.mantissa != 0.0 {
        p.exponent = p.exponent.wrapping_add(y.exponent);
    }
    p
}

/// Whether the edge that the projection did not trace is free.
#[inline]
fn is_closed<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    vertices: &[ChainVertex; N],
    len: usize,
    from_sensor: bool,
) -> bool {
    if len < 2 || len > N {
        return false;
    }
    let (x, y) = if from_sensor {
        (1, 0)
    } else {
        (len - 2, len - 1)
    };
    is_edge_free(view, &vertices[x], &vertices[y])
}

/// The prediction from one path that would project onto another.
#[derive(Clone, Copy, Debug)]
pub struct Prediction<const N: usize> {
    /// The points on the tangent planes.
    pub predicted: [Vec3; N],
    /// Their offsets from the vertices of the first path.
    pub offsets: [Vec2; N],
    /// Whether there is one.
    pub valid: bool,
}

/// Where the edges of `to`, from the end where a projection starts, meet the tangent planes of `from`.
pub fn retrace_prediction<const N: usize>(
    from: &[ChainVertex; N],
    to: &[ChainVertex; N],
    len: usize,
    jacobian: &ChainJacobian<N>,
    from_sensor: bool,
) -> Prediction<N> {
    let mut out = Prediction {
        predicted: [Vec3::ZERO; N],
        offsets: [Vec2::ZERO; N],
        valid: false,
    };
    if len < 3 || len > N {
        return out;
    }
    let last = len - 1;
    for step in 1..last {
        let i = if from_sensor { last - step } else { step };
        let before = if from_sensor { i + 1 } else { i - 1 };
        if i >= N || before >= N {
            return out;
        }
        let origin = to[before].position;
        let direction = Edge::new(origin, to[i].position).w;
        let normal = from[i].geometric_normal;
        let cosine = direction.dot(normal);
        let t = (from[i].position - origin).dot(normal) / cosine;
        if !(abs(cosine) > 1e-6) || !(t > 0.0) || !(t < 1e15) {
            return out;
        }
        let d = origin + direction * t - from[i].position;
        out.offsets[i] = Vec2::new(from[i].tangent_u.dot(d), from[i].tangent_v.dot(d));
        out.predicted[i] = from[i].moved(out.offsets[i]);
    }
    // Endpoints with a pinned direction follow their neighbours: B dx + C dx' = 0.
    let inverse = crate::math::block_tridiagonal::invert(jacobian.b[0]).inverse;
    out.offsets[0] = -(inverse * (jacobian.c[0] * out.offsets[1.min(N - 1)]));
    let inverse = crate::math::block_tridiagonal::invert(jacobian.b[last]).inverse;
    out.offsets[last] = -(inverse * (jacobian.a[last] * out.offsets[last - 1]));
    out.valid = true;
    out
}

/// `prod G(y_{i-1}, y_i) / G(y_{i-1}, x'_i)`: density per area of the points found over that of the points predicted.
fn projection_factor<const N: usize>(
    from: &[ChainVertex; N],
    found: &[ChainVertex; N],
    len: usize,
    predicted: &[Vec3; N],
    from_sensor: bool,
) -> Scaled {
    let mut product = Scaled::ONE;
    let last = len.wrapping_sub(1);
    for step in 1..last.min(N) {
        let i = if from_sensor { last - step } else { step };
        let before = if from_sensor { i + 1 } else { i - 1 };
        if i >= N || before >= N {
            return Scaled::ZERO;
        }
        let origin = found[before].position;
        let to_found = Edge::new(origin, found[i].position);
        let to_predicted = Edge::new(origin, predicted[i]);
        // The cosine at the origin is that of the same ray, and parallel rays have no distance.
        let mut ratio = found[i].cosine(to_found.w) / from[i].cosine(to_found.w);
        if found[before].kind != vertex_kind::PINNED_DIRECTION {
            let r = to_found.inverse_length / to_predicted.inverse_length;
            ratio *= r * r;
        }
        product = product.times(ratio);
    }
    product
}
