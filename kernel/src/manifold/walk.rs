//! The walk: from a path and new half vectors to the path that has them.
//!
//! A Newton method with the constraint Jacobian (thesis section 8.1.1). Each iteration
//! 1. *predicts* all vertices at once on their tangent planes, `dX = beta J^-1 (H_target - H)`,
//! 2. *corrects* them by casting rays from one end of the chain to the other ([`super::projection`]), from the sensor when
//!    `|T_1| / |T_{k-1}| < 1` at the start, else from the light, so that errors shrink along the chain,
//! 3. accepts when the largest error of a half vector has shrunk, and doubles `beta` up to 1; else halves it.
//!
//! Converged means: the half vectors agree within [`WalkOptions::half_vector_tolerance`] and Newton's next step is below
//! [`WalkOptions::position_tolerance`] times the scene's size, so that the answer does not depend on where the world's origin
//! lies (published codes divide by coordinates); or the next step is below [`RESOLUTION`], where positions round and a short
//! edge or an index near one turns their rounding into more than the tolerance of half vectors. The last edge must be free;
//! all others are by construction.
//!
//! A walk is *reversible* when the walk from its end back to the old half vectors ends at the old vertices. Only reversible
//! walks are in detailed balance. Checked: sphere caustics, mirrors and slabs with known answers, reversibility.

use super::chain::ChainJacobian;
use super::constraint::half_vector_form;
use super::projection::{is_edge_free, largest_distance, project};
use super::vertex::ChainVertex;
use crate::math::float::safe_sqrt;
use crate::scene::{SceneView, Traverse};
use glam::{Vec2, Vec3};

/// Limits of a walk.
#[derive(Clone, Copy, Debug)]
pub struct WalkOptions {
    /// One of [`half_vector_form`].
    pub form: u32,
    /// The most projections.
    pub max_iterations: u32,
    /// Smallest part of a Newton step that is tried.
    pub smallest_step: f32,
    /// Largest distance to the exact vertex, over the scene's size.
    pub position_tolerance: f32,
    /// Largest error of a half vector's coordinates.
    pub half_vector_tolerance: f32,
    /// Largest distance between the vertices of a path and of its return, over the scene's size.
    pub reversibility_tolerance: f32,
    /// Radius of the scene's bounding sphere.
    pub scene_scale: f32,
    /// Where projections start: one of [`walk_start`].
    pub start: u32,
}

/// Ends at which projections start.
pub mod walk_start {
    /// The one from which errors shrink along the chain (thesis section 8.1.1).
    pub const CHOSEN: u32 = 0;
    /// The light.
    pub const LIGHT: u32 = 1;
    /// The sensor.
    pub const SENSOR: u32 = 2;
}

impl WalkOptions {
    /// The usual limits for a scene of this radius: slopes, 20 iterations, steps down to 1 / 1024, 1e-4 and 1e-3 of the scene.
    #[inline]
    pub fn new(scene_scale: f32) -> WalkOptions {
        WalkOptions {
            form: half_vector_form::SLOPE,
            max_iterations: 20,
            smallest_step: SMALLEST_STEP,
            position_tolerance: 1e-4,
            half_vector_tolerance: 1e-4,
            reversibility_tolerance: 1e-3,
            scene_scale,
            start: walk_start::CHOSEN,
        }
    }

    /// Whether projections of a chain with these constraints start at the sensor.
    #[inline]
    pub fn projects_from_sensor<const N: usize>(&self, jacobian: &ChainJacobian<N>) -> bool {
        if self.start == walk_start::CHOSEN {
            starts_at_sensor(jacobian)
        } else {
            self.start == walk_start::SENSOR
        }
    }
}

/// Newton steps below this times the scene's size are rounding of positions.
pub const RESOLUTION: f32 = 4e-6;

/// How a walk ended.
pub mod walk_status {
    /// The path was found.
    pub const CONVERGED: u32 = 0;
    /// J had no inverse, or a constraint did not exist.
    pub const SINGULAR: u32 = 1;
    /// No step, however small, came nearer.
    pub const STALLED: u32 = 2;
    /// The iterations were used up.
    pub const TOO_LONG: u32 = 3;
    /// The path was found, but its last edge is blocked.
    pub const BLOCKED: u32 = 4;
}

/// The end of a walk.
#[derive(Clone, Copy, Debug)]
pub struct Walk<const N: usize> {
    /// The path; the last one reached when not converged.
    pub vertices: [ChainVertex; N],
    /// Number of vertices.
    pub len: usize,
    /// One of [`walk_status`].
    pub status: u32,
    /// Projections that were tried.
    pub iterations: u32,
}

impl<const N: usize> Walk<N> {
    /// Whether the path was found.
    #[inline]
    pub fn is_converged(&self) -> bool {
        self.status == walk_status::CONVERGED
    }
}

/// The usual smallest part of a Newton step.
const SMALLEST_STEP: f32 = 1.0 / 1024.0;

/// Largest error of a half vector; f32::MAX for what is not finite.
#[inline]
pub(super) fn largest(v: &[Vec2], len: usize) -> f32 {
    let mut largest = 0.0;
    for i in 0..len.min(v.len()) {
        let size = safe_sqrt(v[i].length_squared());
        largest = if size <= largest { largest } else { size };
    }
    if largest <= f32::MAX {
        largest
    } else {
        f32::MAX
    }
}

/// `target - h` of a chain.
#[inline]
pub(super) fn residual<const N: usize>(
    jacobian: &ChainJacobian<N>,
    target: &[Vec2; N],
) -> [Vec2; N] {
    let mut dh = [Vec2::ZERO; N];
    for i in 0..jacobian.len.min(N) {
        dh[i] = target[i] - jacobian.h[i];
    }
    dh
}

/// All vertices moved on their tangent planes by `beta dx`.
#[inline]
pub(super) fn predict<const N: usize>(
    vertices: &[ChainVertex; N],
    dx: &[Vec2; N],
    beta: f32,
) -> [Vec3; N] {
    let mut predicted = [Vec3::ZERO; N];
    for i in 0..N {
        predicted[i] = vertices[i].moved(dx[i] * beta);
    }
    predicted
}

/// Whether a projection starts at the sensor (thesis section 8.1.1).
#[inline]
pub fn starts_at_sensor<const N: usize>(jacobian: &ChainJacobian<N>) -> bool {
    jacobian.sensitivity() < 1.0
}

/// Walks from `start`, whose constraints are `jacobian`, to the path with the half vectors `target` (zero at pinned ends).
pub fn walk<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    start: &[ChainVertex; N],
    jacobian: &ChainJacobian<N>,
    target: &[Vec2; N],
    options: &WalkOptions,
) -> Walk<N> {
    walk_from(
        view,
        start,
        jacobian,
        target,
        options,
        options.projects_from_sensor(jacobian),
    )
}

/// [`walk`] with the end at which projections start.
pub fn walk_from<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    start: &[ChainVertex; N],
    jacobian: &ChainJacobian<N>,
    target: &[Vec2; N],
    options: &WalkOptions,
    from_sensor: bool,
) -> Walk<N> {
    let len = jacobian.len;
    let mut out = Walk {
        vertices: *start,
        len,
        status: walk_status::SINGULAR,
        iterations: 0,
    };
    if len < 2 || len > N {
        return out;
    }
    let mut dx = residual(jacobian, target);
    let mut error = largest(&dx, len);
    if !jacobian.is_regular() || !jacobian.lu.solve(&mut dx) {
        return out;
    }
    let mut beta = 1.0;
    loop {
        let step = largest(&dx, len) / options.scene_scale.max(f32::MIN_POSITIVE);
        let is_near = step <= options.position_tolerance;
        if (error <= options.half_vector_tolerance && is_near) || step <= RESOLUTION {
            let (x, y) = if from_sensor {
                (1, 0)
            } else {
                (len - 2, len - 1)
            };
            let free = is_edge_free(view, &out.vertices[x], &out.vertices[y]);
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
        let predicted = predict(&out.vertices, &dx, beta);
        let trial = project(view, &out.vertices, len, &predicted, from_sensor);
        let mut is_nearer = false;
        if trial.valid {
            let next = ChainJacobian::unfactored(&trial.vertices, len, options.form);
            let mut step = residual(&next, target);
            let next_error = largest(&step, len);
            if next_error < error && next.solve(&mut step) {
                is_nearer = true;
                out.vertices = trial.vertices;
                dx = step;
                error = next_error;
            }
        }
        if is_nearer {
            beta = if beta < 0.5 { 2.0 * beta } else { 1.0 };
        } else {
            beta *= 0.5;
            if beta < options.smallest_step {
                out.status = walk_status::STALLED;
                return out;
            }
        }
    }
}

/// Whether two chains are the same path, within the tolerance of reversibility.
#[inline]
pub fn is_same_path<const N: usize>(
    a: &[ChainVertex; N],
    b: &[ChainVertex; N],
    len: usize,
    options: &WalkOptions,
) -> bool {
    largest_distance(a, b, len) <= options.reversibility_tolerance * options.scene_scale
}
