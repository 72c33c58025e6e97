//! Discrete directions, blurred: what a specular surface would scatter into a direction beside its own.
//!
//! The delta distribution of a discrete event towards o is replaced by a kernel of unit mass around o, on the cap of directions
//! that meets a disk of radius r at the far end of the connection (Kaplanyan 2017, section 6.2.2 and algorithm 2):
//!
//! ```text
//! f |cos| = sum_events F_e phi_eps(o_e, w),   eps = atan(r / l),
//! ```
//!
//! with F_e the factor by which a walk's throughput would change. It stands for [`super::Evaluation::value`], per solid angle;
//! what the material scatters beside its discrete events is not in it.
//!
//! The connections of bidirectional algorithms blur a vertex of those paths alone that nothing samples, and each of them at one
//! of its edges ([`super::specular_chain`]): with weight one, because no other strategy makes it.

use super::connection::Connector;
use super::contribution::Contribution;
use super::discrete_event::discrete_of_lobe;
use super::evaluation::Interaction;
use super::lens::to_lens_segment;
use super::rules::PathRules;
use super::specular_chain::{SpecularChain, is_chosen, state};
use super::vertex::LightEnd;
use super::walk::Walk;
use crate::bsdf::{event, lobe, mode};
use crate::math::{Rgb, float};
use crate::regularize::cone;
use crate::scene::emitter::emission::{EmissionSample, is_delta};
use crate::scene::emitter::{self, DirectSample};
use crate::scene::{NONE, Tables, camera};
use glam::{Vec2, Vec3};

/// A kernel on the cap that a disk fills at the far end of a connection.
#[derive(Clone, Copy, Debug)]
pub struct Blur {
    /// One of the kernels of [`crate::regularize::mollifier`].
    pub kernel: u32,
    /// 1 - cos of the cap's half angle.
    pub one_minus_cos: f32,
}

impl Blur {
    /// With radius `radius` at `distance`.
    #[inline]
    pub fn new(kernel: u32, radius: f32, distance: f32) -> Blur {
        Blur {
            kernel,
            one_minus_cos: cone::one_minus_cos_of_radius(radius, distance),
        }
    }
}

/// What the discrete events at a vertex scatter towards the unit world `direction`, blurred; null events pass straight on and
/// are none of them. `transport_mode` is one of [`mode`].
pub fn mollified(
    at: &Interaction<'_>,
    tables: &Tables<'_>,
    rules: &PathRules,
    transport_mode: u32,
    direction: Vec3,
    blur: Blur,
) -> Rgb {
    let point = at.point;
    let mut sum = Vec3::ZERO;
    let wo = point.frame.to_local(direction);
    if !rules.allows(point, direction, wo.z) {
        return sum;
    }
    for i in 0..at.bsdf.lobe_count() {
        for side in 0..2 {
            let kind = if side == 0 {
                event::REFLECTION
            } else {
                event::TRANSMISSION
            };
            let found = discrete_of_lobe(at.bsdf, tables, at.wi, i, kind);
            // The cap may reach behind the surface, where nothing of this event goes.
            if !(found.pdf > 0.0) || !(found.wo.z * wo.z > 0.0) {
                continue;
            }
            let axis = found.wo.normalize();
            let density = cone::eval(blur.kernel, axis, wo, blur.one_minus_cos);
            if !(density > 0.0) {
                continue;
            }
            let mut value = found.value * density;
            if transport_mode == mode::IMPORTANCE {
                let world = point.frame.to_world(axis);
                let ratio = lobe::exchange_ratio(at.bsdf.lobe_at(i), tables.data, at.wi, found.wo);
                value *= ratio * at.adjoint_ratio(world) * found.eta * found.eta;
            }
            sum += value;
        }
    }
    sum
}

impl Connector<'_> {
    /// Whether discrete events at the vertex are blurred for connections.
    #[inline]
    pub fn mollifies(&self, at: &Interaction<'_>) -> bool {
        self.regularization.radius > 0.0 && at.bsdf.has_delta()
    }

    /// The start of a light walk as a sample of light at `position`, where it is one that no ray meets.
    pub fn start_of(&self, start: &EmissionSample, position: Vec3) -> DirectSample {
        if start.emitter == NONE {
            return DirectSample::NONE;
        }
        let record = &self.tables.emitters[start.emitter as usize];
        if !is_delta(record.kind) {
            return DirectSample::NONE;
        }
        let mut light = emitter::sample_emitter(self.tables, start.emitter, position, Vec2::ZERO);
        light.pdf *= record.selection_pdf;
        light
    }

    #[inline]
    fn blur(&self, distance: f32) -> Blur {
        Blur::new(
            self.regularization.kernel,
            self.regularization.radius,
            distance,
        )
    }

    /// Next event estimation with the discrete events of the camera walk's vertex blurred (s = 1), for a sampled point or
    /// direction `light` that no ray meets.
    pub fn mollified_next_event(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        light: &DirectSample,
    ) -> Contribution {
        let t = walk.subpath.depth + 2;
        if !light.is_some() || light.is_delta == 0 || !self.allows_edges(t) {
            return Contribution::NONE;
        }
        let distance = if light.distance < f32::MAX {
            light.distance
        } else {
            self.tables.info.radius
        };
        let edge = distance * distance;
        let end = SpecularChain::start(state::IS_ROUGH, 0.0);
        if !is_chosen(&end, &walk.arrived_chain.ending(true), edge) || !self.strategies.shows(1, t)
        {
            return Contribution::NONE;
        }
        let (tables, rules) = (self.tables, &self.rules);
        let blur = self.blur(distance);
        let value = mollified(at, tables, rules, mode::RADIANCE, light.direction, blur);
        Contribution {
            value: walk.subpath.throughput * value * light.radiance * (1.0 / light.pdf),
            ray: if light.distance < f32::MAX {
                at.point.segment_to(light.target)
            } else {
                at.point.spawn(light.direction)
            },
            film: Vec2::ZERO,
            s: 1,
            t,
            emitter: light.emitter,
            blur: self.regularization.radius,
        }
    }

    /// The connection of a vertex of a light walk to the current vertex of a camera walk with one of them, the specular one,
    /// blurred.
    pub fn mollified_inner(
        &self,
        light: &LightEnd<'_>,
        walk: &Walk,
        at: &Interaction<'_>,
    ) -> Contribution {
        let (s, t) = (light.edges + 1, walk.subpath.depth + 2);
        let between = light.at.point.position - at.point.position;
        let edge = between.length_squared();
        if !self.allows_edges(s + t - 1) || !self.strategies.shows(s, t) || !(edge > 0.0) {
            return Contribution::NONE;
        }
        let distance = float::sqrt(edge);
        let direction = between / distance;
        let (tables, rules, blur) = (self.tables, &self.rules, self.blur(distance));
        let mut value = Vec3::ZERO;
        for is_light_specular in [false, true] {
            let blurred = if is_light_specular { &light.at } else { at };
            let sent = light.chain.ending(is_light_specular);
            let seen = walk.arrived_chain.ending(!is_light_specular);
            if !blurred.bsdf.has_delta() || !is_chosen(&sent, &seen, edge) {
                continue;
            }
            let there = if is_light_specular {
                at.evaluate(tables, rules, mode::RADIANCE, direction)
            } else {
                light
                    .at
                    .evaluate(tables, rules, mode::IMPORTANCE, -direction)
            };
            if !there.is_some() {
                continue;
            }
            let here = if is_light_specular {
                mollified(&light.at, tables, rules, mode::IMPORTANCE, -direction, blur)
            } else {
                mollified(at, tables, rules, mode::RADIANCE, direction, blur)
            };
            value += there.value * here;
        }
        Contribution {
            value: walk.subpath.throughput * light.throughput * value * (1.0 / edge),
            ray: at.point.segment_to_surface(light.at.point),
            film: Vec2::ZERO,
            s,
            t,
            emitter: NONE,
            blur: self.regularization.radius,
        }
    }

    /// The connection from the vertex of a light walk, its discrete events blurred, to the lens point sampled with `u_lens`
    /// (t = 1).
    pub fn mollified_to_lens(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        u_lens: Vec2,
    ) -> Contribution {
        let s = walk.subpath.depth + 2;
        let is_hidden = self.rules.hide_emitters != 0 && at.point.emitter != NONE;
        if !self.allows_edges(s) || is_hidden || !self.strategies.shows(s, 1) {
            return Contribution::NONE;
        }
        let (tables, rules) = (self.tables, &self.rules);
        let seen = camera::film_position(tables, at.point.position, u_lens);
        let edge = seen.distance * seen.distance;
        let is_pinned = !(self.strategies.pdf_lens(tables, rules) > 0.0);
        let end = SpecularChain::start(state::IS_ROUGH, 0.0);
        let sent = walk.arrived_chain.ending(true);
        if !seen.is_valid || !is_pinned || !is_chosen(&sent, &end, edge) {
            return Contribution::NONE;
        }
        let blur = self.blur(seen.distance);
        let value = mollified(at, tables, rules, mode::IMPORTANCE, seen.direction, blur);
        let density = seen.importance * camera::pixels_per_window_pixel(&tables.camera);
        Contribution {
            value: walk.subpath.throughput * value * (density * seen.response),
            ray: to_lens_segment(at.point, &seen),
            film: seen.film,
            s,
            t: 1,
            emitter: NONE,
            blur: self.regularization.radius,
        }
    }
}
