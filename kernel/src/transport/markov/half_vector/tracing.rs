//! Ends of a path that move before the rest follows: traced from the sensor or from the light, vertex by vertex.
//!
//! At each vertex on the way the path goes on through the same discrete event, or off a microfacet with a given half vector.

use super::super::veach::ChainPath;
use super::super::veach::candidate::append_from_light;
use super::super::veach::perturbation::repeat_event;
use super::path_chain::PathChain;
use crate::bsdf::Bsdf;
use crate::manifold::ChainVertex;
use crate::manifold::constraint::half_vector_form;
use crate::manifold::half_vector::{
    half_vector_of_projected, half_vector_of_slope, reflect, refract,
};
use crate::manifold::vertex::vertex_kind;
use crate::math::{Frame, Ray, float};
use crate::path::full_path::vertex::Vertex;
use crate::path::retarget::flow;
use crate::path::tracer::Tracer;
use crate::sampler::Sampler;
use crate::scene::{NONE, Traverse};
use glam::{Vec2, Vec3};

/// The ray with which a path goes on at a new vertex instead of the old vertex `x`, having come against the unit direction
/// `back`: with the half vector `h` of the form, off the side that the old path took.
pub fn scatter_at(
    vertex: &Vertex,
    x: &ChainVertex,
    back: Vec3,
    is_from_sensor: bool,
    h: Vec2,
    form: u32,
) -> Option<Ray> {
    let frame = Frame::from_normal_tangent(vertex.point.frame.n, x.reference);
    let direction = if x.kind == vertex_kind::INDEX_MATCHED {
        // Components across the normal that add up to h.
        let across = frame.s * (h.x - frame.s.dot(back)) + frame.t * (h.y - frame.t.dot(back));
        let cos2 = 1.0 - across.length_squared();
        if !(cos2 > 0.0) {
            return None;
        }
        let side = if frame.n.dot(back) > 0.0 { -1.0 } else { 1.0 };
        across + frame.n * (side * float::sqrt(cos2))
    } else {
        let m = if form == half_vector_form::SLOPE {
            half_vector_of_slope(&frame, h)
        } else {
            half_vector_of_projected(&frame, h)
        };
        let scattered = if x.kind == vertex_kind::REFLECTION {
            reflect(back, m)
        } else {
            refract(back, m, if is_from_sensor { 1.0 / x.eta } else { x.eta })
        };
        if !scattered.valid {
            return None;
        }
        scattered.wo
    };
    Some(vertex.point.spawn(direction.normalize()))
}

/// Traces `y` from vertex `from`, which `ray` leaves, to vertex `last` nearer to the light; `half_vector(j)` is what the vertex j
/// between them shall have. The other vertices of `y` stay. Returns whether the path can go on as `x` does.
#[allow(clippy::too_many_arguments)]
pub fn trace_from_sensor<T: Traverse, S: Sampler>(
    tracer: &Tracer<'_, T>,
    x: &ChainPath,
    chain: &PathChain,
    y: &mut ChainPath,
    ray: Ray,
    [from, last]: [usize; 2],
    form: u32,
    bsdf: &mut Bsdf,
    sampler: &mut S,
    mut half_vector: impl FnMut(usize, &mut S) -> Option<Vec2>,
) -> bool {
    let tables = &tracer.view.tables;
    let k = x.edges();
    let mut ray = ray;
    for j in (last..from).rev() {
        let arrival = tracer.trace(&ray, j + 1 == k, sampler);
        let mut vertex = match arrival.point {
            Some(point) if j > 0 || point.emitter != NONE => Vertex::new(tables, &point),
            None if j == 0 && tables.info.environment != NONE => {
                Vertex::without_surface(tables, Vec3::ZERO)
            }
            _ => return false,
        };
        if j == 0 {
            match arrival.point {
                Some(point) => y.emitter = point.emitter,
                None => {
                    y.emitter = tables.info.environment;
                    y.to_light = ray.direction;
                }
            }
        } else {
            vertex.event = x.vertices[j].event;
        }
        vertex.edge = arrival.edge;
        y.vertices[j] = vertex;
        if j == last {
            break;
        }
        let back = -ray.direction;
        let next = if x.vertices[j].is_smooth() {
            half_vector(j, sampler)
                .and_then(|h| scatter_at(&vertex, &chain.vertices[j], back, true, h, form))
        } else {
            repeat_event(tracer, &vertex, flow::IMPORTANCE, back, bsdf)
        };
        match next {
            Some(next) => ray = next,
            None => return false,
        }
    }
    true
}

/// The same from vertex `from` to vertex `last` nearer to the sensor, with the half vectors that the vertices between them had.
#[allow(clippy::too_many_arguments)]
pub fn trace_from_light<T: Traverse, S: Sampler>(
    tracer: &Tracer<'_, T>,
    x: &ChainPath,
    chain: &PathChain,
    y: &mut ChainPath,
    ray: Ray,
    [from, last]: [usize; 2],
    form: u32,
    bsdf: &mut Bsdf,
    sampler: &mut S,
) -> bool {
    let tables = &tracer.view.tables;
    let mut ray = ray;
    y.vertices.truncate(from + 1);
    for j in from + 1..=last {
        let arrival = tracer.trace(&ray, false, sampler);
        let Some(point) = arrival.point else {
            return false;
        };
        let mut vertex = Vertex::new(tables, &point);
        vertex.event = x.vertices[j].event;
        vertex.edge = arrival.edge;
        if j < last {
            let back = -ray.direction;
            let next = if x.vertices[j].is_smooth() {
                chain
                    .half_vector(j, form)
                    .and_then(|h| scatter_at(&vertex, &chain.vertices[j], back, false, h, form))
            } else {
                repeat_event(tracer, &vertex, flow::LIGHT, back, bsdf)
            };
            match next {
                Some(next) => ray = next,
                None => return false,
            }
        }
        append_from_light(y, vertex);
    }
    y.vertices.extend(x.vertices[last + 1..].iter().copied());
    true
}

/// Probability of standing at and passing what was met between `low` and `high`, from one of them to the other.
pub fn walked(path: &ChainPath, low: usize, high: usize, is_from_sensor: bool) -> f32 {
    (low..high)
        .map(|j| {
            let end = if is_from_sensor { j } else { j + 1 };
            let stop = if end == 0 {
                1.0
            } else {
                path.vertices[end].stop
            };
            path.vertices[j].edge.pass * stop
        })
        .product()
}
