//! The strategies that end at a light: a camera walk that meets one (s = 0), and next event estimation (s = 1).

use super::algorithm::Adaptive;
use super::records::{CameraVertex, StrategyBuffers};
use crate::bsdf::mode;
use crate::math::vec3;
use crate::path::path_node::{PathNode, light_start, quality_at_infinity};
use crate::path::path_weights::Strategy;
use crate::path::rules::step;
use crate::path::spread::emission_bound;
use crate::path::{Contribution, Walk};
use crate::sampler::Sampler;
use crate::scene::emitter::emission::{EmissionSample, light_cosine};
use crate::scene::{Hit, NONE, SurfacePoint};

impl Adaptive<'_> {
    /// Where a camera walk arrives: what it meets is passed on, and what is next returned ([`crate::path::arrival`]). The nodes are
    /// those of the camera subpath, of which `last` is the last.
    pub(super) fn arrive(
        &self,
        buffers: StrategyBuffers<'_>,
        walk: &mut Walk,
        hit: &Hit,
        last: Option<&PathNode>,
        add: &mut impl FnMut(Contribution),
    ) -> u32 {
        let connector = &self.algorithm.connector;
        let tables = connector.tables;
        let StrategyBuffers { nodes, path, site } = buffers;
        let met = Contribution {
            t: walk.subpath.depth + 2,
            ..Contribution::NONE
        };
        let raised = last.filter(|node| node.summary.any_raised);
        let Some(last) = raised else {
            let (value, next) = connector.arrive(walk, hit, site);
            add(Contribution { value, ..met });
            return next;
        };
        let direction = walk.subpath.ray.direction;
        let (emitter, point) = if hit.is_hit() {
            site.find(tables, &walk.subpath.ray, hit);
            if connector.is_hidden(walk, &site.point) {
                return walk.subpath.skip_surface(&site.point);
            }
            (site.point.emitter, site.point)
        } else {
            (tables.info.environment, SurfacePoint::ZERO)
        };
        let before = *walk;
        let (value, next) = if hit.is_hit() {
            connector.arrive_at(walk, site)
        } else {
            (connector.escaped(walk), step::END)
        };
        if !(value.max_element() > 0.0) || emitter == NONE {
            return next;
        }
        let edge = (point.position - before.subpath.position).length();
        let emission = emission_bound(tables, emitter);
        let q = if hit.is_hit() {
            let mut quality = last.quality(last.scattering.bound);
            quality.add(last.scattering.bound, emission, edge);
            quality.value()
        } else {
            quality_at_infinity(last.scattering.bound, emission)
        };
        let share = self.regularization.share(q);
        if share < 1.0 {
            add(Contribution { value, ..met }.times(1.0 - share));
        }
        if !(share > 0.0) {
            return next;
        }
        let value = if hit.is_hit() {
            self.unweighted.emitted(&before, &point)
        } else {
            self.unweighted.escaped(&before)
        };
        path.inner.clear();
        if !self.push_camera_node(nodes, last, path) {
            return next;
        }
        let position = vec3(last.vertex.position);
        let strategies = &connector.strategies;
        path.start = light_start(tables, strategies, emitter, &point, position, -direction);
        let weight = self.weight(path, Strategy::Connects(0));
        add(Contribution { value, ..met }.times(share * weight));
        next
    }

    /// Next event estimation, or a connection to the start of the light walk.
    pub(super) fn next_event<S: Sampler>(
        &self,
        buffers: &mut StrategyBuffers<'_>,
        camera: &CameraVertex<'_, '_>,
        start: &EmissionSample,
        sampler: &mut S,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let tables = connector.tables;
        let position = camera.at.point.position;
        let (light, point) = self.algorithm.light_sample(position, start, sampler);
        if !light.is_some() {
            return;
        }
        let bound = camera.node.bound_towards(camera.at, light.direction);
        let emission = emission_bound(tables, light.emitter);
        let share = if !camera.node.summary.any_raised {
            0.0
        } else if light.distance < f32::MAX {
            let mut quality = camera.node.quality(bound);
            quality.add(bound, emission, light.distance);
            self.regularization.share(quality.value())
        } else {
            self.regularization
                .share(quality_at_infinity(bound, emission))
        };
        if share < 1.0 {
            let found = connector.next_event_with(camera.walk, camera.at, &light, &point);
            add(found.times(1.0 - share));
        }
        if !(share > 0.0) {
            return;
        }
        let hat = camera
            .at
            .regularized(camera.node.tau, self.regularization.flags);
        let found = self
            .unweighted
            .next_event_with(camera.walk, &hat, &light, &point);
        if !found.is_some() {
            return;
        }
        let both = hat.evaluate(tables, &connector.rules, mode::RADIANCE, light.direction);
        let path = &mut *buffers.path;
        path.inner.clear();
        if !self.push_camera(camera, [both.pdf, both.pdf_reverse], path) {
            return;
        }
        let strategies = &connector.strategies;
        let direction = -light.direction;
        path.start = light_start(
            tables,
            strategies,
            light.emitter,
            &point,
            position,
            direction,
        );
        path.start.direct = light.pdf;
        // Of a point light there is no surface point.
        let distance2 = light.distance * light.distance;
        path.start.cosine = light_cosine(tables, light.emitter, &point, direction, distance2);
        let weight = self.weight(path, Strategy::Connects(1));
        add(found.times(share * weight));
    }
}
