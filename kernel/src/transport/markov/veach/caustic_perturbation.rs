//! Caustic perturbation: the direction at the vertex before the discrete events nearest the sensor turns, and what it leads to moves,
//! up to the vertex that the lens sees (Veach 1997, section 11.4.2; [`super::perturbation`]).
//!
//! Of a path with a blurred vertex it moves the end of the discrete events before that, or the blurred vertex itself if it is such
//! an end: without that nothing would move a caustic that is seen in a blurred mirror.
//!
//! Angles are those of the film steps r1 and r2 seen from the lens, times the path's length from the lens to the last vertex that moves
//! over its length from there to the vertex that turns, so that the caustic moves as far over the film; what leads out of the range
//! from y is not proposed from x. Where the largest would be more than pi / 2 it is that, and the smallest in proportion: as ln(t2 / t1)
//! is the same for all paths, it cancels in T(y -> x) / T(x -> y).

use super::ChainPath;
use super::candidate::{append_from_light, join};
use super::perturbation::{
    angle_between, events_are_unique, film_steps, ratio, repeat_event, turned,
};
use crate::bsdf::Bsdf;
use crate::math::{Ray, float};
use crate::path::full_path::vertex::Vertex;
use crate::path::retarget::flow;
use crate::path::tracer::Tracer;
use crate::sampler::Sampler;
use crate::scene::{NONE, Traverse, emitter_kind};
use core::f32::consts::PI;

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
    let steps = film_steps(camera.crop_size);
    let (scale, most) = (per_pixel * from_lens / from_start, 0.5 * PI / steps[1]);
    steps.map(|r| r * if scale < most { scale } else { most })
}
