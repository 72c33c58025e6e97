//! One sample of a pixel: a camera ray, and the radiance along it by the algorithm of the settings.

use super::settings::{IntegratorSettings, integrator_kind};
use super::{ambient_occlusion, direct, path};
use crate::math::{Ray, Rgb};
use crate::sampler::Sampler;
use crate::scene::camera::{self, CameraSample};
use crate::scene::{SceneView, Tables, Traverse};

/// One sample of the pixel at absolute film coordinates, times its reconstruction weight.
///
/// The sampler's first four numbers choose the film and the lens position; the rest is the algorithm's.
pub fn sample_pixel<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: &mut S,
    pixel: [u32; 2],
) -> Rgb {
    sample_pixel_with(view, sampler, pixel, |sampler, ray| match settings.kind {
        integrator_kind::DIRECT => direct::radiance(view, settings, sampler, ray),
        integrator_kind::AMBIENT_OCCLUSION => {
            ambient_occlusion::radiance(view, settings, sampler, ray)
        }
        #[cfg(not(target_arch = "spirv"))]
        integrator_kind::MANIFOLD_PATH => {
            super::manifold_path::radiance(view, settings, sampler, ray)
        }
        _ => path::radiance(view, settings, sampler, ray),
    })
}

/// [`sample_pixel`] by a given algorithm: a shader holds one of them only.
#[inline]
pub fn sample_pixel_with<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    sampler: &mut S,
    pixel: [u32; 2],
    radiance: impl FnOnce(&mut S, &Ray) -> Rgb,
) -> Rgb {
    let sample = camera_ray(&view.tables, sampler, pixel);
    radiance(sampler, &sample.ray) * sample.weight
}

/// The camera ray of a sample of the pixel, by the sampler's first four numbers.
#[inline]
pub fn camera_ray<S: Sampler>(
    tables: &Tables<'_>,
    sampler: &mut S,
    pixel: [u32; 2],
) -> CameraSample {
    let u_film = sampler.next_2d();
    let u_lens = sampler.next_2d();
    camera::sample_ray(tables, pixel, u_film, u_lens)
}
