//! Paths from which chains start: all that two walks and their connections make, and what further walks from the sensor hit.
//!
//! Light that only chance hits is found by one candidate in many thousands, which then starts most chains of a group, so a
//! candidate has nine walks from the sensor, of which one is connected with the light's and all may hit a light. A path
//! that strategy s makes has the weight f / sum_j n_j p_j, the balance heuristic's share of f / p_s, over the probabilities of surviving
//! Russian roulette in its two walks; n_0 is the number of walks from the sensor, all other n_j are one.
//!
//! With a target that is mollified, a connection makes a path with each of the ends blurred as well, if its materials allow that
//! ([`super::ends`]); with edits one for each pair of labels that its ends can have.

use super::ends::for_ends;
use super::{ChainPath, MAX_VERTICES};
use crate::bsdf::Bsdf;
use crate::math::{Ray, luminance};
use crate::path::full_path::Blurring;
use crate::path::full_path::edited::EditedWalk;
use crate::path::full_path::vertex::{Edge, SMOOTH, Vertex};
use crate::path::tracer::Tracer;
use crate::sampler::Sampler;
use crate::scene::emitter::emission::{self, EmissionSample};
use crate::scene::emitter::sample_direct_with_point;
use crate::scene::{NONE, SurfacePoint, Tables, Traverse, camera, emitter_kind};
use arrayvec::ArrayVec;
use glam::{Vec2, Vec3};

/// Probability that a walk goes on after the first vertices.
const SURVIVAL: f32 = 0.8;

/// Vertices after which walks may end at random.
const SURE_VERTICES: usize = 4;

/// Walks from the sensor of a candidate.
const HITTING_WALKS: usize = 9;

/// A walk that is part of candidates.
struct Subpath {
    vertices: ArrayVec<Vertex, MAX_VERTICES>,
    /// Where the walk left the scene, if it did.
    escaped: Option<Vec3>,
    /// What it passed on that last edge.
    last: Edge,
}

/// Probability that a walk has as many vertices.
fn survival(vertices: usize) -> f32 {
    let trials = vertices.saturating_sub(SURE_VERTICES);
    (0..trials).map(|_| SURVIVAL).product()
}

/// Follows a walk along a ray until it ends; `labels` draws those of edits.
fn walk<T: Traverse, S: Sampler>(
    tracer: &Tracer<'_, T>,
    ray: &Ray,
    from_sensor: bool,
    mut labels: Option<EditedWalk<'_>>,
    bsdf: &mut Bsdf,
    sampler: &mut S,
) -> Subpath {
    let mut subpath = Subpath {
        vertices: ArrayVec::new(),
        escaped: None,
        last: Edge::CLEAR,
    };
    let most = (MAX_VERTICES - 2).min(tracer.rules.max_depth as usize);
    let mut ray = *ray;
    while subpath.vertices.len() < most {
        let count = subpath.vertices.len();
        if count >= SURE_VERTICES && sampler.next_1d() >= SURVIVAL {
            break;
        }
        let arrival = tracer.trace(&ray, from_sensor && count == 0, sampler);
        let Some(point) = arrival.point else {
            subpath.escaped = Some(ray.direction);
            subpath.last = arrival.edge;
            break;
        };
        let mut vertex = Vertex::new(&tracer.view.tables, &point);
        vertex.edge = arrival.edge;
        let back = -ray.direction;
        let next = if tracer.guess(labels.as_ref(), &mut vertex, back, bsdf, sampler) {
            tracer.scatter(&mut labels, &mut vertex, back, bsdf, sampler)
        } else {
            None
        };
        subpath.vertices.push(vertex);
        match next {
            Some(next) => ray = next,
            None => break,
        }
    }
    subpath
}

/// A walk from a point of the lens, and where on the film it began.
struct SensorWalk {
    film: Vec2,
    u_lens: Vec2,
    lens: Vertex,
    subpath: Subpath,
}

/// A walk through a random point of the window.
fn sensor_walk<T: Traverse, S: Sampler>(
    tracer: &Tracer<'_, T>,
    bsdf: &mut Bsdf,
    sampler: &mut S,
) -> SensorWalk {
    let tables = &tracer.view.tables;
    let (film, u_lens) = (sampler.next_2d(), sampler.next_2d());
    let film = window_position(tables.camera.crop_offset, tables.camera.crop_size, film);
    let ray = camera::ray_through(&tables.camera, film, u_lens);
    SensorWalk {
        film,
        u_lens,
        lens: Vertex::without_surface(tables, ray.origin),
        subpath: walk(tracer, &ray, true, tracer.from_sensor(), bsdf, sampler),
    }
}

/// Passes on a path that strategy `s` made at `film` with a probability of surviving Russian roulette; without light where it is none.
fn finish<T: Traverse>(
    tracer: &Tracer<'_, T>,
    path: &mut ChainPath,
    film: Vec2,
    s: usize,
    survived: f32,
    bsdf: &mut Bsdf,
    add: &mut impl FnMut(&ChainPath, f32),
) {
    let tables = &tracer.view.tables;
    path.film = film;
    if !tracer.evaluate(path, bsdf) || !path.may_join(s) {
        return add(path, 0.0);
    }
    let sum: f32 = (1..=path.edges())
        .map(|s| path.strategy_pdf(tables, s, false))
        .sum();
    let sum = sum + HITTING_WALKS as f32 * path.strategy_pdf(tables, 0, false);
    let weight = luminance(path.value) / (sum * survived);
    add(path, if weight.is_finite() { weight } else { 0.0 });
}

/// Passes on the paths to lights that a walk hits.
fn hits<T: Traverse>(
    tracer: &Tracer<'_, T>,
    walk: &SensorWalk,
    path: &mut ChainPath,
    bsdf: &mut Bsdf,
    add: &mut impl FnMut(&ChainPath, f32),
) {
    let tables = &tracer.view.tables;
    let vertices = &walk.subpath.vertices;
    path.u_lens = walk.u_lens;
    for (i, end) in vertices.iter().enumerate() {
        if end.point.emitter == NONE {
            continue;
        }
        path.vertices.clear();
        path.vertices.extend(vertices[..=i].iter().rev().copied());
        path.vertices.push(walk.lens);
        path.vertices[0].event = SMOOTH;
        path.vertices[0].labels = [0; 2];
        path.emitter = end.point.emitter;
        finish(tracer, path, walk.film, 0, survival(i + 1), bsdf, add);
    }
    if let Some(direction) = walk.subpath.escaped
        && tables.info.environment != NONE
    {
        path.vertices.clear();
        let mut sky = Vertex::without_surface(tables, Vec3::ZERO);
        sky.edge = walk.subpath.last;
        path.vertices.push(sky);
        path.vertices.extend(vertices.iter().rev().copied());
        path.vertices.push(walk.lens);
        path.emitter = tables.info.environment;
        path.to_light = direction;
        let survived = survival(vertices.len() + 1);
        finish(tracer, path, walk.film, 0, survived, bsdf, add);
    }
}

/// Passes on all paths of a candidate that may carry light with their weights; `sensor` and `light` are the numbers of its walks.
pub fn paths<T: Traverse, S: Sampler>(
    tracer: &Tracer<'_, T>,
    blurring: Blurring,
    sensor: &mut S,
    light: &mut S,
    mut add: impl FnMut(&ChainPath, f32),
) {
    let tables = &tracer.view.tables;
    let mut bsdf = Bsdf::BLACK;
    let mut path = ChainPath::empty();
    path.blurring = blurring;
    let from_sensor = sensor_walk(tracer, &mut bsdf, sensor);
    let u_select = light.next_1d();
    let (u_position, u_direction) = (light.next_2d(), light.next_2d());
    let start = emission::sample(tables, u_select, u_position, u_direction);
    let from_light = if start.is_some() {
        let labels = tracer.from_emitter(start.emitter);
        walk(tracer, &start.ray, false, labels, &mut bsdf, light)
    } else {
        Subpath {
            vertices: ArrayVec::new(),
            escaped: None,
            last: from_sensor.subpath.last,
        }
    };
    hits(tracer, &from_sensor, &mut path, &mut bsdf, &mut add);
    let (film, lens) = (from_sensor.film, from_sensor.lens);
    let mut finish_connected = |path: &mut ChainPath, s, survived| {
        finish(tracer, path, film, s, survived, &mut bsdf, &mut add);
    };
    // t counts the lens.
    for t in 1..=from_sensor.subpath.vertices.len() + 1 {
        let of_camera = &from_sensor.subpath.vertices[..t - 1];
        let end = of_camera.last();
        for s in 1..=from_light.vertices.len() + 1 {
            if s + t > MAX_VERTICES || s + t > tracer.rules.max_depth as usize + 1 {
                break;
            }
            if s == 1 && t > 1 {
                // Its numbers are drawn whether it is of use or not.
                let (u_select, u) = (light.next_1d(), light.next_2d());
                if let Some(end) = end
                    && begin_direct(tracer, &mut path, &end.point, u_select, u)
                {
                    path.vertices.extend(of_camera.iter().rev().copied());
                    path.vertices.push(lens);
                    path.vertices[1].event = SMOOTH;
                    if join(tracer, &mut path, 0) {
                        let survived = survival(t - 1);
                        for_ends(tracer, &mut path, 1, |path| {
                            finish_connected(path, 1, survived)
                        });
                        continue;
                    }
                }
                path.vertices.clear();
                finish_connected(&mut path, 0, 1.0);
                continue;
            }
            if !start.is_some() || s + t == 2 && !may_be_seen(tables, start.emitter) {
                continue;
            }
            path.vertices.clear();
            begin_emission(tracer, &mut path, &start);
            for vertex in &from_light.vertices[..s - 1] {
                append_from_light(&mut path, *vertex);
            }
            path.vertices.extend(of_camera.iter().rev().copied());
            path.vertices.push(lens);
            // Whatever the walks sampled there.
            path.vertices[s - 1].event = SMOOTH;
            path.vertices[s].event = SMOOTH;
            if join(tracer, &mut path, s - 1) {
                let survived = survival(s - 1) * survival(t - 1);
                for_ends(tracer, &mut path, s, |path| {
                    finish_connected(path, s, survived)
                });
            } else {
                path.vertices.clear();
                finish_connected(&mut path, 0, 1.0);
            }
        }
    }
    for _ in 1..HITTING_WALKS {
        let further = sensor_walk(tracer, &mut bsdf, sensor);
        hits(tracer, &further, &mut path, &mut bsdf, &mut add);
    }
}

/// Whether a light has points that are connected to the lens.
pub fn may_be_seen(tables: &Tables<'_>, emitter: u32) -> bool {
    tables.emitters[emitter as usize].kind == emitter_kind::AREA
}

/// Film position of a number pair, within the window.
pub fn window_position(offset: [u32; 2], size: [u32; 2], u: Vec2) -> Vec2 {
    let [x, y] = [0, 1].map(|i| {
        let end = offset[i] as f32 + size[i] as f32;
        // The sum may round to the upper end, which is outside.
        (offset[i] as f32 + u[i] * size[i] as f32).min(end - end * f32::EPSILON)
    });
    Vec2::new(x, y)
}

/// Adds a vertex that a light walk reached; the edge that led there belongs to the vertex before, and its direction to the sensor.
pub fn append_from_light(path: &mut ChainPath, vertex: Vertex) {
    if let Some(before) = path.vertices.last_mut() {
        before.edge = Edge {
            direction: -vertex.edge.direction,
            ..vertex.edge
        };
    }
    path.vertices.push(Vertex {
        edge: Edge::CLEAR,
        ..vertex
    });
}

/// Begins a path with the start of a light walk.
pub fn begin_emission<T: Traverse>(
    tracer: &Tracer<'_, T>,
    path: &mut ChainPath,
    start: &EmissionSample,
) {
    path.emitter = start.emitter;
    path.to_light = -start.ray.direction;
    let tables = &tracer.view.tables;
    path.vertices.push(if may_be_seen(tables, start.emitter) {
        Vertex::new(tables, &start.point)
    } else {
        Vertex::without_surface(tables, start.point.position)
    });
}

/// Begins a path with a point of an emitter chosen for a surface; returns whether there is one.
pub fn begin_direct<T: Traverse>(
    tracer: &Tracer<'_, T>,
    path: &mut ChainPath,
    lit: &SurfacePoint,
    u_select: f32,
    u: Vec2,
) -> bool {
    let tables = &tracer.view.tables;
    path.vertices.clear();
    let (light, point) = sample_direct_with_point(tables, lit.position, u_select, u);
    if !light.is_some() {
        return false;
    }
    path.emitter = light.emitter;
    path.to_light = light.direction;
    path.vertices.push(if may_be_seen(tables, light.emitter) {
        Vertex::new(tables, &point)
    } else if light.distance < f32::MAX {
        Vertex::without_surface(tables, light.target)
    } else {
        Vertex::without_surface(tables, Vec3::ZERO)
    });
    true
}

/// Tests the edge from vertex `i` to the next, and notes what lies there; returns whether light passes.
pub fn join<T: Traverse>(tracer: &Tracer<'_, T>, path: &mut ChainPath, i: usize) -> bool {
    let tables = &tracer.view.tables;
    let k = path.edges();
    let (from, to) = (path.vertices[i], path.vertices[i + 1]);
    if i > 0 && !from.is_smooth() || i + 1 < k && !to.is_smooth() {
        return false;
    }
    let to_sensor = i + 1 == k;
    let segment = if to_sensor {
        let seen = camera::film_position(tables, from.point.position, path.u_lens);
        if !seen.is_valid {
            return false;
        }
        let mut ray = from.point.spawn(seen.direction);
        ray.t_max = seen.unclipped.min(seen.distance * (1.0 - 1e-5));
        ray
    } else if i == 0 && path.is_infinite(tables) {
        to.point.spawn(path.to_light)
    } else if i == 0 && tables.emitters[path.emitter as usize].kind != emitter_kind::AREA {
        to.point.segment_to(from.point.position)
    } else {
        to.point.segment_to_surface(&from.point)
    };
    match tracer.segment(&segment, to_sensor) {
        Some(edge) => {
            path.vertices[i].edge = edge;
            true
        }
        None => false,
    }
}
