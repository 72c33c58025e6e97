//! Light-transport algorithms, one per file.
//!
//! Each is a function of a scene view, a sampler and a pixel or ray, and returns radiance. They hold no state between
//! calls, so a front end may call them in any order and from any thread.

pub mod ambient_occlusion;
pub mod aov;
pub mod connection;
pub mod direct;
pub mod path;
pub mod staged;
pub mod visibility;
#[cfg(not(target_arch = "spirv"))]
pub mod wave;

use crate::math::{Ray, Rgb};
use crate::sampler::Sampler;
use crate::scene::camera::{self, CameraSample};
use crate::scene::{SceneView, Tables, Traverse};

/// Which algorithm estimates a pixel.
pub mod integrator_kind {
    /// Unidirectional path tracing ([`super::path`]).
    pub const PATH: u32 = 0;
    /// Direct illumination with chosen numbers of samples ([`super::direct`]).
    pub const DIRECT: u32 = 1;
    /// Ambient occlusion ([`super::ambient_occlusion`]).
    pub const AMBIENT_OCCLUSION: u32 = 2;
}

/// Parameters of the pixel estimators.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct IntegratorSettings {
    /// One of [`integrator_kind`].
    pub kind: u32,
    /// Longest path in edges: 1 sees emitters, 2 adds direct illumination; [`u32::MAX`] for no limit.
    pub max_depth: u32,
    /// Number of edges from which paths may end at random.
    pub rr_depth: u32,
    /// 1 if rays from the sensor pass emitters as if they were not there.
    pub hide_emitters: u32,
    /// 1 if directions must lie on the same side of the geometric and the shading surface.
    pub strict_normals: u32,
    /// Emitter samples per sensor ray (direct illumination).
    pub emitter_samples: u32,
    /// BSDF samples per sensor ray (direct illumination).
    pub bsdf_samples: u32,
    /// Rays per sensor ray (ambient occlusion).
    pub occlusion_samples: u32,
    /// Longest distance that occludes, as a fraction of the scene's radius (ambient occlusion).
    pub occlusion_distance: f32,
}

impl IntegratorSettings {
    /// Path tracing without a depth limit, Russian roulette from the fifth edge: Mitsuba's defaults.
    pub const PATH: IntegratorSettings = IntegratorSettings {
        kind: integrator_kind::PATH,
        max_depth: u32::MAX,
        rr_depth: 5,
        hide_emitters: 0,
        strict_normals: 0,
        emitter_samples: 1,
        bsdf_samples: 1,
        occlusion_samples: 1,
        occlusion_distance: 0.5,
    };
}

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
