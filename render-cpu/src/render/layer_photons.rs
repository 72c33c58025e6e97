//! The regularisation of a layer, and the photons that vertex merging gathers in it.

use super::pass_context::PassContext;
use super::photon_cache::SortedPhotons;
use super::photon_pass::{PhotonTask, WorkspacePool};
use halflight_kernel::path::retarget_states::Edits;
use halflight_kernel::path::{PathExpressions, PhotonDensity};
use halflight_kernel::regularize::settings::Regularization;
use halflight_kernel::sampler::LaneSampler;
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::IntegratorSettings;
use halflight_kernel::transport::bidirectional::Bidirectional;
use halflight_kernel::transport::photon::merging::merging_tracer;
use halflight_kernel::transport::photon::progressive::{light_walks, pass_radius};

/// The regularisation of a layer: that of the sample with its index.
pub(super) fn regularization<T: Traverse>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    layer: u32,
) -> Regularization {
    Regularization::of_sample(&settings.regularization, view.tables.info.radius, layer)
}

/// The photons that a layer merges.
pub(super) fn trace_photons<T: Traverse + Sync, S: LaneSampler + Send>(
    pass: &PassContext<'_, T, S>,
    layer: u32,
    density: PhotonDensity<'_>,
    expressions: Option<PathExpressions<'_>>,
    edits: Option<Edits<'_>>,
    idle: &WorkspacePool,
) -> Option<SortedPhotons> {
    let (view, settings) = (pass.view, pass.settings);
    let emitted = light_walks(&view.tables, settings);
    let radius = pass_radius(&view.tables, settings, layer);
    let of_layer = regularization(view, settings, layer);
    let adaptive = settings.regularization.is_adaptive().then_some(of_layer);
    let mut algorithm =
        Bidirectional::new(&view.tables, settings).merging(radius, emitted, density);
    if adaptive.is_none() {
        algorithm = algorithm.regularized(of_layer);
    }
    let photons = PhotonTask {
        view,
        tracer: merging_tracer(&algorithm.connector),
        expressions,
        edits,
        adaptive,
        emitted,
        seed: pass.options.seed,
        index: layer,
    };
    photons.trace(idle, pass.stop, &pass.new_sampler)
}
