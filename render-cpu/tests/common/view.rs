//! A scene as the transport sees it, for tests.

use halflight::accel::{Accel, CpuTraverse};
use halflight::scene::build::Scene;
use halflight_kernel::scene::SceneView;

/// The view that tests see.
pub type View<'a> = SceneView<'a, CpuTraverse<'a>>;

/// What `work` makes of a scene's tables with its ray tracer.
pub fn with_view<R>(scene: &Scene, work: impl FnOnce(&View<'_>) -> R) -> R {
    let tables = scene.tables.view();
    let accel = Accel::build(tables, &scene.tables.groups);
    let traverse = accel.traverse(tables);
    work(&SceneView {
        tables,
        traverse: &traverse,
    })
}
