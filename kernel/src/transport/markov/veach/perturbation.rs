//! Perturbations: the vertices of one end of a path move a little, through the same discrete events (Veach 1997, section 11.4.2
//! to 11.4.4).
//!
//! | | moves | from there on |
//! |---|---|---|
//! | lens | the film position | through discrete events to the first other vertex, which is connected to the one before it |
//! | multi-chain | the same, and the direction at each vertex that discrete events follow | until such a vertex is followed by another |
//! | caustic | the direction at the vertex before the discrete events nearest the sensor | through them to the vertex that the lens sees |
//!
//! Of a path with a blurred vertex the caustic perturbation moves the end of the discrete events before that, or the blurred
//! vertex itself if it is such an end: without that nothing would move a caustic that is seen in a blurred mirror.
//!
//! The film position moves by r = r2 exp(-ln(r2 / r1) u) pixels in an even direction, r1 = 0.1, r2 = sqrt(0.05 W H / pi), a direction by
//! an angle of the same law; both densities are the same in both directions,
//!
//! ```text
//! p = 1 / (2 pi ln(r2 / r1) r^2),    p_w = 1 / (2 pi ln(t2 / t1) t sin t).
//! ```
//!
//! The multi-chain perturbation turns, with even chances, either the direction that the vertex had or that from its new position to the
//! specular vertex that followed: the first leads back to the light by way of plane mirrors, the second by way of curved
//! ones, whose normal changes more with where they are met than with the direction that comes there. About the second the angle of
//! the way back differs, so T(y -> x) / T(x -> y) has t sin t of the way there over that of the way back.
//!
//! Angles of the caustic perturbation are those of r1 and r2 seen from the lens, over the way from there and to the vertex, so that
//! it moves as far over the film; what leads out of the range from y is not proposed from x. The measure of T is that in which
//! the vertices were moved, so f is taken in it too, with the vertex kept at the other end by its area. Discrete events are taken as
//! they are and not sampled: they are no part of T. Labels of edits ([`crate::path::whole_edited`]) stay as they are.

use super::ChainPath;
use super::candidate::{append_from_light, join};
use crate::bsdf::{Bsdf, mode};
use crate::math::{Frame, Ray, float};
use crate::path::retarget::flow;
use crate::path::specular::discrete_direction;
use crate::path::tracer::Tracer;
use crate::path::whole_vertex::Vertex;
use crate::sampler::Sampler;
use crate::scene::emitter::emission::is_delta;
use crate::scene::{NONE, Traverse, camera, emitter_kind};
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

/// r1 of the header, in pixels.
const SMALLEST_STEP: f32 = 0.1;

/// r2 of the header is that of a disk of this share of the film.
const LARGEST_SHARE: f32 = 0.05;

/// Angles of the multi-chain perturbation, in radians.
const CHAIN_ANGLES: [f32; 2] = [1e-4 * PI / 180.0, 0.1 * PI / 180.0];

/// Those about the direction to a vertex, in radians; that direction is known to 1e-6 after a way through glass.
const ANCHORED_ANGLES: [f32; 2] = [0.02 * PI / 180.0, 2.0 * PI / 180.0];

/// Shortest distance to such a vertex, over the largest coordinate: rounding turns the direction by a hundredth of the smallest angle.
const SHORTEST_ANCHOR: f32 = 0.02;

/// Which vertices a perturbation from the sensor moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorChain {
    /// The last vertex, counted from the light, that moves.
    pub last: usize,
    /// Vertices at which the direction is moved as well.
    pub turns: u32,
}

/// The chain of a path: through discrete events, and on from vertices that discrete events follow.
pub fn sensor_chain(x: &ChainPath) -> SensorChain {
    let k = x.edges();
    let mut turns = 0;
    let mut j = k - 1;
    while j > 0 {
        if x.vertices[j].is_smooth() {
            if j == 1 || x.vertices[j - 1].is_smooth() {
                break;
            }
            turns += 1;
        }
        j -= 1;
    }
    SensorChain { last: j, turns }
}

/// The vertices that the caustic perturbation moves: it turns the direction at `start`, and `end` is connected anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightChain {
    /// Stays where it is.
    pub start: usize,
    /// The last vertex that moves.
    pub end: usize,
}

/// Those of a path, if there are any.
pub fn light_chain<T: Traverse>(tracer: &Tracer<'_, T>, x: &ChainPath) -> Option<LightChain> {
    let k = x.edges();
    let is_smooth = |i: usize| x.vertices[i].is_smooth();
    let end = match x.blurred_vertex() {
        None => k - 1,
        Some(i) if i > 1 && is_smooth(i - 1) => i - 1,
        Some(i) => i,
    };
    let joins = is_smooth(end) && (end + 1 == k || is_smooth(end + 1));
    if end < 2 || !joins || is_smooth(end - 1) {
        return None;
    }
    let mut start = end - 1;
    while start > 0 && !is_smooth(start) {
        start -= 1;
    }
    // Light from infinity has no position to turn about.
    let is_somewhere = start > 0 || !x.is_infinite(&tracer.view.tables);
    is_somewhere.then_some(LightChain { start, end })
}

/// Whether discrete events between the vertices `from` and `to` can be taken again.
fn events_are_unique(x: &ChainPath, from: usize, to: usize) -> bool {
    (from.max(1)..to.min(x.edges())).all(|i| x.vertices[i].is_smooth() || x.vertices[i].is_unique)
}

/// A length between two by the law of the header.
#[inline]
fn length([low, high]: [f32; 2], u: f32) -> f32 {
    high * float::exp(-float::ln(high / low) * u)
}

/// A direction turned by an angle between two.
fn turned(direction: Vec3, angles: [f32; 2], u: Vec2) -> Vec3 {
    let (sin, cos) = float::sin_cos(length(angles, u.x));
    let (sin_phi, cos_phi) = float::sin_cos(2.0 * PI * u.y);
    Frame::from_normal(direction)
        .to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos))
        .normalize()
}

/// Steps of the film position in pixels.
fn film_steps(size: [u32; 2]) -> [f32; 2] {
    let area = size[0] as f32 * size[1] as f32;
    let high = float::sqrt(LARGEST_SHARE * area / PI);
    [SMALLEST_STEP, if high > 0.2 { high } else { 0.2 }]
}

/// The ray with which a walk along a flow of [`flow`] leaves a vertex by a discrete event, if there is one of its kind, with the turns
/// of the edits by which the vertex is labelled.
pub fn repeat_event<T: Traverse>(
    tracer: &Tracer<'_, T>,
    vertex: &Vertex,
    flow: u32,
    back: Vec3,
    bsdf: &mut Bsdf,
) -> Option<Ray> {
    let tables = &tracer.view.tables;
    let point = &vertex.point;
    let turning = |flow: u32| {
        let label = vertex.labels[flow as usize] as usize;
        let edits = tracer.edits.filter(|_| label > 0)?;
        Some(&edits.list[label - 1])
    };
    let back = match turning(1 - flow) {
        Some(edit) => edit.origin_at(point, back)?.direction,
        None => back,
    };
    let wi = point.frame.to_local(back);
    bsdf.look_up(tables, point, wi, mode::RADIANCE);
    let wo = discrete_direction(bsdf, tables, wi, vertex.event)?;
    let direction = point.frame.to_world(wo).normalize();
    Some(point.spawn(match turning(flow) {
        Some(edit) => edit.redirect_at(point, direction)?.direction,
        None => direction,
    }))
}

/// Lens and multi-chain perturbation: makes `y` of `x`; returns f(y) T(y -> x) / (f(x) T(x -> y)), zero for no path.
pub fn propose_from_sensor<T: Traverse, S: Sampler>(
    tracer: &Tracer<'_, T>,
    x: &ChainPath,
    y: &mut ChainPath,
    bsdf: &mut Bsdf,
    sampler: &mut S,
) -> f32 {
    let tables = &tracer.view.tables;
    let k = x.edges();
    let SensorChain { last, turns } = sensor_chain(x);
    if !events_are_unique(x, last, k) {
        return 0.0;
    }
    // Where discrete events lead all the way to a light that no ray meets, there is no way back from what they lead to.
    if last == 0 && is_delta(tables.emitters[x.emitter as usize].kind) {
        return 0.0;
    }
    let window = &tables.camera;
    let r = length(film_steps(window.crop_size), sampler.next_1d());
    let (sin, cos) = float::sin_cos(2.0 * PI * sampler.next_1d());
    let film = x.film + Vec2::new(cos, sin) * r;
    let is_anchored = turns > 0 && sampler.next_1d() < 0.5;
    let start = Vec2::new(window.crop_offset[0] as f32, window.crop_offset[1] as f32);
    let in_window = film.cmpge(start).all()
        && film.x < start.x + window.crop_size[0] as f32
        && film.y < start.y + window.crop_size[1] as f32;
    if !in_window {
        return 0.0;
    }
    y.clone_from(x);
    y.film = film;
    let mut ray = camera::ray_through(window, film, x.u_lens);
    y.vertices[k].point.position = ray.origin;
    for j in (last..k).rev() {
        let arrival = tracer.trace(&ray, j + 1 == k, sampler);
        let old = &x.vertices[j];
        if j == 0 {
            // Discrete events led all the way to a light.
            match arrival.point {
                Some(point) if point.emitter != NONE => {
                    y.vertices[0] = Vertex::new(tables, &point);
                    y.emitter = point.emitter;
                }
                None if tables.info.environment != NONE => {
                    y.vertices[0] = Vertex::without_surface(tables, Vec3::ZERO);
                    y.emitter = tables.info.environment;
                    y.to_light = ray.direction;
                }
                _ => return 0.0,
            }
        } else {
            let Some(point) = arrival.point else {
                return 0.0;
            };
            y.vertices[j] = Vertex::new(tables, &point);
            y.vertices[j].event = old.event;
            y.vertices[j].labels = old.labels;
        }
        y.vertices[j].edge = arrival.edge;
        if j == last {
            break;
        }
        if old.is_smooth() {
            let u = sampler.next_2d();
            let direction = if is_anchored {
                match towards(y, j, x) {
                    Some(anchor) => turned(anchor, ANCHORED_ANGLES, u),
                    None => return 0.0,
                }
            } else {
                turned(x.previous_direction(j), CHAIN_ANGLES, u)
            };
            ray = y.vertices[j].point.spawn(direction);
        } else {
            match repeat_event(
                tracer,
                &y.vertices[j],
                flow::IMPORTANCE,
                -ray.direction,
                bsdf,
            ) {
                Some(next) => ray = next,
                None => return 0.0,
            }
        }
    }
    if last > 0 && !join(tracer, y, last - 1) {
        return 0.0;
    }
    if !tracer.evaluate(y, bsdf) || !events_are_unique(y, last, k) {
        return 0.0;
    }
    let mut ways = 1.0;
    if is_anchored {
        for j in (last + 1..k).filter(|&j| x.vertices[j].is_smooth()) {
            let (Some(anchor), Some(anchor_back)) = (towards(y, j, x), towards(x, j, y)) else {
                return 0.0;
            };
            let there = angle_between(y.previous_direction(j), anchor);
            let back = angle_between(x.previous_direction(j), anchor_back);
            if !(back >= ANCHORED_ANGLES[0] && back <= ANCHORED_ANGLES[1]) {
                return 0.0;
            }
            ways *= there * float::sin(there) / (back * float::sin(back));
        }
    }
    let target = |path: &ChainPath| {
        let mut f = path.luminance();
        if last > 0 {
            f /= path.solid_angle_per_area(tables, last - 1);
        }
        let walked: f32 = (last..k)
            .map(|j| {
                let vertex = &path.vertices[j];
                vertex.edge.pass * if j > 0 { vertex.stop } else { 1.0 }
            })
            .product();
        f / walked
    };
    ratio(ways * target(y), target(x))
}

/// Unit direction from vertex `j` of a path to the vertex before it of another; none where rounding of the two positions would turn
/// it by as much as the smallest of the angles.
fn towards(from: &ChainPath, j: usize, to: &ChainPath) -> Option<Vec3> {
    let (from, to) = (
        from.vertices[j].point.position,
        to.vertices[j - 1].point.position,
    );
    let extent = from.abs().max(to.abs()).max_element();
    let between = to - from;
    let length = between.length();
    (length > SHORTEST_ANCHOR * extent).then(|| between / length)
}

/// Caustic perturbation: makes `y` of `x`; returns f(y) T(y -> x) / (f(x) T(x -> y)), zero for no path.
pub fn propose_from_light<T: Traverse, S: Sampler>(
    tracer: &Tracer<'_, T>,
    x: &ChainPath,
    chain: LightChain,
    y: &mut ChainPath,
    bsdf: &mut Bsdf,
    sampler: &mut S,
) -> f32 {
    let tables = &tracer.view.tables;
    let LightChain { start, end } = chain;
    if !events_are_unique(x, start + 1, end) {
        return 0.0;
    }
    let angles = caustic_angles(tracer, x, chain);
    let old = x.next_direction(start);
    let direction = turned(old, angles, sampler.next_2d());
    y.clone_from(x);
    y.vertices.truncate(start + 1);
    let mut ray = if start == 0 && tables.emitters[x.emitter as usize].kind != emitter_kind::AREA {
        Ray::new(x.vertices[0].point.position, direction)
    } else {
        x.vertices[start].point.spawn(direction)
    };
    for j in start + 1..=end {
        let arrival = tracer.trace(&ray, false, sampler);
        let Some(point) = arrival.point else {
            return 0.0;
        };
        let mut vertex = Vertex::new(tables, &point);
        vertex.event = x.vertices[j].event;
        vertex.labels = x.vertices[j].labels;
        vertex.edge = arrival.edge;
        if j < end {
            match repeat_event(tracer, &vertex, flow::LIGHT, -ray.direction, bsdf) {
                Some(next) => ray = next,
                None => return 0.0,
            }
        }
        append_from_light(y, vertex);
    }
    y.vertices.extend(x.vertices[end + 1..].iter().copied());
    if !join(tracer, y, end) || !tracer.evaluate(y, bsdf) || !events_are_unique(y, start + 1, end) {
        return 0.0;
    }
    // Not proposed in the opposite direction if the angle is none of y's.
    let angle = angle_between(old, direction);
    let back = caustic_angles(tracer, y, chain);
    if !(angle >= back[0] && angle <= back[1]) {
        return 0.0;
    }
    let target = |path: &ChainPath| {
        let mut ratios = 1.0;
        let mut walked = 1.0;
        for j in start..end {
            walked *= path.vertices[j].edge.pass * path.vertices[j + 1].stop;
            if j > start {
                ratios *= path.light_ratio(j);
            }
        }
        let normal = path.vertices[end].point.geometric_normal;
        let arriving = float::abs(normal.dot(path.previous_direction(end)));
        let leaving = if start == 0 && path.vertices[0].point.emitter == NONE {
            1.0
        } else {
            let normal = path.vertices[start].point.geometric_normal;
            float::abs(normal.dot(path.next_direction(start)))
        };
        let turns = ratios * arriving / leaving;
        path.luminance() / (path.solid_angle_per_area(tables, end) * turns * walked)
    };
    ratio(target(y), target(x))
}

/// Angle between unit directions, precise where it is small.
fn angle_between(a: Vec3, b: Vec3) -> f32 {
    float::atan2(a.cross(b).length(), a.dot(b))
}

/// Angles of the caustic perturbation.
fn caustic_angles<T: Traverse>(
    tracer: &Tracer<'_, T>,
    path: &ChainPath,
    LightChain { start, end }: LightChain,
) -> [f32; 2] {
    let camera = &tracer.view.tables.camera;
    let k = path.edges();
    let distance =
        |i: usize| (path.vertices[i + 1].point.position - path.vertices[i].point.position).length();
    let from_lens: f32 = (end..k).map(distance).sum();
    let from_start: f32 = (start..end).map(distance).sum();
    let per_pixel = 2.0 * camera.tan_half_width / camera.film_size[0] as f32;
    let scale = per_pixel * from_lens / from_start;
    film_steps(camera.crop_size).map(|r| {
        let angle = r * scale;
        if angle < 0.5 * PI { angle } else { 0.5 * PI }
    })
}

/// The quotient of what `y` and `x` carry, zero where that says nothing.
#[inline]
fn ratio(y: f32, x: f32) -> f32 {
    let ratio = y / x;
    if ratio > 0.0 { ratio } else { 0.0 }
}
