//! The scene of a test with what traces its full paths, and paths that carry light in it.

use crate::scenes::with_view;
use halflight::accel::CpuTraverse;
use halflight::scene::build::Scene;
use halflight_kernel::path::full_path::Blurring;
use halflight_kernel::path::tracer::Tracer;
use halflight_kernel::sampler::IndependentSampler;
use halflight_kernel::transport::markov::veach::{ChainPath, candidate};

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

/// Calls `test` with the paths of candidates that carry light, and numbers that are those of the candidate.
pub fn with_lit_paths(
    tracer: &Trace<'_>,
    candidates: u32,
    mut test: impl FnMut(&ChainPath, &mut IndependentSampler),
) {
    for i in 0..candidates {
        let [mut sensor, mut light, mut own] =
            [1, 2, 3].map(|seed| IndependentSampler::new(seed, 0, i));
        let mut add = |path: &ChainPath, weight: f32| {
            if weight > 0.0 {
                test(path, &mut own);
            }
        };
        candidate::paths(tracer, Blurring::NONE, &mut sensor, &mut light, &mut add);
    }
}
