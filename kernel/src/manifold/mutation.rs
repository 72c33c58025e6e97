//! A mutation in half-vector space: the walk with its test of reversibility, or a jump between sub-manifolds.
//!
//! From the path X and proposed half vectors H':
//! - the walk finds Y, and the walk from Y to the half vectors of X finds X again: a *walk*. Its densities per area of
//!   vertices are `p(H' | H) |det J(Y)|` and `p(H | H') |det J(X)|`.
//! - the walk finds Y, but the walk back does not find X: the proposal is rejected. X lies in another sub-manifold than Y.
//! - the walk fails: the first prediction, projected once, may be a valid path Y: a *jump* (thesis section 8.1.2). Its
//!   density per area is that of the predicted points on the tangent planes of X, carried along the rays to the points found,
//!
//!   `p(H' | H) |det J(X)| prod_i G(y_{i-1}, y_i) / G(y_{i-1}, x'_i)`,
//!
//!   with x'_i in the tangent plane of x_i and i counted from the end where the projection starts. The reverse jump is the
//!   same construction: the points x'_i are the intersections of the rays of X with the tangent planes of Y, and its half
//!   vectors are `H(Y) + J(Y) dX`. It exists only if the walk from Y to them fails as well. That is the condition under which
//!   a jump would be made from Y, so the pair is in detailed balance.
//!
//! Misprint: the thesis writes `|dX / dH| = |J|^-1` in the first density. A density per area is `p_H |dH / dX|`, with |det J|.
//!
//! Checked: the densities of jumps against a histogram of projected predictions; the reverse jump leads to X.

use super::chain::ChainJacobian;
use super::constraint::Edge;
use super::projection::{is_edge_free, project};
use super::vertex::{ChainVertex, vertex_kind};
use super::walk::{WalkOptions, is_same_path, predict, residual, walk, walk_status};
use crate::math::block::{determinant2, invert};
use crate::math::float::abs;
use crate::math::scaled::{Scaled, is_finite2};
use crate::scene::{SceneView, Traverse};
use glam::Vec2;

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
    /// The same for the reverse mutation, to multiply the density of `reverse_target` around the new path.
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
    let mut found = propose(view, start, jacobian, target, options);
    test_way_back(view, start, options, &mut found);
    found
}

/// The same without the walk back: a walk may turn out not to be reversible, and a jump to be none ([`test_way_back`]).
fn propose<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    start: &[ChainVertex; N],
    jacobian: &ChainJacobian<N>,
    target: &[Vec2; N],
    options: &WalkOptions,
) -> Mutation<N> {
    let there = walk(view, start, jacobian, target, options);
    if !there.is_converged() {
        let mut out = jump(view, start, jacobian, target, options);
        out.walk_status = there.status;
        out.iterations = there.iterations;
        return out;
    }
    let found = ChainJacobian::new(&there.vertices, jacobian.len, options.form);
    Mutation {
        vertices: there.vertices,
        jacobian: found,
        kind: mutation_kind::WALK,
        walk_status: there.status,
        iterations: there.iterations,
        reverse_iterations: 0,
        reverse_target: jacobian.h,
        forward_factor: density_factor(&found),
        reverse_factor: density_factor(jacobian),
    }
}

/// Makes a walk that does not come back to `start` irreversible, and a jump of none from which a walk would.
pub fn test_way_back<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    start: &[ChainVertex; N],
    options: &WalkOptions,
    found: &mut Mutation<N>,
) {
    if found.kind != mutation_kind::WALK && found.kind != mutation_kind::JUMP {
        return;
    }
    let (from, target) = (&found.vertices, &found.reverse_target);
    let back = walk(view, from, &found.jacobian, target, options);
    found.reverse_iterations = back.iterations;
    let leads_back = if found.kind == mutation_kind::WALK {
        back.is_converged() && is_same_path(&back.vertices, start, back.len, options)
    } else {
        back.status != walk_status::CONVERGED
    };
    if !leads_back {
        found.kind = if found.kind == mutation_kind::WALK {
            mutation_kind::NOT_REVERSIBLE
        } else {
            mutation_kind::FAILED
        };
        found.forward_factor = Scaled::ZERO;
        found.reverse_factor = Scaled::ZERO;
    }
}

/// |det J| over the inner vertices: rows of pinned directions are eliminated with their endpoints.
#[inline]
pub fn density_factor<const N: usize>(jacobian: &ChainJacobian<N>) -> Scaled {
    if !jacobian.is_regular() || jacobian.len < 2 || jacobian.len > N {
        return Scaled::ZERO;
    }
    let ends = Scaled::ONE
        .times(determinant2(jacobian.b[0]))
        .times(determinant2(jacobian.b[jacobian.len - 1]));
    jacobian.half_vectors_per_vertex_area().over(ends.abs())
}

/// The jump that a failed walk leaves, if the walk back fails as well ([`test_way_back`]).
pub fn jump<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    start: &[ChainVertex; N],
    jacobian: &ChainJacobian<N>,
    target: &[Vec2; N],
    options: &WalkOptions,
) -> Mutation<N> {
    let mut out = Mutation {
        vertices: *start,
        jacobian: *jacobian,
        kind: mutation_kind::FAILED,
        walk_status: walk_status::STALLED,
        iterations: 0,
        reverse_iterations: 0,
        reverse_target: jacobian.h,
        forward_factor: Scaled::ZERO,
        reverse_factor: Scaled::ZERO,
    };
    let len = jacobian.len;
    if len < 3 || len > N || !jacobian.is_regular() {
        return out;
    }
    let from_sensor = options.projects_from_sensor(jacobian);
    let mut dx = residual(jacobian, target);
    if !jacobian.lu.solve(&mut dx) {
        return out;
    }
    let predicted = predict(start, &dx, 1.0);
    let trial = project(view, start, len, &predicted, from_sensor);
    if !trial.valid || !is_closed(view, &trial.vertices, len, from_sensor) {
        return out;
    }
    let found = ChainJacobian::new(&trial.vertices, len, options.form);
    if !found.is_regular() {
        return out;
    }
    let forward = prediction_between(start, &trial.vertices, len, jacobian, from_sensor);
    let back_from_sensor = options.projects_from_sensor(&found);
    let backward = prediction_between(&trial.vertices, start, len, &found, back_from_sensor);
    if !forward.valid || !backward.valid {
        return out;
    }
    out.kind = mutation_kind::JUMP;
    out.vertices = trial.vertices;
    out.jacobian = found;
    out.reverse_target = backward.target;
    out.forward_factor = forward.factor;
    out.reverse_factor = backward.factor;
    out
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

/// The prediction from one path that projects onto another.
#[derive(Clone, Copy, Debug)]
pub struct Prediction<const N: usize> {
    /// The half vectors that would be proposed.
    pub target: [Vec2; N],
    /// Density per area of the other path's vertices over the density of the proposed half vectors.
    pub factor: Scaled,
    /// Whether there is one.
    pub valid: bool,
}

/// What prediction from the path `from`, with the constraints `jacobian`, is projected onto the path `to`: where the edges
/// of `to`, from the end where the projection starts, meet the tangent planes of `from`.
pub fn prediction_between<const N: usize>(
    from: &[ChainVertex; N],
    to: &[ChainVertex; N],
    len: usize,
    jacobian: &ChainJacobian<N>,
    from_sensor: bool,
) -> Prediction<N> {
    let mut out = Prediction {
        target: jacobian.h,
        factor: density_factor(jacobian),
        valid: false,
    };
    if len < 3 || len > N {
        return out;
    }
    let last = len - 1;
    let mut offsets = [Vec2::ZERO; N];
    for step in 1..last {
        let i = if from_sensor { last - step } else { step };
        let before = if from_sensor { i + 1 } else { i - 1 };
        if i >= N || before >= N {
            return out;
        }
        let is_parallel = to[before].kind == vertex_kind::PINNED_DIRECTION;
        let edge = Edge::new(to[before].position, to[i].position);
        let direction = if is_parallel {
            to[before].geometric_normal
        } else {
            edge.w
        };
        // From the point found to the tangent plane, along the ray that found it.
        let normal = from[i].geometric_normal;
        let cosine = direction.dot(normal);
        let along = (from[i].position - to[i].position).dot(normal) / cosine;
        let d = to[i].position + direction * along - from[i].position;
        let mut ratio = to[i].cosine(direction) / abs(cosine);
        if !is_parallel {
            // The predicted point must lie before the ray's origin, not behind it.
            let r = 1.0 + along * edge.inverse_length;
            if !(r > 0.0) {
                return out;
            }
            ratio *= r * r;
        }
        offsets[i] = Vec2::new(from[i].tangent_u.dot(d), from[i].tangent_v.dot(d));
        out.factor = out.factor.times(ratio);
        if !(abs(cosine) > 1e-6) || !is_finite2(offsets[i]) {
            return out;
        }
    }
    // Endpoints with a pinned direction follow their neighbours: B dx + C dx' = 0.
    offsets[0] = -(invert(jacobian.b[0]).inverse * (jacobian.c[0] * offsets[1.min(N - 1)]));
    offsets[last] = -(invert(jacobian.b[last]).inverse * (jacobian.a[last] * offsets[last - 1]));
    let moved = jacobian.apply(&offsets);
    for i in 1..last {
        out.target[i] += moved[i];
    }
    out.valid = out.factor.mantissa != 0.0;
    out
}
