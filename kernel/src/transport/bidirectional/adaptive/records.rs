//! What the two subpaths of a sample and the photons of a pass keep.

use crate::path::path_node::PathNode;
use crate::path::path_weights::{LightStart, MAX_INNER, PathDensities};
use crate::path::{Interaction, ShadingPoint, Walk};
use crate::regularize::heuristic::PathDiffusion;
use crate::transport::bidirectional::algorithm::ConnectedPoints;
use crate::transport::photon::merging::PassPhotons;
use crate::transport::photon::tracing::PhotonStore;
use arrayvec::ArrayVec;
use glam::Vec3;

/// Most edges of a path.
pub const MAX_EDGES: u32 = MAX_INNER as u32;

/// Most vertices of a subpath, those counted whose masks it passes.
const MAX_NODES: usize = 2 * MAX_INNER;

/// Storage for the two subpaths of a sample.
pub struct AdaptiveWorkspace {
    pub(super) light: ArrayVec<PathNode, MAX_NODES>,
    pub(super) camera: ArrayVec<PathNode, MAX_NODES>,
    pub(super) points: ConnectedPoints,
    pub(super) path: PathDensities,
}

impl AdaptiveWorkspace {
    /// Empty.
    pub fn new() -> AdaptiveWorkspace {
        AdaptiveWorkspace {
            light: ArrayVec::new(),
            camera: ArrayVec::new(),
            points: ConnectedPoints::NONE,
            path: PathDensities {
                inner: ArrayVec::new(),
                start: LightStart::NONE,
                sensor: Vec3::ZERO,
                first: 0.0,
            },
        }
    }
}

impl Default for AdaptiveWorkspace {
    fn default() -> AdaptiveWorkspace {
        AdaptiveWorkspace::new()
    }
}

/// The photons of a pass with the vertices of their walks.
#[derive(Clone, Copy)]
pub struct AdaptivePhotons<'a> {
    /// The photons.
    pub photons: PassPhotons<'a>,
    /// By [`crate::transport::photon::cache::Photon::record`]; each has the index of the one before.
    pub nodes: &'a [PathNode],
}

/// Where photons are kept with the vertices of their walks.
pub trait NodeStore: PhotonStore {
    /// Keeps a vertex, that of the photon that comes next if there is one, and returns its index.
    fn push_node(&mut self, node: &PathNode) -> u32;
    /// A vertex that was kept.
    fn node_mut(&mut self, index: u32) -> Option<&mut PathNode>;
}

/// What a strategy needs besides the vertex: the vertices of the other subpath, and buffers for the densities of the path and for a
/// surface.
pub(super) struct StrategyBuffers<'a> {
    pub nodes: &'a [PathNode],
    pub path: &'a mut PathDensities,
    pub site: &'a mut ShadingPoint,
}

/// The current vertex of a camera subpath.
pub(super) struct CameraVertex<'p, 'a> {
    pub walk: &'p Walk,
    /// Its interaction, not regularised.
    pub at: &'p Interaction<'a>,
    pub node: &'p PathNode,
    /// The vertices before.
    pub before: &'p [PathNode],
    /// Path diffusion from the sensor to here.
    pub diffusion: PathDiffusion,
}
