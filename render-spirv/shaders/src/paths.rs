//! The stages of path tracing and direct illumination, which the host calls over lists of paths.

use crate::scene_entry::{scene_entry, vector};
use halflight_kernel::transport::staged::{self, PathRecord};

/// A path's estimate so far, and whether there is more to come.
fn result(record: &PathRecord) -> [f32; 4] {
    let more = if record.has_ended() { 0.0 } else { 1.0 };
    vector(record.estimate(), more)
}

scene_entry!(begin, |view, settings, work, out[slot], paths[path]| {
    let (sampler, pixel) = work();
    let record = staged::begin(&view.tables, &settings, sampler, pixel);
    paths[path] = record;
    out[slot] = result(&record);
});

/// Declares a stage of one path: its name, and a call of the kernel.
macro_rules! stage {
    ($name:ident, |$view:ident, $settings:ident, $path:ident| $body:expr) => {
        scene_entry!($name, |$view, $settings, work, out[slot], paths[path]| {
            let $path = &mut paths[path];
            $body;
        });
    };
}

/// Declares a stage after which the host asks whether the path goes on.
macro_rules! last_stage {
    ($name:ident, |$view:ident, $settings:ident, $path:ident| $body:expr) => {
        scene_entry!($name, |$view, $settings, work, out[slot], paths[path]| {
            let $path = &mut paths[path];
            $body;
            out[slot] = result(&paths[path]);
        });
    };
}

stage!(trace, |view, settings, path| staged::trace(&view, path));
stage!(arrive, |view, settings, path| staged::arrive(
    &view.tables,
    &settings,
    path
));
stage!(sample_emitter, |view, settings, path| {
    staged::sample_emitter(&view.tables, path)
});
stage!(evaluate_emitter, |view, settings, path| {
    staged::evaluate_emitter(&view.tables, &settings, path)
});
stage!(sample_bsdf, |view, settings, path| staged::sample_bsdf(
    &view.tables,
    path
));
stage!(mix_lobes, |view, settings, path| staged::mix_lobes(
    &view.tables,
    path
));
stage!(scatter, |view, settings, path| staged::scatter(
    &view.tables,
    &settings,
    path
));
last_stage!(trace_shadow_ray, |view, settings, path| {
    staged::trace_shadow_ray(&view, path)
});
last_stage!(continue_through_masks, |view, settings, path| {
    staged::continue_through_masks(&view.tables, path)
});

scene_entry!(branch, |view, settings, work, out[slot], paths[path]| {
    let record = paths[slot];
    staged::branch(&view.tables, &settings, &record, &mut paths[path]);
    out[slot] = result(&paths[path]);
});

scene_entry!(follow_branch, |view,
                             settings,
                             work,
                             out[slot],
                             paths[path]| {
    let mut record = paths[slot];
    staged::follow_branch(&view.tables, &settings, &mut record, &mut paths[path]);
    paths[slot] = record;
    out[slot] = result(&paths[path]);
});
