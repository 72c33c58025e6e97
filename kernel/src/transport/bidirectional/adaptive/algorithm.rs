//! The algorithm whose regularisation depends on the path, and the densities of a path that a strategy puts together from two
//! subpaths, by which it is weighted.

use super::records::{CameraVertex, MAX_EDGES, StrategyBuffers};
use crate::path::path_node::PathNode;
use crate::path::path_weights::{PathDensities, Strategy};
use crate::path::{Connector, ShadingPoint};
use crate::regularize::heuristic::{PathDiffusion, SamplerQuality};
use crate::regularize::settings::Regularization;
use crate::transport::bidirectional::algorithm::Bidirectional;
use glam::Vec3;

/// The algorithm with what one sample is asked for.
#[derive(Clone, Copy)]
pub struct Adaptive<'a> {
    pub(super) algorithm: Bidirectional<'a>,
    /// Without weights.
    pub(super) unweighted: Connector<'a>,
    pub(super) regularization: Regularization,
}

impl<'a> Adaptive<'a> {
    /// Of an algorithm that has its regularisation ([`Bidirectional::regularized`]).
    pub fn new(algorithm: &Bidirectional<'a>) -> Adaptive<'a> {
        let mut algorithm = *algorithm;
        let connector = &mut algorithm.connector;
        let regularization = connector.regularization;
        connector.regularization = Regularization::NONE;
        connector.strategies.meets_lens = false;
        connector.rules.max_depth = connector.rules.max_depth.min(MAX_EDGES);
        let mut unweighted = *connector;
        unweighted.strategies.unweighted = true;
        Adaptive {
            algorithm,
            unweighted,
            regularization,
        }
    }

    /// Begins the path of a strategy with a light subpath up to `node`, whose densities to the light and to the sensor are `pdf` and
    /// behind which the spread is `diffusion`; returns whether it fits.
    pub(super) fn begin_path(
        &self,
        buffers: &mut StrategyBuffers<'_>,
        node: &PathNode,
        pdf: [f32; 2],
        diffusion: PathDiffusion,
    ) -> bool {
        let StrategyBuffers { nodes, path, site } = buffers;
        path.inner.clear();
        if path.inner.try_push(node.end(pdf)).is_err() {
            return false;
        }
        self.push_light(nodes, node, diffusion, path, site);
        path.inner.reverse();
        path.start = node.start;
        true
    }

    /// The vertices of a light subpath before `node`, from there to the light, each below its tau; `diffusion` is the spread behind
    /// `node`.
    pub(super) fn push_light(
        &self,
        nodes: &[PathNode],
        node: &PathNode,
        mut diffusion: PathDiffusion,
        path: &mut PathDensities,
        site: &mut ShadingPoint,
    ) {
        diffusion.travel(node.summary.edge);
        let mut index = node.vertex.previous;
        while let Some(node) = nodes.get(index as usize) {
            let tau = self.regularization.threshold(&diffusion);
            let tables = self.unweighted.tables;
            let vertex = node.inner_vertex_below(tables, &self.regularization, tau, site);
            if path.inner.try_push(vertex).is_err() {
                return;
            }
            diffusion.scatter(node.scattering.bound, node.curvature);
            diffusion.travel(node.summary.edge);
            index = node.vertex.previous;
        }
    }

    /// A camera subpath from the vertex where it has arrived, with the densities to the light and to the sensor there; whether
    /// it fits.
    pub(super) fn push_camera(
        &self,
        camera: &CameraVertex<'_, '_>,
        pdf: [f32; 2],
        path: &mut PathDensities,
    ) -> bool {
        if path.inner.try_push(camera.node.end(pdf)).is_err() {
            return false;
        }
        path.first = camera.node.first;
        match camera.before.get(camera.node.vertex.previous as usize) {
            Some(node) => self.push_camera_node(camera.before, node, path),
            None => true,
        }
    }

    /// A vertex that a camera subpath has left, and those before.
    pub(super) fn push_camera_node(
        &self,
        nodes: &[PathNode],
        node: &PathNode,
        path: &mut PathDensities,
    ) -> bool {
        path.first = node.first;
        let mut node = Some(node);
        while let Some(current) = node {
            if path.inner.try_push(current.inner_vertex()).is_err() {
                return false;
            }
            node = nodes.get(current.vertex.previous as usize);
        }
        true
    }

    pub(super) fn weight(&self, path: &PathDensities, strategy: Strategy) -> f32 {
        let connector = &self.algorithm.connector;
        if connector.strategies.unweighted {
            return 1.0;
        }
        let merging = |position: Vec3| connector.heuristic_at(position).merging;
        path.weight(&connector.strategies, strategy, merging)
    }
}

/// Quality of two subpaths without the edge between them.
pub(super) fn joined(a: &SamplerQuality, b: &SamplerQuality) -> SamplerQuality {
    SamplerQuality {
        least: a.least.min(b.least),
        length: a.length + b.length,
    }
}
