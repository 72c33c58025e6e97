//! The strategy that connects a vertex of a light subpath to the lens (t = 1).

use super::algorithm::Adaptive;
use super::records::StrategyBuffers;
use crate::bsdf::mode;
use crate::math::float;
use crate::path::path_weights::Strategy;
use crate::path::{Contribution, Interaction, PartialWeights, Walk};
use crate::regularize::heuristic::PathDiffusion;
use crate::scene::camera;
use glam::Vec2;

impl Adaptive<'_> {
    /// A vertex of the light subpath, connected to the lens.
    pub(super) fn seen_by_lens(
        &self,
        mut buffers: StrategyBuffers<'_>,
        index: usize,
        walk: &Walk,
        at: &Interaction<'_>,
        u_lens: Vec2,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let tables = connector.tables;
        let nodes = buffers.nodes;
        let node = &nodes[index];
        let (throughput, edges) = (walk.subpath.throughput, walk.subpath.depth + 1);
        let seen = camera::film_position(tables, at.point.position, u_lens);
        if !seen.is_valid {
            return;
        }
        let first = seen.importance * camera::pixels_per_window_pixel(&tables.camera);
        let bound = node.bound_towards(at, seen.direction);
        let share = if !node.summary.any_raised {
            0.0
        } else if node.is_infinite {
            self.regularization.share(node.quality_from_infinity(bound))
        } else {
            let mut quality = node.quality(bound);
            let sensor = first * float::sqr(seen.distance);
            quality.add(bound, sensor, seen.distance);
            self.regularization.share(quality.value())
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
        let hat = at.regularized(
            self.regularization.threshold(&diffusion),
            self.regularization.flags,
        );
        let weights = PartialWeights::NONE;
        let found = self
            .unweighted
            .to_lens(throughput, weights, edges, &hat, u_lens);
        if !found.is_some() {
            return;
        }
        let sent = hat.evaluate(tables, &connector.rules, mode::IMPORTANCE, seen.direction);
        diffusion.scatter(bound, node.curvature);
        if !self.begin_path(&mut buffers, node, [sent.pdf_reverse, sent.pdf], diffusion) {
            return;
        }
        let path = buffers.path;
        path.sensor = at.point.position + seen.direction * seen.distance;
        path.first = first;
        let s = path.inner.len() + 1;
        add(found.times(share * self.weight(path, Strategy::Connects(s))));
    }
}
