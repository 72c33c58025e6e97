//! Surface features of a sample, for the layers of the image that hold them.

use crate::film::aov::AovSample;
use halflight_kernel::sampler::Sampler;
use halflight_kernel::scene::SceneView;
use halflight_kernel::scene::traverse::Traverse;
use halflight_kernel::transport::aov;

/// The surface that the first ray of a sample of the pixel (in the whole film) meets.
pub fn surface_sample<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    mut sampler: S,
    pixel: [u32; 2],
) -> AovSample {
    let (features, _) = aov::sample_pixel(view, &mut sampler, pixel);
    AovSample {
        albedo: features.albedo.to_array(),
        normal: features.normal.to_array(),
        depth: features.depth,
        position: features.position.to_array(),
        uv: features.uv.to_array(),
    }
}
