//! The two walks of one sample, whose vertices are kept.

use super::algorithm::Adaptive;
use super::records::{AdaptivePhotons, AdaptiveWorkspace, CameraVertex, StrategyBuffers};
use crate::math::float;
use crate::path::path_node::PathNode;
use crate::path::rules::step;
use crate::path::visibility::contribution_transmittance;
use crate::path::{Contribution, Interaction, Walk};
use crate::regularize::bandwidth::TAU_MAX;
use crate::regularize::heuristic::PathDiffusion;
use crate::sampler::Sampler;
use crate::scene::camera::CameraSample;
use crate::scene::emitter::emission::EmissionSample;
use crate::scene::{NONE, SceneView, Traverse};

impl Adaptive<'_> {
    /// One sample: `add` takes what each strategy finds, nothing where it lies in shadow.
    pub fn sample<T: Traverse, S: Sampler>(
        &self,
        view: &SceneView<'_, T>,
        photons: Option<&AdaptivePhotons<'_>>,
        (light_sampler, camera_sampler): (&mut S, &mut S),
        seen: &CameraSample,
        workspace: &mut AdaptiveWorkspace,
        mut add: impl FnMut(Contribution),
    ) {
        let rules = self.algorithm.connector.rules;
        let mut add_unoccluded = |mut found: Contribution| {
            if found.is_some() {
                found.value *= contribution_transmittance(view, &rules, &found);
                add(found);
            }
        };
        workspace.light.clear();
        workspace.camera.clear();
        if rules.max_depth == 0 {
            return;
        }
        let start = self.algorithm.emit(light_sampler);
        if start.is_some() {
            add_unoccluded(self.algorithm.start(&start, light_sampler));
            self.light_walk(view, &start, light_sampler, workspace, &mut add_unoccluded);
        }
        if self.algorithm.has_camera_walks {
            self.camera_walk(
                view,
                photons,
                &start,
                camera_sampler,
                seen,
                workspace,
                &mut add_unoccluded,
            );
        }
    }

    fn light_walk<T: Traverse, S: Sampler>(
        &self,
        view: &SceneView<'_, T>,
        start: &EmissionSample,
        sampler: &mut S,
        workspace: &mut AdaptiveWorkspace,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let strategies = &connector.strategies;
        let mut walk = Walk::from_emitter(start);
        let mut last = NONE;
        let mut next = step::TRACE;
        while next == step::TRACE && !workspace.light.is_full() {
            sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
            let hit = view.traverse.closest_hit(&walk.subpath.ray);
            let direction = walk.subpath.ray.direction;
            next = connector
                .arrive(&mut walk, &hit, &mut workspace.points.arrived)
                .1;
            if next != step::SCATTER {
                continue;
            }
            let at = workspace.points.arrived.interaction(direction);
            let before = (last, workspace.light.get(last as usize));
            let node = PathNode::new(
                connector,
                &self.regularization,
                &walk,
                &hit,
                &at,
                before,
                0.0,
            );
            let index = workspace.light.len();
            workspace.light.push(node);
            if strategies.light_image && (at.is_connectable() || node.is_raised) {
                let u_lens = self.algorithm.lens_numbers(sampler);
                let buffers = StrategyBuffers {
                    nodes: &workspace.light,
                    path: &mut workspace.path,
                    site: &mut workspace.points.light,
                };
                self.seen_by_lens(buffers, index, &walk, &at, u_lens, add);
            }
            next = self.scatter(&mut walk, sampler, &at, &mut workspace.light[index]);
            if next == step::TRACE && workspace.light[index].has_scattered {
                last = index as u32;
            }
        }
    }

    fn camera_walk<T: Traverse, S: Sampler>(
        &self,
        view: &SceneView<'_, T>,
        photons: Option<&AdaptivePhotons<'_>>,
        start: &EmissionSample,
        sampler: &mut S,
        seen: &CameraSample,
        workspace: &mut AdaptiveWorkspace,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let strategies = &connector.strategies;
        let tables = connector.tables;
        let mut walk = Walk::from_sensor(seen);
        let mut last = NONE;
        let mut diffusion = PathDiffusion::SHARP;
        let mut next = step::TRACE;
        workspace.path.sensor = walk.subpath.position;
        while next == step::TRACE && !workspace.camera.is_full() {
            sampler.start_bounce(walk.subpath.depth.saturating_add(walk.subpath.crossings));
            let hit = view.traverse.closest_hit(&walk.subpath.ray);
            let direction = walk.subpath.ray.direction;
            let before = workspace.camera.get(last as usize);
            let buffers = StrategyBuffers {
                nodes: &workspace.camera,
                path: &mut workspace.path,
                site: &mut workspace.points.arrived,
            };
            next = self.arrive(buffers, &mut walk, &hit, before, add);
            if next != step::SCATTER {
                continue;
            }
            let at = workspace.points.arrived.interaction(direction);
            let distance = (at.point.position - walk.subpath.position).length();
            let first = walk.pdf_first(tables, at.point, distance);
            let sensor_bound = if strategies.light_image {
                first * float::sqr(distance)
            } else {
                TAU_MAX
            };
            let of_walk = (last, before);
            let mut node = PathNode::new(
                connector,
                &self.regularization,
                &walk,
                &hit,
                &at,
                of_walk,
                sensor_bound,
            );
            if last == NONE {
                node.first = first;
            }
            let mut arrived = diffusion;
            arrived.travel(distance);
            node.tau = self.regularization.threshold(&arrived);
            if at.is_connectable() || node.is_raised {
                let camera = CameraVertex {
                    walk: &walk,
                    at: &at,
                    node: &node,
                    before: &workspace.camera,
                    diffusion: arrived,
                };
                let mut buffers = StrategyBuffers {
                    nodes: &workspace.light,
                    path: &mut workspace.path,
                    site: &mut workspace.points.light,
                };
                if let Some(photons) = photons {
                    self.merge(&mut buffers, &camera, photons, add);
                }
                self.next_event(&mut buffers, &camera, start, sampler, add);
                for end in 0..workspace.light.len() {
                    self.inner(&mut buffers, &camera, end, add);
                }
            }
            let index = workspace.camera.len();
            next = self.scatter(&mut walk, sampler, &at, &mut node);
            workspace.camera.push(node);
            if next == step::TRACE && node.has_scattered {
                last = index as u32;
                diffusion = arrived;
                diffusion.scatter(node.scattering.bound, node.curvature);
            }
        }
    }

    /// Scatters at a vertex, which learns of it if the walk goes on from there and not through its mask.
    fn scatter<S: Sampler>(
        &self,
        walk: &mut Walk,
        sampler: &mut S,
        at: &Interaction<'_>,
        node: &mut PathNode,
    ) -> u32 {
        let connector = &self.algorithm.connector;
        let depth = walk.subpath.depth;
        let next = connector.scatter(walk, at, sampler);
        if next == step::TRACE && walk.subpath.depth > depth {
            node.record_scattering(connector.tables, &self.regularization, at, walk);
        }
        next
    }
}
