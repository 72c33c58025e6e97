//! The scene of a test with what traces its full paths.

use crate::scenes::with_view;
use halflight::accel::CpuTraverse;
use halflight::scene::build::Scene;
use halflight_kernel::path::tracer::Tracer;

/// A scene with its ray tracer.
pub type Trace<'a> = Tracer<'a, CpuTraverse<'a>>;

/// Calls `test` with the tracer of a scene that nothing edits, beside which no path tracing runs.
pub fn with_tracer(scene: &Scene, test: impl FnOnce(&Trace<'_>)) {
    with_view(scene, |view| {
        test(&Tracer {
            view,
            rules: scene.settings.rules,
            remainder: None,
            edits: None,
        });
    });
}
