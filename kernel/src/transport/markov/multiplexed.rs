//! One strategy of bidirectional path tracing, chosen by primary samples.
//!
//! The multiplexed technique (Hachisuka, Kaplanyan and Dachsbacher 2014, "Multiplexed Metropolis light transport") chooses the
//! number of edges k with the probability (1 - q) q^(k-1) by a number that only large steps change, and the strategy among the
//! k, k + 1 or k + 2 by an ordinary one. The paper runs chains of each k apart and weighs them by integrals b_k; one chain that
//! changes k at large steps needs no such estimates. Longer paths than 64 edges are not made; their share of the
//! choice is 6e-7.

use super::primary_space::{PrimaryNumbers, PrimarySpace};
use crate::bsdf::null_transmittance;
use crate::math::{Rgb, float};
use crate::path::rules::step;
use crate::path::visibility::{contribution_transmittance, has_masks};
use crate::path::{Connector, Contribution, LightEnd, ShadingPoint, Shares, Walk};
use crate::sampler::Sampler;
use crate::scene::camera::CameraSample;
use crate::scene::emitter::emission::EmissionSample;
use crate::scene::{Hit, NONE, Traverse};
use crate::transport::bidirectional::Bidirectional;

/// q of the header.
const LENGTH_RATIO: f32 = 0.8;

/// Most edges of a multiplexed path.
const MAX_EDGES: u32 = 64;

impl<T: Traverse> PrimarySpace<'_, T> {
    /// What the strategy that the numbers choose finds.
    pub(super) fn one_strategy<S: PrimaryNumbers>(
        &self,
        light: &mut S,
        sensor: &mut S,
        seen: &CameraSample,
        add: &mut impl FnMut(Contribution, &Shares),
    ) {
        let u_length = sensor.fixed_1d();
        let u_strategy = sensor.next_1d();
        let (edges, p_edges) = choose_edges(u_length, self.settings.rules.max_depth);
        let mut settings = *self.settings;
        settings.rules.max_depth = edges;
        let mut algorithm = Bidirectional::new(&self.view.tables, &settings);
        // Walks that are followed among edits do not meet the lens.
        algorithm.connector.strategies.meets_lens = !self.is_edited();
        let connector = &algorithm.connector;
        // Strategies that cannot be are not chosen.
        let first_t = if connector
            .strategies
            .pdf_lens(connector.tables, &connector.rules)
            > 0.0
        {
            0
        } else if connector.strategies.light_image {
            1
        } else {
            2
        };
        let count = edges + 2 - first_t;
        let choice = (u_strategy * count as f32) as u32;
        let t = first_t + if choice < count { choice } else { count - 1 };
        let s = edges + 1 - t;
        if self.follows() {
            let factor = count as f32 / p_edges;
            algorithm.connector.strategies.only_s = s;
            algorithm.connector.strategies.only_t = t;
            self.follow_both(&algorithm, light, sensor, seen, |found, shares| {
                let value = found.value * factor;
                add(Contribution { value, ..found }, shares);
            });
            return;
        }
        let camera_walk = Walk::from_sensor(seen);
        let found = self.complete(&algorithm, s, t, light, sensor, camera_walk);
        if found.is_some() {
            let value = found.value
                * contribution_transmittance(self.view, &connector.rules, &found)
                * (count as f32 / p_edges);
            add(Contribution { value, ..found }, &Shares::NONE);
        }
    }

    /// The contribution of one strategy to paths with s + t - 1 edges, the most that the rules allow.
    fn complete<S: Sampler>(
        &self,
        algorithm: &Bidirectional<'_>,
        s: u32,
        t: u32,
        light: &mut S,
        sensor: &mut S,
        mut camera_walk: Walk,
    ) -> Contribution {
        let connector = &algorithm.connector;
        if s == 0 {
            return self.emission_hit(connector, sensor, camera_walk, t);
        }
        let samples_direct = connector.strategies.sample_direct;
        let mut start = EmissionSample::NONE;
        if s > 1 || t < 2 || !samples_direct {
            start = algorithm.emit(light);
            if !start.is_some() {
                return Contribution::NONE;
            }
        }
        if s == 1 && t == 1 {
            light.start_bounce(0);
            return connector.start_to_lens(&start, light.next_2d());
        }
        let mut light_walk = Walk::from_emitter(&start);
        if t == 0 {
            return self.lens_hit(connector, light, light_walk, s);
        }
        let mut light_end = ConnectionVertex::NONE;
        if s > 1 {
            light_end = self.trace_to_vertex(connector, &mut light_walk, light, s - 1);
            if !light_end.is_there {
                return Contribution::NONE;
            }
        }
        let from = light_walk.subpath.ray.direction;
        let light_at = light_end.site.interaction(from);
        if t == 1 {
            let u_lens = light.next_2d();
            let (beta, weights) = (light_walk.subpath.throughput, light_walk.arrived);
            return connector.to_lens(beta, weights, s - 1, &light_at, u_lens);
        }
        let end = self.trace_to_vertex(connector, &mut camera_walk, sensor, t - 1);
        if !end.is_there {
            return Contribution::NONE;
        }
        let at = end.site.interaction(camera_walk.subpath.ray.direction);
        if s > 1 {
            let vertex = light_walk.vertex(&light_end.hit, &light_at, NONE);
            connector.inner(&LightEnd::new(&vertex, light_at), &camera_walk, &at)
        } else if samples_direct {
            let u_select = sensor.next_1d();
            let u = sensor.next_2d();
            connector.next_event(&camera_walk, &at, u_select, u)
        } else {
            connector.start_event(&camera_walk, &at, &start)
        }
    }

    /// Follows a walk until it has scattered `depth` times; returns whether it gets there.
    fn trace_subpath<S: Sampler>(
        &self,
        connector: &Connector<'_>,
        walk: &mut Walk,
        sampler: &mut S,
        depth: u32,
        site: &mut ShadingPoint,
    ) -> bool {
        let h = connector.strategies.heuristic;
        while walk.subpath.depth < depth {
            let hit = self.closest_hit(walk, sampler);
            let (_, mut next) = connector.arrive(walk, &hit, site);
            if next == step::SCATTER {
                let at = site.interaction(walk.subpath.ray.direction);
                next = walk.scatter(connector.tables, &connector.rules, h, sampler, &at);
            }
            if next != step::TRACE {
                return false;
            }
        }
        true
    }

    /// Follows a walk to its vertex after `edges` edges, which must be fit for a connection. Where light may pass straight
    /// through a surface on the last edge, a number decides whether the vertex is there or behind.
    fn trace_to_vertex<S: Sampler>(
        &self,
        connector: &Connector<'_>,
        walk: &mut Walk,
        sampler: &mut S,
        edges: u32,
    ) -> ConnectionVertex {
        let tables = connector.tables;
        let mut vertex = ConnectionVertex::NONE;
        let site = &mut vertex.site;
        if !self.trace_subpath(connector, walk, sampler, edges - 1, site) {
            return vertex;
        }
        loop {
            vertex.hit = self.closest_hit(walk, sampler);
            if !vertex.hit.is_hit() {
                return vertex;
            }
            site.find(tables, &walk.subpath.ray, &vertex.hit);
            let mut passes = connector.is_hidden(walk, &site.point);
            if !passes && has_masks(tables, &site.point) {
                let through = null_transmittance(tables, &site.point);
                let p_through = through.max_element().min(1.0);
                passes = sampler.next_1d() < p_through;
                walk.subpath.throughput *= if passes {
                    through / p_through
                } else {
                    Rgb::splat(1.0 / (1.0 - p_through))
                };
            }
            if passes {
                if walk.subpath.skip_surface(&site.point) != step::TRACE {
                    return vertex;
                }
                continue;
            }
            let (_, next) = connector.arrive_at(walk, site);
            vertex.is_there = next == step::SCATTER && site.bsdf.has_smooth();
            return vertex;
        }
    }

    /// What a walk's ray meets; what is drawn there begins with the numbers of its own bounce.
    #[inline]
    fn closest_hit<S: Sampler>(&self, walk: &Walk, sampler: &mut S) -> Hit {
        sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
        self.view.traverse.closest_hit(&walk.subpath.ray)
    }

    /// s = 0: emission that a camera walk meets after t - 1 edges, behind masks too.
    fn emission_hit<S: Sampler>(
        &self,
        connector: &Connector<'_>,
        sensor: &mut S,
        mut walk: Walk,
        t: u32,
    ) -> Contribution {
        let mut found = Contribution {
            t,
            ..Contribution::NONE
        };
        let mut site = ShadingPoint::NONE;
        if !self.trace_subpath(connector, &mut walk, sensor, t - 2, &mut site) {
            return found;
        }
        let mut next = step::TRACE;
        while next == step::TRACE {
            let hit = self.closest_hit(&walk, sensor);
            let (value, after) = connector.arrive(&mut walk, &hit, &mut site);
            found.value += value;
            next = after;
        }
        found
    }

    /// t = 0: light that meets the lens after s - 1 edges, behind masks too.
    fn lens_hit<S: Sampler>(
        &self,
        connector: &Connector<'_>,
        light: &mut S,
        mut walk: Walk,
        s: u32,
    ) -> Contribution {
        let mut site = ShadingPoint::NONE;
        if !self.trace_subpath(connector, &mut walk, light, s - 2, &mut site) {
            return Contribution::NONE;
        }
        loop {
            let hit = self.closest_hit(&walk, light);
            let met = connector.lens_hit(&walk, hit.t);
            if met.is_some() || connector.arrive(&mut walk, &hit, &mut site).1 != step::TRACE {
                return met;
            }
        }
    }
}

/// Where a walk arrived to be connected.
struct ConnectionVertex {
    is_there: bool,
    site: ShadingPoint,
    hit: Hit,
}

impl ConnectionVertex {
    const NONE: ConnectionVertex = ConnectionVertex {
        is_there: false,
        site: ShadingPoint::NONE,
        hit: Hit::MISS,
    };
}

/// Number of edges of a path and the probability of the choice.
fn choose_edges(u: f32, max_edges: u32) -> (u32, f32) {
    if max_edges < 2 {
        return (1, 1.0);
    }
    // 1 - q^max, the probability of all lengths that may be.
    let all = if max_edges < 256 {
        1.0 - float::exp(float::ln(LENGTH_RATIO) * max_edges as f32)
    } else {
        1.0
    };
    let mut edges = 1;
    let mut probability = (1.0 - LENGTH_RATIO) / all;
    let mut below = probability;
    while u >= below && edges < max_edges.min(MAX_EDGES) {
        edges += 1;
        probability *= LENGTH_RATIO;
        below += probability;
    }
    (edges, probability)
}
