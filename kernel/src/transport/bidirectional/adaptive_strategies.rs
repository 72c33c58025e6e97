//! The strategies of a path whose regularisation depends on all of it ([`super::adaptive`]).
//!
//! Each is made of two parts: the share of the path that is regularised, by values below the tau of each end and weights over all
//! strategies of the path, and the share that is not, by the connector of the algorithm itself.

use super::adaptive::{Adaptive, AdaptivePhotons};
use crate::bsdf::mode;
use crate::math::{float, vec3};
use crate::path::path_node::{PathNode, light_start, quality_at_infinity};
use crate::path::rules::step;
use crate::path::spread::emission_bound;
use crate::path::whole_weights::{Strategy, WholeDensities};
use crate::path::{Contribution, Interaction, LightEnd, PartialWeights, ShadingPoint, Walk};
use crate::regularize::heuristic::{PathDiffusion, SamplerQuality};
use crate::regularize::mollifier;
use crate::sampler::Sampler;
use crate::scene::emitter::emission::{EmissionSample, light_cosine};
use crate::scene::{Hit, NONE, SurfacePoint, camera};
use crate::transport::photon::estimate::{KERNEL, for_photons_within, incidence};
use crate::transport::photon::merging::merging_weight;
use glam::{Vec2, Vec3};

/// Vertices of a subpath, and room for a path and for a surface.
pub(super) struct Ends<'a> {
    pub nodes: &'a [PathNode],
    pub path: &'a mut WholeDensities,
    pub site: &'a mut ShadingPoint,
}

/// A camera subpath where it has arrived.
pub(super) struct Seen<'p, 'a> {
    pub walk: &'p Walk,
    /// As the model is.
    pub at: &'p Interaction<'a>,
    pub node: &'p PathNode,
    /// The vertices before.
    pub before: &'p [PathNode],
    /// Of the paths around it.
    pub diffusion: PathDiffusion,
}

impl Adaptive<'_> {
    /// A vertex of the light subpath, connected to the lens.
    pub(super) fn seen_by_lens(
        &self,
        ends: Ends<'_>,
        index: usize,
        walk: &Walk,
        at: &Interaction<'_>,
        u_lens: Vec2,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let tables = connector.tables;
        let node = &ends.nodes[index];
        let (throughput, edges) = (walk.subpath.throughput, walk.subpath.depth + 1);
        let seen = camera::film_position(tables, at.point.position, u_lens);
        if !seen.is_valid {
            return;
        }
        let first = seen.importance * camera::pixels_per_window_pixel(&tables.camera);
        let bound = node.bound_towards(at, seen.direction);
        let share = if !node.behind.any_raised {
            0.0
        } else if node.is_infinite {
            self.own.share(node.quality_from_infinity(bound))
        } else {
            let mut quality = node.quality(bound);
            let sensor = first * float::sqr(seen.distance);
            quality.add(bound, sensor, seen.distance);
            self.own.share(quality.value())
        };
        if share < 1.0 {
            let found = connector.to_lens(throughput, walk.arrived, edges, at, u_lens);
            add(found.times(1.0 - share));
        }
        if !(share > 0.0) {
            return;
        }
        let mut diffusion = PathDiffusion::SHARP;
        diffusion.travel(seen.distance);
        let hat = at.regularized(self.own.threshold(&diffusion), self.own.flags);
        let weights = PartialWeights::NONE;
        let found = self.bare.to_lens(throughput, weights, edges, &hat, u_lens);
        if !found.is_some() {
            return;
        }
        let sent = hat.evaluate(tables, &connector.rules, mode::IMPORTANCE, seen.direction);
        let Ends { nodes, path, site } = ends;
        path.inner.clear();
        if path
            .inner
            .try_push(node.end([sent.pdf_reverse, sent.pdf]))
            .is_err()
        {
            return;
        }
        diffusion.scatter(bound, node.curvature);
        self.push_light(nodes, node, diffusion, path, site);
        path.inner.reverse();
        path.start = node.start;
        path.sensor = at.point.position + seen.direction * seen.distance;
        path.first = first;
        let s = path.inner.len() + 1;
        add(found.times(share * self.weight(path, Strategy::Connects(s))));
    }

    /// Where a camera walk arrives: what it meets is handed on, and what is next returned ([`crate::path::arrival`]). The nodes are
    /// those of the camera subpath, of which `last` is the last.
    pub(super) fn arrive(
        &self,
        ends: Ends<'_>,
        walk: &mut Walk,
        hit: &Hit,
        last: Option<&PathNode>,
        add: &mut impl FnMut(Contribution),
    ) -> u32 {
        let connector = &self.algorithm.connector;
        let tables = connector.tables;
        let Ends { nodes, path, site } = ends;
        let seen = Contribution {
            t: walk.subpath.depth + 2,
            ..Contribution::NONE
        };
        let raised = last.filter(|node| node.behind.any_raised);
        let Some(last) = raised else {
            let (value, next) = connector.arrive(walk, hit, site);
            add(Contribution { value, ..seen });
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
            let mut quality = last.quality(last.left.bound);
            quality.add(last.left.bound, emission, edge);
            quality.value()
        } else {
            quality_at_infinity(last.left.bound, emission)
        };
        let share = self.own.share(q);
        if share < 1.0 {
            add(Contribution { value, ..seen }.times(1.0 - share));
        }
        if !(share > 0.0) {
            return next;
        }
        let value = if hit.is_hit() {
            self.bare.emitted(&before, &point)
        } else {
            self.bare.escaped(&before)
        };
        path.inner.clear();
        if !self.push_camera_node(nodes, last, path) {
            return next;
        }
        let position = vec3(last.vertex.position);
        let strategies = &connector.strategies;
        path.start = light_start(tables, strategies, emitter, &point, position, -direction);
        let weight = self.weight(path, Strategy::Connects(0));
        add(Contribution { value, ..seen }.times(share * weight));
        next
    }

    /// Next event estimation, or a connection to the start of the light walk.
    pub(super) fn lit<S: Sampler>(
        &self,
        ends: &mut Ends<'_>,
        seen: &Seen<'_, '_>,
        start: &EmissionSample,
        sampler: &mut S,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let tables = connector.tables;
        let position = seen.at.point.position;
        let (light, point) = self.algorithm.light_sample(position, start, sampler);
        if !light.is_some() {
            return;
        }
        let bound = seen.node.bound_towards(seen.at, light.direction);
        let emission = emission_bound(tables, light.emitter);
        let share = if !seen.node.behind.any_raised {
            0.0
        } else if light.distance < f32::MAX {
            let mut quality = seen.node.quality(bound);
            quality.add(bound, emission, light.distance);
            self.own.share(quality.value())
        } else {
            self.own.share(quality_at_infinity(bound, emission))
        };
        if share < 1.0 {
            let found = connector.lit(seen.walk, seen.at, &light, &point);
            add(found.times(1.0 - share));
        }
        if !(share > 0.0) {
            return;
        }
        let hat = seen.at.regularized(seen.node.tau, self.own.flags);
        let found = self.bare.lit(seen.walk, &hat, &light, &point);
        if !found.is_some() {
            return;
        }
        let both = hat.evaluate(tables, &connector.rules, mode::RADIANCE, light.direction);
        let path = &mut *ends.path;
        path.inner.clear();
        if !self.push_camera(seen, [both.pdf, both.pdf_reverse], path) {
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

    /// The connection to a vertex of the light subpath.
    pub(super) fn inner(
        &self,
        ends: &mut Ends<'_>,
        seen: &Seen<'_, '_>,
        end: usize,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let tables = connector.tables;
        let node = &ends.nodes[end];
        let at = seen.at;
        let algorithm = &self.algorithm;
        if !algorithm.may_connect(seen.walk, at, at.facing(), &node.vertex) {
            return;
        }
        let between = vec3(node.vertex.position) - at.point.position;
        let length = between.length();
        if !(length > 0.0) {
            return;
        }
        let direction = between / length;
        let arrived = node.vertex.look_up(tables, ends.site);
        let site = *ends.site;
        let light_at = site.interaction(arrived);
        let (bound, light_bound) = (
            seen.node.bound_towards(at, direction),
            node.bound_towards(&light_at, -direction),
        );
        let share = if !seen.node.behind.any_raised && !node.behind.any_raised {
            0.0
        } else if node.is_infinite {
            self.own.share(node.quality_from_infinity(light_bound))
        } else {
            let mut quality = joined(&seen.node.quality(bound), &node.quality(light_bound));
            quality.add(bound, light_bound, length);
            self.own.share(quality.value())
        };
        if share < 1.0 {
            let light = LightEnd::new(&node.vertex, light_at);
            let found = connector.inner(&light, seen.walk, at);
            add(found.times(1.0 - share));
        }
        if !(share > 0.0) {
            return;
        }
        let own = &self.own;
        let hat = at.regularized(seen.node.tau, own.flags);
        let mut diffusion = seen.diffusion;
        diffusion.scatter(bound, seen.node.curvature);
        diffusion.travel(length);
        let light_hat = light_at.regularized(own.threshold(&diffusion), own.flags);
        let light = LightEnd::new(&node.vertex, light_hat);
        let found = self.bare.inner(&light, seen.walk, &hat);
        if !found.is_some() {
            return;
        }
        let rules = &connector.rules;
        let there = hat.evaluate(tables, rules, mode::RADIANCE, direction);
        let sent = light_hat.evaluate(tables, rules, mode::IMPORTANCE, -direction);
        let path = &mut *ends.path;
        path.inner.clear();
        if path
            .inner
            .try_push(node.end([sent.pdf_reverse, sent.pdf]))
            .is_err()
        {
            return;
        }
        diffusion.scatter(light_bound, node.curvature);
        self.push_light(ends.nodes, node, diffusion, path, ends.site);
        path.inner.reverse();
        let s = path.inner.len() + 1;
        if !self.push_camera(seen, [there.pdf, there.pdf_reverse], path) {
            return;
        }
        path.start = node.start;
        add(found.times(share * self.weight(path, Strategy::Connects(s))));
    }

    /// Photons around the vertex.
    pub(super) fn merge(
        &self,
        ends: &mut Ends<'_>,
        seen: &Seen<'_, '_>,
        photons: &AdaptivePhotons<'_>,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let (tables, rules) = (connector.tables, &connector.rules);
        let (cache, radius) = (&photons.photons.cache, photons.photons.radius);
        let emitted = photons.photons.emitted.max(1) as f32;
        let at = seen.at;
        let hat = at.regularized(seen.node.tau, self.own.flags);
        for_photons_within(cache, at.point.position, radius, |index, distance2| {
            let photon = &cache.photons[index as usize];
            let edges = photon.depth.saturating_add(seen.walk.subpath.depth);
            let cosine = incidence(at, photon);
            if !connector.allows_edges(edges.saturating_add(1)) || !(cosine > 0.0) {
                return;
            }
            let node = &photons.nodes[photon.beside as usize];
            let direction = -vec3(photon.direction);
            let bound = seen.node.bound_towards(at, direction);
            let is_raised = seen.node.behind.any_raised || node.behind.any_raised;
            let share = if !is_raised {
                0.0
            } else if node.is_infinite {
                self.own.share(node.quality_from_infinity(bound))
            } else {
                let quality = joined(&seen.node.quality(bound), &node.quality(bound));
                self.own.share(quality.value())
            };
            let k = mollifier::eval_scaled(KERNEL, 2, float::sqrt(distance2), radius);
            let met = |value: Vec3, weight: f32, blur: f32| Contribution {
                value: seen.walk.subpath.throughput
                    * vec3(photon.throughput)
                    * value
                    * (k * weight / (cosine * emitted)),
                t: seen.walk.subpath.depth + 2,
                blur,
                ..Contribution::NONE
            };
            if share < 1.0 {
                let own = at.evaluate(tables, rules, mode::RADIANCE, direction);
                if own.is_some() {
                    let weight = merging_weight(
                        connector,
                        photon.weights(),
                        seen.walk,
                        own.pdf,
                        own.pdf_reverse,
                        at.point.position,
                    );
                    add(met(own.value, weight * (1.0 - share), 0.0));
                }
            }
            if !(share > 0.0) {
                return;
            }
            let own = hat.evaluate(tables, rules, mode::RADIANCE, direction);
            if !own.is_some() {
                return;
            }
            let path = &mut *ends.path;
            path.inner.clear();
            let mut diffusion = seen.diffusion;
            diffusion.scatter(bound, seen.node.curvature);
            self.push_light(photons.nodes, node, diffusion, path, ends.site);
            path.inner.reverse();
            let i = path.inner.len() + 1;
            if !self.push_camera(seen, [own.pdf, own.pdf_reverse], path) {
                return;
            }
            path.start = node.start;
            let weight = self.weight(path, Strategy::Merges(i));
            add(met(own.value, weight * share, hat.blur()));
        });
    }

    /// The vertices of a light subpath before `node`, from there to the light, each below its tau; `diffusion` is the spread behind
    /// `node`.
    fn push_light(
        &self,
        nodes: &[PathNode],
        node: &PathNode,
        mut diffusion: PathDiffusion,
        path: &mut WholeDensities,
        site: &mut ShadingPoint,
    ) {
        diffusion.travel(node.behind.edge);
        let mut index = node.vertex.previous;
        while let Some(node) = nodes.get(index as usize) {
            let tau = self.own.threshold(&diffusion);
            let tables = self.bare.tables;
            let vertex = node.passed_below(tables, &self.own, tau, site);
            if path.inner.try_push(vertex).is_err() {
                return;
            }
            diffusion.scatter(node.left.bound, node.curvature);
            diffusion.travel(node.behind.edge);
            index = node.vertex.previous;
        }
    }

    /// A camera subpath from the vertex where it has arrived, with the densities to the light and to the sensor there; whether
    /// there is room for it.
    fn push_camera(&self, seen: &Seen<'_, '_>, pdf: [f32; 2], path: &mut WholeDensities) -> bool {
        if path.inner.try_push(seen.node.end(pdf)).is_err() {
            return false;
        }
        path.first = seen.node.first;
        match seen.before.get(seen.node.vertex.previous as usize) {
            Some(node) => self.push_camera_node(seen.before, node, path),
            None => true,
        }
    }

    /// A vertex that a camera subpath has left, and those before.
    fn push_camera_node(
        &self,
        nodes: &[PathNode],
        node: &PathNode,
        path: &mut WholeDensities,
    ) -> bool {
        path.first = node.first;
        let mut node = Some(node);
        while let Some(own) = node {
            if path.inner.try_push(own.passed()).is_err() {
                return false;
            }
            node = nodes.get(own.vertex.previous as usize);
        }
        true
    }

    fn weight(&self, path: &WholeDensities, strategy: Strategy) -> f32 {
        let connector = &self.algorithm.connector;
        if connector.strategies.unweighted {
            return 1.0;
        }
        let merging = |position: Vec3| connector.heuristic_at(position).merging;
        path.weight(&connector.strategies, strategy, merging)
    }
}

/// Quality of two subpaths without the edge between them.
fn joined(a: &SamplerQuality, b: &SamplerQuality) -> SamplerQuality {
    SamplerQuality {
        least: a.least.min(b.least),
        length: a.length + b.length,
    }
}
