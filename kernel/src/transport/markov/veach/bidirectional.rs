//! The bidirectional mutation (Veach 1997, section 11.4.1).
//!
//! A path x of k edges gets k' edges: the vertices l + 1 ... m - 1 are deleted, l >= -1 and m <= k, and k' - k + m - l - 1 others take
//! their place, some by a walk on from x_l (or from a light, l = -1), the rest by one on from x_m (from the lens with a new film
//! position, m = k). With two-tailed geometric distributions g(i; c) ~ 2^-|i - c| over the allowed values,
//!
//! ```text
//! P(k') = g(k'; k),  P(m - l) = g(m - l; 2),  P(l) = 1 / (k - (m - l) + 2),  P(split) = 1 / (vertices that are added + 1).
//! ```
//!
//! The density of y sums over all splits; what was kept has the same density on both sides, so the densities of full paths
//! ([`crate::path::full_path::Path::strategy_pdf`]) replace it:
//!
//! ```text
//! T(x -> y) / I(y) = P(k') P(m - l) P(l) P(split) sum_s p_s(y) / I(y).
//! ```
//!
//! With a target that is mollified, a connection may blur one of its ends: which, is chosen among those that its materials allow,
//! with the same probability each, so p_s is divided by their number. With edits the same goes for the labels that the ends of the
//! connection can have, and walks draw the others ([`crate::path::full_path::edited`]); what was kept keeps its labels too.

use super::ChainPath;
use super::candidate::{
    append_from_light, begin_direct, begin_emission, join, may_be_seen, window_position,
};
use super::ends::{ConnectionEnds, end_labels, set_end_labels};
use crate::bsdf::Bsdf;
use crate::path::full_path::vertex::{BLURRED, SMOOTH, Vertex};
use crate::path::retarget::flow;
use crate::path::tracer::Tracer;
use crate::sampler::Sampler;
use crate::scene::emitter::emission;
use crate::scene::{NONE, Traverse, camera, emitter_kind};
use arrayvec::ArrayVec;
use glam::Vec3;

/// The deleted part of a path, and what replaces it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// Vertices that are kept at the light: l + 1.
    pub light: usize,
    /// Edges from x_l to x_m, that before the light included.
    pub deleted: usize,
    /// Edges that replace them.
    pub added: usize,
}

/// Two-tailed geometric distribution around `center` over `low` to `high`.
fn geometric(i: usize, center: usize, low: usize, high: usize) -> f32 {
    // 2^-|i - c|, for far fewer vertices than the exponent can hold.
    let weight = |i: usize| f32::from_bits((127 - i.abs_diff(center).min(126) as u32) << 23);
    if i < low || i > high {
        return 0.0;
    }
    let sum: f32 = (low..=high).map(weight).sum();
    weight(i) / sum
}

fn choose(u: f32, center: usize, low: usize, high: usize) -> usize {
    let mut below = 0.0;
    for i in low..high {
        below += geometric(i, center, low, high);
        if u < below {
            return i;
        }
    }
    high
}

/// Fewest edges of the deleted part: one that is replaced by one of the same length leaves the path as it is.
fn least_deleted(k: usize, new: usize) -> usize {
    if new == k {
        2
    } else {
        1.max((k + 1).saturating_sub(new))
    }
}

impl Change {
    /// A change of a path of `k` edges, between the fewest and most edges of all paths.
    pub fn choose<S: Sampler>(k: usize, [low, high]: [usize; 2], sampler: &mut S) -> Change {
        let new = choose(sampler.next_1d(), k, low, high);
        let deleted = choose(sampler.next_1d(), 2, least_deleted(k, new), k + 1);
        let positions = k + 2 - deleted;
        let light = (sampler.next_1d() * positions as f32) as usize;
        Change {
            light: light.min(positions - 1),
            deleted,
            added: deleted + new - k,
        }
    }

    /// Probability of the choice, splits included.
    pub fn probability(&self, k: usize, [low, high]: [usize; 2]) -> f32 {
        let new = k + self.added - self.deleted;
        let positions = k + 2 - self.deleted;
        geometric(new, k, low, high) * geometric(self.deleted, 2, least_deleted(k, new), k + 1)
            / (positions as f32 * self.added as f32)
    }

    /// The change that leads back.
    pub fn reverse(&self) -> Change {
        Change {
            deleted: self.added,
            added: self.deleted,
            ..*self
        }
    }

    /// T(x -> y) / I(y) for a path y that the change may have led to from one of `k` edges.
    pub fn density<T: Traverse>(
        &self,
        tracer: &Tracer<'_, T>,
        y: &ChainPath,
        k: usize,
        limits: [usize; 2],
    ) -> f32 {
        let tables = &tracer.view.tables;
        let sum: f32 = (0..self.added)
            .map(|i| {
                let s = self.light + i;
                let pdf = y.strategy_pdf(tables, s, self.light > 0);
                if s == 0 || !(pdf > 0.0) {
                    return pdf;
                }
                let labels = end_labels(tracer, y, s).len() as f32;
                pdf / (ConnectionEnds::of(tables, y, s).count() as f32 * labels)
            })
            .sum();
        self.probability(k, limits) * sum / y.luminance()
    }
}

/// Makes `y` of `x` by a change; returns whether it carries light.
pub fn propose<T: Traverse, S: Sampler>(
    tracer: &Tracer<'_, T>,
    x: &ChainPath,
    change: &Change,
    y: &mut ChainPath,
    bsdf: &mut Bsdf,
    sampler: &mut S,
) -> bool {
    let tables = &tracer.view.tables;
    let k = x.edges();
    let m = change.light + change.deleted - 1;
    let added = change.added - 1;
    let from_light = ((sampler.next_1d() * change.added as f32) as usize).min(added);
    let from_sensor = added - from_light;
    y.emitter = x.emitter;
    y.to_light = x.to_light;
    y.u_lens = x.u_lens;
    y.blurring = x.blurring;
    // The sensor's part, from the lens on.
    let mut sensor: ArrayVec<Vertex, { super::MAX_VERTICES }> = ArrayVec::new();
    sensor.extend(x.vertices[m..].iter().rev().copied());
    if m == 0 {
        // A light that becomes a surface on the way from another.
        if tables.emitters[x.emitter as usize].kind != emitter_kind::AREA {
            return false;
        }
        if let Some(end) = sensor.last_mut() {
            end.complete(tables);
        }
    }
    // What the walk from there on has read.
    let mut labels = match tracer.edits {
        Some(edits) if m < k && (m == 0 || from_sensor > 0) => {
            let walk = x.walk_to(tables, edits, flow::IMPORTANCE, m, bsdf);
            if walk.is_none() {
                return false;
            }
            walk
        }
        _ => tracer.from_sensor(),
    };
    if m == 0 {
        let back = x.next_direction(0);
        let Some(end) = sensor.last_mut() else {
            return false;
        };
        if !tracer.guess(labels.as_ref(), end, back, bsdf, sampler) {
            return false;
        }
    }
    let mut ray;
    if m == k {
        y.u_lens = sampler.next_2d();
        let window = &tables.camera;
        let film = window_position(window.crop_offset, window.crop_size, sampler.next_2d());
        y.film = film;
        ray = camera::ray_through(window, film, y.u_lens);
        sensor[0].point.position = ray.origin;
    } else if from_sensor > 0 {
        let back = x.next_direction(m);
        let Some(end) = sensor.last_mut() else {
            return false;
        };
        match tracer.scatter(&mut labels, end, back, bsdf, sampler) {
            Some(next) => ray = next,
            None => return false,
        }
    } else {
        ray = crate::math::Ray::new(Vec3::ZERO, Vec3::Z);
        if let Some(end) = sensor.last_mut() {
            end.event = SMOOTH;
        }
    }
    let mut escaped = None;
    for i in 0..from_sensor {
        let arrival = tracer.trace(&ray, sensor.len() == 1, sampler);
        let is_light = change.light == 0 && from_light == 0 && i + 1 == from_sensor;
        let mut vertex = match arrival.point {
            Some(point) if !is_light || point.emitter != NONE => Vertex::new(tables, &point),
            None if is_light && tables.info.environment != NONE => {
                escaped = Some(ray.direction);
                Vertex::without_surface(tables, Vec3::ZERO)
            }
            _ => return false,
        };
        vertex.edge = arrival.edge;
        let back = -ray.direction;
        if !is_light && !tracer.guess(labels.as_ref(), &mut vertex, back, bsdf, sampler) {
            return false;
        }
        if i + 1 < from_sensor {
            match tracer.scatter(&mut labels, &mut vertex, back, bsdf, sampler) {
                Some(next) => ray = next,
                None => return false,
            }
        }
        sensor.push(vertex);
    }
    // The light's part.
    y.vertices.clear();
    y.vertices
        .extend(x.vertices[..change.light].iter().copied());
    let is_emission_met = change.light == 0 && from_light == 0;
    let mut lit = 0;
    if is_emission_met {
        let Some(light) = sensor.last() else {
            return false;
        };
        match escaped {
            Some(direction) => {
                y.emitter = tables.info.environment;
                y.to_light = direction;
            }
            None => y.emitter = light.point.emitter,
        }
    } else {
        lit = change.light + from_light;
        let mut walked = from_light;
        let mut labels = None;
        if change.light == 0 {
            // The point before the connection, unless that is the lens.
            let is_direct = from_light == 1 && sensor.len() > 1;
            let (u_select, u) = (sampler.next_1d(), sampler.next_2d());
            if is_direct {
                let Some(end) = sensor.last() else {
                    return false;
                };
                let point = end.point;
                if !begin_direct(tracer, y, &point, u_select, u) {
                    return false;
                }
            } else {
                let start = emission::sample(tables, u_select, u, sampler.next_2d());
                if !start.is_some() {
                    return false;
                }
                begin_emission(tracer, y, &start);
                labels = tracer.from_emitter(start.emitter);
                ray = start.ray;
            }
            walked -= 1;
        } else if from_light > 0 {
            // On from the last vertex that is kept.
            let last = change.light - 1;
            if let Some(edits) = tracer.edits {
                labels = x.walk_to(tables, edits, flow::LIGHT, last, bsdf);
                if labels.is_none() {
                    return false;
                }
            }
            if last == 0 {
                ray = emit_from(tracer, y, sampler);
            } else {
                let back = x.previous_direction(last);
                match tracer.scatter(&mut labels, &mut y.vertices[last], back, bsdf, sampler) {
                    Some(next) => ray = next,
                    None => return false,
                }
            }
        } else {
            let last = change.light - 1;
            y.vertices[last].event = SMOOTH;
        }
        for i in 0..walked {
            let arrival = tracer.trace(&ray, false, sampler);
            let Some(point) = arrival.point else {
                return false;
            };
            let mut vertex = Vertex::new(tables, &point);
            vertex.edge = arrival.edge;
            let back = -ray.direction;
            if !tracer.guess(labels.as_ref(), &mut vertex, back, bsdf, sampler) {
                return false;
            }
            if i + 1 < walked {
                match tracer.scatter(&mut labels, &mut vertex, back, bsdf, sampler) {
                    Some(next) => ray = next,
                    None => return false,
                }
            }
            append_from_light(y, vertex);
        }
    }
    y.vertices.extend(sensor.iter().rev().copied());
    if is_emission_met {
        y.vertices[0].event = SMOOTH;
        y.vertices[0].labels = [0; 2];
    } else if y.edges() == 1 && !may_be_seen(tables, y.emitter) || !join(tracer, y, lit - 1) {
        return false;
    } else if tracer.edits.is_some() {
        let pairs = end_labels(tracer, y, lit);
        let index = match pairs.len() {
            1 => 0,
            count => ((sampler.next_1d() * count as f32) as usize).min(count - 1),
        };
        set_end_labels(y, lit, pairs[index]);
    } else if y.blurring.radius > 0.0 {
        let ends = ConnectionEnds::of(tables, y, lit);
        let index = match ends.count() {
            0 => return false,
            1 => 0,
            count => ((sampler.next_1d() * count as f32) as u32).min(count - 1),
        };
        if let Some(i) = ends.choose(lit, index) {
            y.vertices[i].event = BLURRED;
        }
    }
    tracer.evaluate(y, bsdf) && y.may_join(lit)
}

/// A ray on from the start of a light walk whose position, or whose direction if it is at infinity, is kept.
fn emit_from<T: Traverse, S: Sampler>(
    tracer: &Tracer<'_, T>,
    path: &mut ChainPath,
    sampler: &mut S,
) -> crate::math::Ray {
    let tables = &tracer.view.tables;
    let (u_position, u_direction) = (sampler.next_2d(), sampler.next_2d());
    let ray = emission::resume(
        tables,
        path.emitter,
        &path.vertices[0].point,
        -path.to_light,
        u_position,
        u_direction,
    );
    path.to_light = -ray.direction;
    ray
}
