//! Light-transport algorithms, one per file.
//!
//! Each is a function of a scene view, a sampler and a pixel or ray, and returns radiance. They hold no state between
//! calls, so a front end may call them in any order and from any thread.

pub mod ambient_occlusion;
pub mod aov;
pub mod connection;
pub mod direct;
pub mod path;
pub mod photon;
pub mod settings;
pub mod staged;
pub mod visibility;
#[cfg(not(target_arch = "spirv"))]
pub mod wavefront;

use crate::math::{Ray, Rgb};
use crate::sampler::Sampler;
use crate::scene::camera::{self, CameraSample};
use crate::scene::{SceneView, Tables, Traverse};

pub use settings::{IntegratorSettings, integrator_kind};

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
    let sample = sensor_ray(&view.tables, sampler, pixel);
    radiance(sampler, &sample.ray) * sample.weight
}

/// The ray from the sensor with which a sample of the pixel begins, by the sampler's first four numbers.
#[inline]
pub fn sensor_ray<S: Sampler>(
    tables: &Tables<'_>,
    sampler: &mut S,
    pixel: [u32; 2],
) -> CameraSample {
    let u_film = sampler.next_2d();
    let u_lens = sampler.next_2d();
    camera::sample_ray(tables, pixel, u_film, u_lens)
}
