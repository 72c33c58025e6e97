//! What the perturbations of full paths share: the laws of their steps, and discrete events that are taken again (Veach 1997, section
//! 11.4.2 to 11.4.4).
//!
//! The film position moves by r = r2 exp(-ln(r2 / r1) u) pixels in an even direction, r1 = 0.1, r2 = sqrt(0.05 W H / pi), a direction by
//! an angle of the same law; both densities are the same in both directions,
//!
//! ```text
//! p = 1 / (2 pi ln(r2 / r1) r^2),    p_w = 1 / (2 pi ln(t2 / t1) t sin t).
//! ```
//!
//! The measure of T is that in which the vertices were moved, so f is taken in it too, with the vertex kept at the other end by its
//! area. Discrete events are taken as they are and not sampled: they are no part of T. Labels of edits
//! ([`crate::path::full_path::edited`]) stay as they are.

use super::ChainPath;
use crate::bsdf::{Bsdf, mode};
use crate::math::{Frame, Ray, float};
use crate::path::full_path::vertex::Vertex;
use crate::path::specular::discrete_direction;
use crate::path::tracer::Tracer;
use crate::scene::Traverse;
use core::f32::consts::PI;
use glam::{Vec2, Vec3};

/// r1 of the header, in pixels.
const SMALLEST_STEP: f32 = 0.1;

/// r2 of the header is that of a disk of this share of the film.
const LARGEST_SHARE: f32 = 0.05;

/// Whether discrete events between the vertices `from` and `to` can be taken again.
pub(super) fn events_are_unique(x: &ChainPath, from: usize, to: usize) -> bool {
    (from.max(1)..to.min(x.edges())).all(|i| x.vertices[i].is_smooth() || x.vertices[i].is_unique)
}

/// A length between two by the law of the header.
#[inline]
pub(super) fn length([low, high]: [f32; 2], u: f32) -> f32 {
    high * float::exp(-float::ln(high / low) * u)
}

/// A direction turned by an angle between two.
pub(super) fn turned(direction: Vec3, angles: [f32; 2], u: Vec2) -> Vec3 {
    let (sin, cos) = float::sin_cos(length(angles, u.x));
    let (sin_phi, cos_phi) = float::sin_cos(2.0 * PI * u.y);
    Frame::from_normal(direction)
        .to_world(Vec3::new(sin * cos_phi, sin * sin_phi, cos))
        .normalize()
}

/// Steps of the film position in pixels.
pub(super) fn film_steps(size: [u32; 2]) -> [f32; 2] {
    let area = size[0] as f32 * size[1] as f32;
    let high = float::sqrt(LARGEST_SHARE * area / PI);
    [SMALLEST_STEP, if high > 0.2 { high } else { 0.2 }]
}

/// The ray with which a walk along a flow of [`crate::path::retarget::flow`] leaves a vertex by a discrete event, if there is one of its kind, with the turns
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

/// Angle between unit directions, precise where it is small.
pub(super) fn angle_between(a: Vec3, b: Vec3) -> f32 {
    float::atan2(a.cross(b).length(), a.dot(b))
}

/// The quotient of what `y` and `x` carry, zero where that says nothing.
#[inline]
pub(super) fn ratio(y: f32, x: f32) -> f32 {
    let ratio = y / x;
    if ratio > 0.0 { ratio } else { 0.0 }
}
