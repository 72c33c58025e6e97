//! The strategy that merges photons around a vertex of a camera subpath.

use super::algorithm::{Adaptive, joined};
use super::records::{AdaptivePhotons, CameraVertex, StrategyBuffers};
use crate::bsdf::mode;
use crate::math::{float, vec3};
use crate::path::Contribution;
use crate::path::path_weights::Strategy;
use crate::regularize::mollifier;
use crate::transport::photon::estimate::{KERNEL, for_photons_within, incidence};
use crate::transport::photon::merging::merging_weight;
use glam::Vec3;

impl Adaptive<'_> {
    /// Photons around the vertex.
    pub(super) fn merge(
        &self,
        buffers: &mut StrategyBuffers<'_>,
        camera: &CameraVertex<'_, '_>,
        photons: &AdaptivePhotons<'_>,
        add: &mut impl FnMut(Contribution),
    ) {
        let connector = &self.algorithm.connector;
        let (tables, rules) = (connector.tables, &connector.rules);
        let (cache, radius) = (&photons.photons.cache, photons.photons.radius);
        let emitted = photons.photons.emitted.max(1) as f32;
        let at = camera.at;
        let hat = at.regularized(camera.node.tau, self.regularization.flags);
        for_photons_within(cache, at.point.position, radius, |index, distance2| {
            let photon = &cache.photons[index as usize];
            let edges = photon.depth.saturating_add(camera.walk.subpath.depth);
            let cosine = incidence(at, photon);
            if !connector.allows_edges(edges.saturating_add(1)) || !(cosine > 0.0) {
                return;
            }
            let node = &photons.nodes[photon.record as usize];
            let direction = -vec3(photon.direction);
            let bound = camera.node.bound_towards(at, direction);
            let is_raised = camera.node.summary.any_raised || node.summary.any_raised;
            let share = if !is_raised {
                0.0
            } else if node.is_infinite {
                self.regularization.share(node.quality_from_infinity(bound))
            } else {
                let quality = joined(&camera.node.quality(bound), &node.quality(bound));
                self.regularization.share(quality.value())
            };
            let k = mollifier::eval_scaled(KERNEL, 2, float::sqrt(distance2), radius);
            let met = |value: Vec3, weight: f32, blur: f32| Contribution {
                value: camera.walk.subpath.throughput
                    * vec3(photon.throughput)
                    * value
                    * (k * weight / (cosine * emitted)),
                t: camera.walk.subpath.depth + 2,
                blur,
                ..Contribution::NONE
            };
            if share < 1.0 {
                let evaluated = at.evaluate(tables, rules, mode::RADIANCE, direction);
                if evaluated.is_some() {
                    let weight = merging_weight(
                        connector,
                        photon.weights(),
                        camera.walk,
                        evaluated.pdf,
                        evaluated.pdf_reverse,
                        at.point.position,
                    );
                    add(met(evaluated.value, weight * (1.0 - share), 0.0));
                }
            }
            if !(share > 0.0) {
                return;
            }
            let evaluated = hat.evaluate(tables, rules, mode::RADIANCE, direction);
            if !evaluated.is_some() {
                return;
            }
            let path = &mut *buffers.path;
            path.inner.clear();
            let mut diffusion = camera.diffusion;
            diffusion.scatter(bound, camera.node.curvature);
            self.push_light(photons.nodes, node, diffusion, path, buffers.site);
            path.inner.reverse();
            let i = path.inner.len() + 1;
            if !self.push_camera(camera, [evaluated.pdf, evaluated.pdf_reverse], path) {
                return;
            }
            path.start = node.start;
            let weight = self.weight(path, Strategy::Merges(i));
            add(met(evaluated.value, weight * share, hat.blur()));
        });
    }
}
