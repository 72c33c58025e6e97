//! Manifold exploration's walk, for comparison: one end follows T_1, the chain is retraced from the other.
//!
//! Jakob and Marschner 2012, "Manifold Exploration", with the half vectors of all inner vertices given (thesis section
//! 8.1.1, "the original correction scheme"). From x_0 a ray towards the guess for x_1 starts a chain that scatters at each
//! vertex off the microfacet of the target half vector; it ends on the tangent plane of x_k at x_k'. The guess
//! moves by `beta T_1 (x_k - x_k')`; beta is halved when a ray is lost, a refraction is total or the end moves away, and
//! doubled on success, up to one. Converged when x_k' is within [`WalkOptions::position_tolerance`] of the scene's size from
//! x_k. Half vectors are reproduced exactly, the endpoint within the tolerance: the converse of [`super::walk`].
//!
//! Domain: both ends pinned positions. Checked: finds the same paths as the walk where both converge.

use super::chain::ChainJacobian;
use super::constraint::{Edge, half_vector_form};
use super::half_vector::{half_vector_of_projected, half_vector_of_slope, reflect, refract};
use super::projection::{Projection, is_edge_free, land, ray_towards, sides_agree};
use super::vertex::{ChainVertex, vertex_kind};
use super::walk::{Walk, WalkOptions, walk_status};
use crate::math::Ray;
use crate::math::float::{abs, safe_sqrt};
use crate::scene::intersect::offset_by;
use crate::scene::{SceneView, Traverse};
use glam::{Mat2, Vec2, Vec3};

/// Walks from `start` to the path with the half vectors `target` by correcting its end with T_1.
pub fn explore<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    start: &[ChainVertex; N],
    len: usize,
    target: &[Vec2; N],
    options: &WalkOptions,
) -> Walk<N> {
    let mut out = Walk {
        vertices: *start,
        len,
        status: walk_status::SINGULAR,
        iterations: 0,
    };
    let is_pinned = |x: &ChainVertex| x.kind == vertex_kind::PINNED_POSITION;
    if len < 3 || len > N || !is_pinned(&start[0]) || !is_pinned(&start[len - 1]) {
        return out;
    }
    let last = len - 1;
    // A point in space gets a plane of its own, which stays while the chain moves.
    let mut goal = start[last].facing(start[last - 1].position);
    goal.geometric_normal = goal.tangent_u.cross(goal.tangent_v);
    let tolerance = options.position_tolerance * options.scene_scale;
    let chain = Chain {
        start,
        len,
        target,
        form: options.form,
    };
    // The first guess is the old x_1.
    let mut guess = start[1].position;
    let mut error = f32::MAX;
    let mut beta = 1.0;
    let mut step = Vec3::ZERO;
    let mut transfer = [Mat2::ZERO; N];
    loop {
        if error <= tolerance {
            out.vertices[last] = start[last];
            let free = is_edge_free(view, &out.vertices[last - 1], &start[last]);
            out.status = if free {
                walk_status::CONVERGED
            } else {
                walk_status::BLOCKED
            };
            return out;
        }
        if out.iterations >= options.max_iterations {
            out.status = walk_status::TOO_LONG;
            return out;
        }
        out.iterations += 1;
        let trial = chain.retrace(view, guess + step * beta, &goal);
        let mut is_nearer = false;
        if trial.valid {
            let miss = goal.position - trial.vertices[last].position;
            let distance = safe_sqrt(miss.length_squared());
            let chain = ChainJacobian::new(&trial.vertices, len, options.form);
            if distance < error && chain.is_regular() {
                is_nearer = true;
                chain.lu.transfer(last, &mut transfer);
                let at = trial.vertices[1];
                let end = trial.vertices[last];
                let dx = transfer[1] * Vec2::new(end.tangent_u.dot(miss), end.tangent_v.dot(miss));
                out.vertices = trial.vertices;
                guess = at.position;
                step = at.tangent_u * dx.x + at.tangent_v * dx.y;
                error = distance;
            }
        }
        if is_nearer {
            beta = if beta < 0.5 { 2.0 * beta } else { 1.0 };
        } else {
            beta *= 0.5;
            // A first trace that is lost has no step to shorten.
            if beta < options.smallest_step || error == f32::MAX {
                out.status = walk_status::STALLED;
                return out;
            }
        }
    }
}

/// A chain whose vertices are to move until it has other half vectors.
struct Chain<'a, const N: usize> {
    start: &'a [ChainVertex; N],
    len: usize,
    /// The half vectors, in the chart `form`.
    target: &'a [Vec2; N],
    form: u32,
}

impl<const N: usize> Chain<'_, N> {
    /// Traces the chain from x_0 towards `first`, scattering at the target microfacets, to the tangent plane of `goal`.
    fn retrace<T: Traverse>(
        &self,
        view: &SceneView<'_, T>,
        first: Vec3,
        goal: &ChainVertex,
    ) -> Projection<N> {
        let (old, len, target) = (self.start, self.len, self.target);
        let mut out = Projection {
            vertices: *old,
            valid: false,
        };
        if len < 3 || len > N {
            return out;
        }
        let last = len - 1;
        let mut ray = ray_towards(&old[0], first);
        for i in 1..last {
            let landing = land(view, &ray, &old[i]);
            if !landing.valid {
                return out;
            }
            let x = landing.vertex;
            out.vertices[i] = x;
            let wi = -ray.direction;
            let frame = x.frame();
            let m = if self.form == half_vector_form::SLOPE {
                half_vector_of_slope(&frame, target[i])
            } else {
                half_vector_of_projected(&frame, target[i])
            };
            let scattered = if x.kind == vertex_kind::REFLECTION {
                reflect(wi, m)
            } else if x.kind == vertex_kind::REFRACTION {
                refract(wi, m, x.eta)
            } else {
                super::half_vector::Outgoing {
                    wo: -wi,
                    valid: true,
                }
            };
            if !scattered.valid {
                return out;
            }
            let origin = offset_by(
                x.position,
                x.geometric_normal,
                scattered.wo,
                x.position_error,
            );
            ray = Ray::new(origin, scattered.wo);
        }
        let from = out.vertices[last - 1].position;
        let normal = goal.geometric_normal;
        let cosine = ray.direction.dot(normal);
        let t = (goal.position - from).dot(normal) / cosine;
        if !(abs(cosine) > 1e-6) || !(t > 0.0) || !(t < 1e15) {
            return out;
        }
        let mut end = *goal;
        end.position = from + ray.direction * t;
        out.vertices[last] = end;
        let first_edge = Edge::new(out.vertices[0].position, out.vertices[1].position);
        out.valid = first_edge.inverse_length > 0.0 && sides_agree(old, &out.vertices, len);
        out
    }
}
