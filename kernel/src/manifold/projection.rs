//! Predicted vertices back onto the surfaces, by casting rays from vertex to vertex.
//!
//! The corrector of the walk (thesis section 8.1.1): from one end of the chain, each ray leads from the vertex just found
//! towards the next predicted point and lands on whatever it hits. A landing must be on the same material and on the same
//! sides as before; the new vertex keeps the kind, the index, the roughness and the reference vector of the old one, so that
//! its half vector is measured in the same chart. What textures change is for the caller to look up afterwards.
//!
//! A pinned direction moves its endpoint in a plane: at the start of the projection the ray leaves the predicted point along
//! the direction, at its end the endpoint is the foot of the neighbour on the plane.

use super::constraint::Edge;
use super::vertex::{ChainVertex, vertex_kind};
use crate::math::Ray;
use crate::math::float::safe_sqrt;
use crate::scene::intersect::{is_traceable, offset_by, segment};

use crate::scene::surface::checked::checked_surface_at;
use crate::scene::{SceneView, Traverse};
use glam::Vec3;

/// A chain that a projection has made.
#[derive(Clone, Copy, Debug)]
pub struct Projection<const N: usize> {
    /// Vertices; those of the old chain from the failure on.
    pub vertices: [ChainVertex; N],
    /// Whether all rays landed.
    pub valid: bool,
}

/// A vertex that a ray has found.
#[derive(Clone, Copy, Debug)]
pub struct TracedVertex {
    /// The vertex; the old one when `valid` is false.
    pub vertex: ChainVertex,
    /// Whether the ray hit the material of the old vertex.
    pub valid: bool,
}

/// The ray that leaves a vertex towards a point; not traceable for coincident points.
#[inline]
pub fn ray_towards(from: &ChainVertex, to: Vec3) -> Ray {
    let edge = Edge::new(from.position, to);
    Ray::new(
        offset_by(
            from.position,
            from.geometric_normal,
            edge.w,
            from.position_error,
        ),
        edge.w,
    )
}

/// Traces a ray to the successor of `old`.
#[inline]
pub fn land<T: Traverse>(view: &SceneView<'_, T>, ray: &Ray, old: &ChainVertex) -> TracedVertex {
    if !is_traceable(ray) {
        return TracedVertex {
            vertex: *old,
            valid: false,
        };
    }
    let hit = view.traverse.closest_hit(ray);
    let found = checked_surface_at(&view.tables, ray, &hit);
    if !found.valid {
        return TracedVertex {
            vertex: *old,
            valid: false,
        };
    }
    let point = found.point;
    let mut vertex = ChainVertex::without_axis(&point, old.reference);
    if old.alpha.x != old.alpha.y {
        vertex.set_axis(&point);
    }
    vertex.kind = old.kind;
    vertex.eta = old.eta;
    vertex.alpha = old.alpha;
    TracedVertex {
        vertex,
        valid: point.material == old.material,
    }
}

/// Projects `predicted` points onto the surfaces, from the light or from the sensor. The chain's ends stay, but for pinned
/// directions.
#[inline]
pub fn project<T: Traverse, const N: usize>(
    view: &SceneView<'_, T>,
    old: &[ChainVertex; N],
    len: usize,
    predicted: &[Vec3; N],
    from_sensor: bool,
) -> Projection<N> {
    let mut out = Projection {
        vertices: *old,
        valid: false,
    };
    if len < 2 || len > N {
        return out;
    }
    let last = len - 1;
    let first_end = if from_sensor { last } else { 0 };
    if old[first_end].kind == vertex_kind::PINNED_DIRECTION {
        out.vertices[first_end].position = predicted[first_end];
    }
    for step in 1..last {
        let i = if from_sensor { last - step } else { step };
        let before = if from_sensor { i + 1 } else { i - 1 };
        if i >= N || before >= N {
            return out;
        }
        let origin = out.vertices[before];
        let ray = if origin.kind == vertex_kind::PINNED_DIRECTION {
            Ray::new(origin.position, origin.geometric_normal)
        } else {
            ray_towards(&origin, predicted[i])
        };
        let landing = land(view, &ray, &old[i]);
        if !landing.valid {
            return out;
        }
        out.vertices[i] = landing.vertex;
    }
    let (other_end, neighbour) = if from_sensor {
        (0, 1)
    } else {
        (last, last - 1)
    };
    if old[other_end].kind == vertex_kind::PINNED_DIRECTION {
        let d = old[other_end].geometric_normal;
        let x = out.vertices[neighbour].position;
        out.vertices[other_end].position = x - d * d.dot(x - old[other_end].position);
    }
    out.valid = sides_agree(old, &out.vertices, len);
    out
}

/// Whether each inner vertex of two chains has its neighbours on the same sides.
#[inline]
pub fn sides_agree<const N: usize>(
    old: &[ChainVertex; N],
    new: &[ChainVertex; N],
    len: usize,
) -> bool {
    let mut agree = true;
    let n = len.min(N);
    for i in 2..n {
        agree = agree
            && side(&old[i - 1], &old[i - 2]) == side(&new[i - 1], &new[i - 2])
            && side(&old[i - 1], &old[i]) == side(&new[i - 1], &new[i]);
    }
    agree
}

/// Whether `to` lies on the outside of the surface at `x`.
#[inline]
fn side(x: &ChainVertex, to: &ChainVertex) -> bool {
    x.geometric_normal.dot(to.position - x.position) > 0.0
}

/// Whether the edge between two neighbouring vertices of a chain is unoccluded; behind a pinned direction, the whole ray to
/// infinity.
#[inline]
pub fn is_edge_free<T: Traverse>(
    view: &SceneView<'_, T>,
    x: &ChainVertex,
    y: &ChainVertex,
) -> bool {
    let towards = y.position - x.position;
    let from = offset_by(x.position, x.geometric_normal, towards, x.position_error);
    let to = offset_by(y.position, y.geometric_normal, -towards, y.position_error);
    let ray = if y.kind == vertex_kind::PINNED_DIRECTION {
        Ray::new(from, -y.geometric_normal)
    } else if x.kind == vertex_kind::PINNED_DIRECTION {
        Ray::new(to, -x.geometric_normal)
    } else {
        segment(from, to)
    };
    is_traceable(&ray) && !view.traverse.is_occluded(&ray)
}

/// The largest distance between vertices of two chains.
#[inline]
pub fn largest_distance<const N: usize>(
    a: &[ChainVertex; N],
    b: &[ChainVertex; N],
    len: usize,
) -> f32 {
    let mut largest = 0.0;
    for i in 0..len.min(N) {
        let d = safe_sqrt((a[i].position - b[i].position).length_squared());
        // A NaN counts as far away.
        largest = if d <= largest { largest } else { d };
    }
    if largest <= f32::MAX {
        largest
    } else {
        f32::MAX
    }
}
