//! Lens and multi-chain perturbation: the film position moves, and what is seen there with it (Veach 1997, sections 11.4.3 and
//! 11.4.4; [`super::perturbation`]).
//!
//! | | moves | from there on |
//! |---|---|---|
//! | lens | the film position | through discrete events to the first other vertex, which is connected to the one before it |
//! | multi-chain | the same, and the direction at each vertex that discrete events follow | until such a vertex is followed by another |
//!
//! The multi-chain perturbation turns, with even chances, either the direction that the vertex had or that from its new position to the
//! specular vertex that followed: the first leads back to the light by way of plane mirrors, the second by way of curved
//! ones, whose normal changes more with where they are met than with the direction that comes there. About the second the angle of
//! the opposite mutation differs, so T(y -> x) / T(x -> y) has t sin t of the proposal over that of its opposite.

use super::ChainPath;
use super::candidate::join;
use super::perturbation::{
    angle_between, events_are_unique, film_steps, length, ratio, repeat_event, turned,
};
use crate::bsdf::Bsdf;
use crate::math::float;
use crate::path::full_path::vertex::Vertex;
use crate::path::retarget::flow;
use crate::path::tracer::Tracer;
use crate::sampler::Sampler;
use crate::scene::emitter::emission::is_delta;
use crate::scene::{NONE, Traverse, camera};
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

/// Angles of the multi-chain perturbation, in radians.
const CHAIN_ANGLES: [f32; 2] = [1e-4 * PI / 180.0, 0.1 * PI / 180.0];

/// Those about the direction to a vertex, in radians; that direction is known to 1e-6 after a walk through glass.
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
    let mut opposite = 1.0;
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
            opposite *= there * float::sin(there) / (back * float::sin(back));
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
    ratio(opposite * target(y), target(x))
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
