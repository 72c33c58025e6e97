//! The strategy that connects a vertex of a light subpath to one of a camera subpath (s, t > 1).

use super::algorithm::{Adaptive, joined};
use super::records::{CameraVertex, StrategyBuffers};
use crate::bsdf::mode;
use crate::math::vec3;
use crate::path::path_weights::Strategy;
use crate::path::{Contribution, LightEnd};

impl Adaptive<'_> {
    /// The connection to a vertex of the light subpath.
    pub(super) fn inner(
        &self,
        buffers: &mut StrategyBuffers<'_>,
        camera: &CameraVertex<'_, '_>,
        end: usize,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let tables = connector.tables;
        let nodes = buffers.nodes;
        let node = &nodes[end];
        let at = camera.at;
        let algorithm = &self.algorithm;
        if !algorithm.may_connect(camera.walk, at, at.facing(), &node.vertex) {
            return;
        }
        let between = vec3(node.vertex.position) - at.point.position;
        let length = between.length();
        if !(length > 0.0) {
            return;
        }
        let direction = between / length;
        let arrived = node.vertex.look_up(tables, buffers.site);
        let site = *buffers.site;
        let light_at = site.interaction(arrived);
        let (bound, light_bound) = (
            camera.node.bound_towards(at, direction),
            node.bound_towards(&light_at, -direction),
        );
        let share = if !camera.node.summary.any_raised && !node.summary.any_raised {
            0.0
        } else if node.is_infinite {
            self.regularization
                .share(node.quality_from_infinity(light_bound))
        } else {
            let mut quality = joined(&camera.node.quality(bound), &node.quality(light_bound));
            quality.add(bound, light_bound, length);
            self.regularization.share(quality.value())
        };
        if share < 1.0 {
            let light = LightEnd::new(&node.vertex, light_at);
            let found = connector.inner(&light, camera.walk, at);
            add(found.times(1.0 - share));
        }
        if !(share > 0.0) {
            return;
        }
        let regularization = &self.regularization;
        let hat = at.regularized(camera.node.tau, regularization.flags);
        let mut diffusion = camera.diffusion;
        diffusion.scatter(bound, camera.node.curvature);
        diffusion.travel(length);
        let light_hat =
            light_at.regularized(regularization.threshold(&diffusion), regularization.flags);
        let light = LightEnd::new(&node.vertex, light_hat);
        let found = self.unweighted.inner(&light, camera.walk, &hat);
        if !found.is_some() {
            return;
        }
        let rules = &connector.rules;
        let there = hat.evaluate(tables, rules, mode::RADIANCE, direction);
        let sent = light_hat.evaluate(tables, rules, mode::IMPORTANCE, -direction);
        diffusion.scatter(light_bound, node.curvature);
        if !self.begin_path(buffers, node, [sent.pdf_reverse, sent.pdf], diffusion) {
            return;
        }
        let path = &mut *buffers.path;
        let s = path.inner.len() + 1;
        if !self.push_camera(camera, [there.pdf, there.pdf_reverse], path) {
            return;
        }
        add(found.times(share * self.weight(path, Strategy::Connects(s))));
    }
}
