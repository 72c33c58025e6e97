//! The photons of a pass, traced and sorted by all threads.

use super::photon_cache::{PhotonList, SortedPhotons};
use super::photon_job::{PhotonWorkspace, WALKS};
use super::stop::Stop;
use halflight_kernel::path::PathExpressions;
use halflight_kernel::path::retarget_states::Edits;
use halflight_kernel::regularize::settings::Regularization;
use halflight_kernel::sampler::{LaneSampler, mix};
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::photon::tracing::PhotonTracer;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::sync::{Mutex, PoisonError};

/// Turns the seed of camera walks into that of photons.
const PHOTON_STREAM: u32 = 0x51ed_270b;

/// Workspaces that no thread uses.
pub(super) struct WorkspacePool(Mutex<Vec<PhotonWorkspace>>);

impl WorkspacePool {
    /// None yet.
    pub fn new() -> WorkspacePool {
        WorkspacePool(Mutex::new(Vec::new()))
    }

    /// Calls `work` with one of them.
    pub fn with<R>(&self, work: impl FnOnce(&mut PhotonWorkspace) -> R) -> R {
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let workspace = lock().pop();
        let mut workspace = workspace.unwrap_or_else(PhotonWorkspace::new);
        let result = work(&mut workspace);
        lock().push(workspace);
        result
    }
}

/// The tracing of the photons of a pass.
pub(super) struct PhotonTask<'a, T: Traverse> {
    /// The scene.
    pub view: &'a SceneView<'a, T>,
    /// What leaves them.
    pub tracer: PhotonTracer<'a>,
    /// What divides the image, if anything.
    pub expressions: Option<PathExpressions<'a>>,
    /// The edits of its light transport, if there are any.
    pub edits: Option<Edits<'a>>,
    /// The regularisation of the pass, where it depends on full paths.
    pub adaptive: Option<Regularization>,
    /// Light walks.
    pub emitted: u32,
    /// Seed of the run.
    pub seed: u32,
    /// Index of the pass.
    pub index: u32,
}

impl<T: Traverse + Sync> PhotonTask<'_, T> {
    /// Traces and sorts them; nothing if it is to stop. The numbers of the light walks are one sequence, so that a sampler with
    /// well-spread points spreads the photons of a pass.
    pub fn trace<S: LaneSampler + Send>(
        &self,
        idle: &WorkspacePool,
        stop: &Stop<'_>,
        new: &(impl Fn(u32, u32, u32) -> S + Sync),
    ) -> Option<SortedPhotons> {
        let seed = mix(self.seed ^ PHOTON_STREAM);
        let lists: Option<Vec<PhotonList>> = (0..self.emitted.div_ceil(WALKS))
            .into_par_iter()
            .map(|batch| {
                if stop.is_urgent() {
                    return None;
                }
                let first = batch * WALKS;
                let mut samplers: Vec<S> = (first..self.emitted.min(first + WALKS))
                    .map(|walk| new(seed, self.index, walk))
                    .collect();
                Some(idle.with(|workspace| {
                    let expressions = self.expressions.as_ref();
                    let edits = self.edits.as_ref();
                    let tracer = &self.tracer;
                    if let Some(regularization) = &self.adaptive {
                        return workspace.trace_nodes(
                            self.view,
                            tracer,
                            regularization,
                            &mut samplers,
                        );
                    }
                    workspace.trace_photons(self.view, tracer, expressions, edits, &mut samplers)
                }))
            })
            .collect();
        Some(SortedPhotons::new(&lists?))
    }
}
