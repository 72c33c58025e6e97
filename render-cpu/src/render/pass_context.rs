//! What every part of a pass needs: the scene, the settings, the sampler, and when to stop.

use super::options::RenderOptions;
use super::stop::Stop;
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::IntegratorSettings;

/// What the parts of a pass have in common.
pub(super) struct PassContext<'a, T: Traverse, S> {
    /// The scene.
    pub view: &'a SceneView<'a, T>,
    /// The algorithm.
    pub settings: &'a IntegratorSettings,
    /// Seed and first sample.
    pub options: &'a RenderOptions,
    /// When to leave the pass.
    pub stop: &'a Stop<'a>,
    /// The sampler of (seed, pixel, sample).
    pub new_sampler: fn(u32, u32, u32) -> S,
}

impl<'a, T: Traverse, S> PassContext<'a, T, S> {
    /// Of a pass with these samplers.
    pub fn new(
        view: &'a SceneView<'a, T>,
        settings: &'a IntegratorSettings,
        options: &'a RenderOptions,
        stop: &'a Stop<'a>,
        new_sampler: fn(u32, u32, u32) -> S,
    ) -> PassContext<'a, T, S> {
        PassContext {
            view,
            settings,
            options,
            stop,
            new_sampler,
        }
    }
}
