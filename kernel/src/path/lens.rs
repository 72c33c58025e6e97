//! The strategies with at most one camera vertex (t = 1 and t = 0): connections of light walks to the lens, and walks that hit
//! it.
//!
//! Their values estimate the mean radiance of a pixel from one light walk per pixel of the crop window; the reconstruction
//! filter is applied by the film. W_e is the importance of the camera ([`crate::scene::camera`]), so that a vertex x of a light
//! walk with throughput beta adds beta f W_e G(x, lens) / p(lens point) to the pixel that sees it.

use super::connection::Connector;
use super::contribution::Contribution;
use super::evaluation::Interaction;
use super::walk::Walk;
use super::weight::PartialWeights;
use crate::bsdf::mode;
use crate::math::{Ray, Rgb, float};
use crate::scene::emitter::area_radiance;
use crate::scene::emitter::emission::{self, EmissionSample};
use crate::scene::{NONE, SurfacePoint, camera, emitter_kind};
use glam::Vec2;

impl Connector<'_> {
    /// The connection from a vertex of a light walk, `edges` away from the emitter, to the lens point sampled with `u_lens`
    /// (t = 1).
    pub fn to_lens(
        &self,
        throughput: Rgb,
        weights: PartialWeights,
        edges: u32,
        at: &Interaction<'_>,
        u_lens: Vec2,
    ) -> Contribution {
        let s = edges + 1;
        let is_hidden = self.rules.hide_emitters != 0 && at.point.emitter != NONE;
        if !self.allows_edges(s) || is_hidden || !self.strategies.shows(s, 1) {
            return Contribution::NONE;
        }
        let tables = self.tables;
        let point = at.point;
        let seen = camera::film_position(tables, point.position, u_lens);
        if !seen.is_valid {
            return Contribution::NONE;
        }
        let scattered = at.evaluate(tables, &self.rules, mode::IMPORTANCE, seen.direction);
        if !scattered.is_some() {
            return Contribution::NONE;
        }
        let h = self.heuristic_at(point.position);
        let cosine = float::abs(point.geometric_normal.dot(seen.direction));
        let density = seen.importance * camera::pixels_per_window_pixel(&tables.camera);
        let light = weights.sum(h, density * cosine, scattered.pdf_reverse);
        let weight = self
            .strategies
            .weight(light, self.lens_hit_ratio(scattered.pdf, &seen));
        Contribution {
            value: throughput * scattered.value * (density * weight * seen.response),
            ray: to_lens_segment(point, &seen),
            film: seen.film,
            s,
            t: 1,
            emitter: NONE,
            blur: at.blur(),
        }
    }

    /// The connection from a point of an area light to the lens point sampled with `u_lens` (s = 1, t = 1).
    pub fn start_to_lens(&self, start: &EmissionSample, u_lens: Vec2) -> Contribution {
        let tables = self.tables;
        let is_area = start.emitter != NONE
            && tables.emitters[start.emitter as usize].kind == emitter_kind::AREA;
        let sees = self.rules.hide_emitters == 0 && self.rules.max_depth > 0;
        if !is_area || !sees || !self.strategies.shows(1, 1) {
            return Contribution::NONE;
        }
        let point = &start.point;
        let seen = camera::film_position(tables, point.position, u_lens);
        if !seen.is_valid {
            return Contribution::NONE;
        }
        let radiance = area_radiance(tables, point, seen.direction);
        if radiance.max_element() <= 0.0 {
            return Contribution::NONE;
        }
        let h = self.strategies.heuristic;
        let cosine = float::abs(point.geometric_normal.dot(seen.direction));
        let density = seen.importance * camera::pixels_per_window_pixel(&tables.camera);
        let position = start.density.position;
        let light = h.of(density * cosine / position);
        let emitted = emission::density(tables, start.emitter, point, seen.direction).direction;
        let weight = self
            .strategies
            .weight(light, self.lens_hit_ratio(emitted, &seen));
        Contribution {
            value: radiance * (cosine * density * weight / position * seen.response),
            ray: to_lens_segment(point, &seen),
            film: seen.film,
            s: 1,
            t: 1,
            emitter: NONE,
            blur: 0.0,
        }
    }

    /// h(p_0 / p_1) for the density p_0 with which a light walk of density `pdf` per solid angle hits the lens point, and the
    /// density p_1 with which that point is sampled.
    #[inline]
    fn lens_hit_ratio(&self, pdf: f32, seen: &camera::FilmPosition) -> f32 {
        let lens = self.strategies.pdf_lens(self.tables, &self.rules);
        if !(lens > 0.0) {
            return 0.0;
        }
        let cosine = float::abs(camera::optical_axis(&self.tables.camera).dot(seen.direction));
        let pdf_area = pdf * cosine / (seen.distance * seen.distance);
        self.strategies.heuristic.of(pdf_area / lens)
    }

    /// A light walk whose ray, which hits the next surface at `t_max`, passes the aperture of the lens (t = 0).
    pub fn lens_hit(&self, walk: &Walk, t_max: f32) -> Contribution {
        let tables = self.tables;
        let lens_pdf = self.strategies.pdf_lens(tables, &self.rules);
        if !(lens_pdf > 0.0) || !self.strategies.shows(walk.subpath.depth + 2, 0) {
            return Contribution::NONE;
        }
        let kind = tables.emitters[walk.emitter as usize].kind;
        if walk.subpath.depth == 0 && kind != emitter_kind::AREA
            || walk.subpath.depth >= self.rules.max_depth
        {
            return Contribution::NONE;
        }
        let ray = walk.subpath.ray;
        let met = camera::intersect_lens(&tables.camera, &ray);
        if !met.is_hit {
            return Contribution::NONE;
        }
        let seen = camera::film_position_through(tables, walk.subpath.position, met.lens);
        // Surfaces between the lens and the near clipping plane are invisible, so they do not block the walk either: the
        // contribution counts on the one segment of it that crosses the plane.
        let travelled = (ray.origin - walk.subpath.position).dot(ray.direction);
        let passes = travelled < seen.unclipped && seen.unclipped <= travelled + t_max;
        if !seen.is_valid || !passes {
            return Contribution::NONE;
        }
        let h = self.strategies.heuristic;
        let distance2 = seen.distance * seen.distance;
        let cosine = float::abs(camera::optical_axis(&tables.camera).dot(ray.direction));
        if !(cosine > 0.0) || !(distance2 > 0.0) {
            return Contribution::NONE;
        }
        let density = seen.importance * camera::pixels_per_window_pixel(&tables.camera);
        let weights = if walk.subpath.depth > 0 {
            walk.weights.arrive(h, distance2, cosine)
        } else {
            let start = walk.start_point(tables);
            let emitted = emission::density(tables, walk.emitter, &start, ray.direction);
            let light = float::abs(start.geometric_normal.dot(ray.direction));
            PartialWeights {
                d_vcm: h.of(distance2 / (emitted.direction * cosine)),
                d_vc: h.of(light / (emitted.product() * cosine)),
            }
        };
        // Per solid angle at the lens: the density of the camera walk that would come in the opposite direction.
        let light = h.of(lens_pdf) * weights.shorter(h, density * distance2);
        let weight = self.strategies.weight(light, 0.0);
        Contribution {
            value: walk.subpath.throughput * (density * distance2 * lens_pdf * weight / cosine),
            ray,
            film: seen.film,
            s: walk.subpath.depth + 2,
            t: 0,
            emitter: NONE,
            blur: 0.0,
        }
    }
}

/// The segment to the lens point, as far as the near clipping plane.
#[inline]
pub(super) fn to_lens_segment(point: &SurfacePoint, seen: &camera::FilmPosition) -> Ray {
    let mut ray = point.spawn(seen.direction);
    ray.t_max = seen.unclipped.min(seen.distance * (1.0 - 1e-5));
    ray
}
