//! The strategies (s, t) that complete a path: the weighted contribution of each, and the segment whose visibility decides
//! about it.
//!
//! | s, t | completes a path by |
//! |---|---|
//! | 0, t | emission of a surface that a camera walk hits, or of the environment where it leaves the scene |
//! | 1, t | next event estimation: a point of an emitter, sampled for the surface that it illuminates |
//! | s, t | the segment between a vertex of a light walk and one of a camera walk |
//! | s, 1 | the segment from a vertex of a light walk, or from a point of an area light, to a sampled point of the lens |
//! | s, 0 | a light walk that hits a lens of finite aperture |
//!
//! s and t count the vertices of the light and of the camera subpath; a path has k = s + t - 1 edges. For the weights see
//! [`super::weight`]. A path of one edge (an emitter seen directly) is sampled by s = 0 and, on area lights, by t = 1 and
//! t = 0; next event estimation is not among its strategies.
//!
//! The last two are in [`super::lens`].

use super::contribution::Contribution;
use super::evaluation::Interaction;
use super::photon_density::PhotonDensity;
use super::rules::PathRules;
use super::shading_point::ShadingPoint;
use super::strategies::Strategies;
use super::vertex::LightEnd;
use super::walk::Walk;
use super::weight::Heuristic;
use crate::bsdf::mode;
use crate::math::{Rgb, float};
use crate::regularize::settings::Regularization;
use crate::scene::emitter::emission::{self, EmissionSample, light_cosine};
use crate::scene::emitter::{
    self, DirectSample, area_radiance, environment_radiance_and_pdf, sample_direct_with_point,
};
use crate::scene::{Hit, NONE, SurfacePoint, Tables, emitter_kind};
use glam::{Vec2, Vec3};

/// What the evaluation of every connection needs.
#[derive(Clone, Copy)]
pub struct Connector<'a> {
    /// The scene.
    pub tables: &'a Tables<'a>,
    /// The rules.
    pub rules: PathRules,
    /// The strategies.
    pub strategies: Strategies,
    /// Where photons are merged: how many there are.
    pub photons: PhotonDensity<'a>,
    /// Of the sample that is taken.
    pub regularization: Regularization,
}

impl Connector<'_> {
    /// The heuristic of a vertex: merging counts as many samples as photons share a camera subpath there
    /// ([`super::photon_density`]).
    #[inline]
    pub fn heuristic_at(&self, position: Vec3) -> Heuristic {
        let mut h = self.strategies.heuristic;
        if h.merging > 0.0 {
            h.merging /= 1.0 + h.merging * self.photons.at(position);
        }
        h
    }

    /// Emission of the surface that a camera walk has hit (s = 0); nothing for light walks.
    pub fn emitted(&self, walk: &Walk, point: &SurfacePoint) -> Rgb {
        let tables = self.tables;
        if walk.mode != mode::RADIANCE || point.emitter == NONE {
            return Vec3::ZERO;
        }
        if !self.strategies.shows(0, walk.subpath.depth + 2) {
            return Vec3::ZERO;
        }
        let outgoing = -walk.subpath.ray.direction;
        let radiance = area_radiance(tables, point, outgoing);
        if radiance.max_element() <= 0.0 {
            return Vec3::ZERO;
        }
        let h = self.strategies.heuristic;
        let density = emission::density(tables, point.emitter, point, outgoing);
        let cosine = float::abs(point.geometric_normal.dot(outgoing));
        let to_light = point.position - walk.subpath.position;
        let pdf_area = if walk.subpath.depth == 0 {
            density.position
        } else {
            self.strategies.pdf_direct(
                tables,
                point.emitter,
                walk.subpath.position,
                point,
                outgoing,
            ) * (cosine / to_light.length_squared())
        };
        let camera =
            h.of(pdf_area) * walk.arrived.d_vcm + h.of(density.product()) * walk.arrived.d_vc;
        walk.subpath.throughput * radiance * self.strategies.weight(0.0, camera)
    }

    /// Emission of the environment where a camera walk leaves the scene (s = 0); nothing for light walks.
    pub fn escaped(&self, walk: &Walk) -> Rgb {
        let tables = self.tables;
        let emitter = tables.info.environment;
        if walk.mode != mode::RADIANCE {
            return Vec3::ZERO;
        }
        let is_hidden = !walk.subpath.sees_emitters(&self.rules);
        if emitter == NONE || is_hidden || !self.strategies.shows(0, walk.subpath.depth + 2) {
            return Vec3::ZERO;
        }
        let direction = walk.subpath.ray.direction;
        let (radiance, pdf) = environment_radiance_and_pdf(tables, direction);
        let mut camera = 0.0;
        if walk.subpath.depth > 0 {
            let h = self.strategies.heuristic;
            let density = emission::density(tables, emitter, &SurfacePoint::ZERO, -direction);
            camera = h.of(pdf) * walk.weights.d_vcm + h.of(density.product()) * walk.weights.d_vc;
        }
        walk.subpath.throughput * radiance * self.strategies.weight(0.0, camera)
    }

    /// Light that a camera walk has met with its ray from the end of `depth` edges, as a contribution, and the emitter.
    pub fn emitter_hit(
        &self,
        found: Rgb,
        depth: u32,
        hit: &Hit,
        site: &ShadingPoint,
    ) -> (Contribution, u32) {
        let emitter = if hit.is_hit() {
            site.point.emitter
        } else {
            self.tables.info.environment
        };
        let met = Contribution {
            value: found,
            t: depth + 2,
            ..Contribution::NONE
        };
        (met, emitter)
    }

    /// Next event estimation at the current vertex of a camera walk (s = 1): `u_select` chooses the emitter, `u` a point or
    /// direction of it.
    pub fn next_event(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        u_select: f32,
        u: Vec2,
    ) -> Contribution {
        let (light, point) = sample_direct_with_point(self.tables, at.point.position, u_select, u);
        self.next_event_with(walk, at, &light, &point)
    }

    /// A connection to the emitter point at which a light walk started (s = 1, without a sample drawn for this surface).
    pub fn start_event(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        start: &EmissionSample,
    ) -> Contribution {
        let light = self.start_sample(at.point.position, start);
        self.next_event_with(walk, at, &light, &start.point)
    }

    /// The emitter point at which a light walk started as a sample for a surface at `position`.
    pub fn start_sample(&self, position: Vec3, start: &EmissionSample) -> DirectSample {
        let tables = self.tables;
        if start.emitter == NONE {
            return DirectSample::NONE;
        }
        let mut light = DirectSample {
            emitter: start.emitter,
            ..DirectSample::NONE
        };
        let kind = tables.emitters[start.emitter as usize].kind;
        if kind == emitter_kind::AREA {
            let to_light = start.point.position - position;
            light.distance = to_light.length();
            light.direction = to_light / light.distance;
            light.target = start.point.offset_position(-light.direction);
            light.radiance = area_radiance(tables, &start.point, -light.direction);
            light.pdf = self.strategies.pdf_direct(
                tables,
                start.emitter,
                position,
                &start.point,
                -light.direction,
            );
        } else if kind == emitter_kind::CONSTANT || kind == emitter_kind::ENVIRONMENT {
            light.direction = -start.ray.direction;
            light.distance = f32::MAX;
            light.radiance = emitter::environment_radiance(tables, light.direction);
            light.pdf =
                start.density.direction * tables.emitters[start.emitter as usize].selection_pdf;
        } else {
            // The position or direction is discrete: there is nothing to choose.
            light = emitter::sample_emitter(tables, start.emitter, position, Vec2::ZERO);
            light.pdf *= tables.emitters[start.emitter as usize].selection_pdf;
        }
        light
    }

    /// Next event estimation with a sample `light` of an emitter, a point of which is `light_point`.
    pub fn next_event_with(
        &self,
        walk: &Walk,
        at: &Interaction<'_>,
        light: &DirectSample,
        light_point: &SurfacePoint,
    ) -> Contribution {
        let t = walk.subpath.depth + 2;
        if !light.is_some() || !self.allows_edges(t) || !self.strategies.shows(1, t) {
            return Contribution::NONE;
        }
        let tables = self.tables;
        let scattered = at.evaluate(tables, &self.rules, mode::RADIANCE, light.direction);
        if !scattered.is_some() {
            return Contribution::NONE;
        }
        let h = self.heuristic_at(at.point.position);
        let by_chance = if light.is_delta != 0 {
            0.0
        } else {
            h.of(scattered.pdf / light.pdf)
        };
        let outgoing = -light.direction;
        let density = emission::density(tables, light.emitter, light_point, outgoing).product();
        let distance2 = light.distance * light.distance;
        let light_cosine = light_cosine(tables, light.emitter, light_point, outgoing, distance2);
        let cosine = float::abs(at.point.geometric_normal.dot(light.direction));
        let camera = if density > 0.0 {
            let ratio = density * cosine / (light.pdf * light_cosine);
            walk.arrived.sum(h, ratio, scattered.pdf_reverse)
        } else {
            0.0
        };
        let weight = self.strategies.weight(by_chance, camera);
        Contribution {
            value: walk.subpath.throughput
                * scattered.value
                * light.radiance
                * (weight / light.pdf),
            ray: if light.distance < f32::MAX {
                at.point.segment_to(light.target)
            } else {
                at.point.spawn(light.direction)
            },
            film: Vec2::ZERO,
            s: 1,
            t,
            emitter: light.emitter,
            blur: at.blur(),
        }
    }

    /// The connection of a vertex of a light walk to the current vertex of a camera walk (s, t > 1).
    pub fn inner(&self, light: &LightEnd<'_>, walk: &Walk, at: &Interaction<'_>) -> Contribution {
        let (s, t) = (light.edges + 1, walk.subpath.depth + 2);
        if !self.allows_edges(s + t - 1) || !self.strategies.shows(s, t) {
            return Contribution::NONE;
        }
        let tables = self.tables;
        let between = light.at.point.position - at.point.position;
        let distance2 = between.length_squared();
        if !(distance2 > 0.0) {
            return Contribution::NONE;
        }
        let direction = between / float::sqrt(distance2);
        let seen = at.evaluate(tables, &self.rules, mode::RADIANCE, direction);
        if !seen.is_some() {
            return Contribution::NONE;
        }
        let sent = light
            .at
            .evaluate(tables, &self.rules, mode::IMPORTANCE, -direction);
        if !sent.is_some() {
            return Contribution::NONE;
        }
        let h = self.heuristic_at(at.point.position);
        let h_light = self.heuristic_at(light.at.point.position);
        let cos_light = float::abs(light.at.point.geometric_normal.dot(direction));
        let cos_camera = float::abs(at.point.geometric_normal.dot(direction));
        let shorter_light =
            light
                .weights
                .sum(h_light, seen.pdf * cos_light / distance2, sent.pdf_reverse);
        let shorter_camera =
            walk.arrived
                .sum(h, sent.pdf * cos_camera / distance2, seen.pdf_reverse);
        let weight = self.strategies.weight(shorter_light, shorter_camera);
        let value = walk.subpath.throughput * seen.value * (light.throughput * sent.value);
        Contribution {
            value: value * (weight / distance2),
            ray: at.point.segment_to_surface(light.at.point),
            film: Vec2::ZERO,
            s,
            t,
            emitter: NONE,
            blur: least_blur(at.blur(), light.at.blur()),
        }
    }

    /// Whether a path may have so many edges.
    #[inline]
    pub fn allows_edges(&self, edges: u32) -> bool {
        edges <= self.rules.max_depth
    }
}

/// The blur of a connection with the given blurs at its ends: the smaller tau, which blurs more.
#[inline]
fn least_blur(a: f32, b: f32) -> f32 {
    if a > 0.0 && (a < b || b == 0.0) { a } else { b }
}
