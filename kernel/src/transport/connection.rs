//! Next event estimation: a point of an emitter, and the light that it sends through a surface point towards a viewer.
//!
//! The estimate is w f cos Le V / p_e, with w the weight of the emitter sample against the BSDF samples that compete with
//! it: the power heuristic with exponent two for n_e and n_b samples, w = (n_e p_e)^2 / ((n_e p_e)^2 + (n_b p_b)^2) (Veach
//! 1997, Section 9.2.2), divided by n_e. The visibility V is found along the [`ShadowRay`] that [`evaluate_light`] returns.

use super::settings::IntegratorSettings;
use crate::math::{Ray, Rgb};
use crate::path::visibility::transmittance;
use crate::path::{Interaction, PathRules};
use crate::sampler::Sampler;
use crate::scene::emitter::{self, DirectSample};
use crate::scene::{SceneView, SurfacePoint, Tables, Traverse};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// The power heuristic with exponent two for one sample of each technique.
#[inline]
pub fn power_heuristic(pdf: f32, other: f32) -> f32 {
    if pdf <= 0.0 {
        return 0.0;
    }
    // As a ratio, because squares of densities overflow for narrow lobes.
    let ratio = other / pdf;
    1.0 / (1.0 + ratio * ratio)
}

/// How many samples of each technique a vertex takes.
#[derive(Clone, Copy, Debug)]
pub struct SampleCounts {
    /// Of the emitters.
    pub emitter: f32,
    /// Of the BSDF.
    pub bsdf: f32,
}

impl SampleCounts {
    /// One of each.
    pub const ONE: SampleCounts = SampleCounts {
        emitter: 1.0,
        bsdf: 1.0,
    };

    /// Those of direct illumination.
    #[inline]
    pub fn of(settings: &IntegratorSettings) -> SampleCounts {
        SampleCounts {
            emitter: settings.direct.emitter_samples as f32,
            bsdf: settings.direct.bsdf_samples as f32,
        }
    }
}

/// A shadow ray: the light of an emitter sample, which counts where nothing stands on the segment.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ShadowRay {
    /// The segment to the emitter.
    pub ray: Ray,
    /// What it adds to the radiance towards the viewer.
    pub radiance: Rgb,
}

impl ShadowRay {
    /// No light.
    pub const NONE: ShadowRay = ShadowRay {
        ray: Ray {
            origin: Vec3::ZERO,
            direction: Vec3::Z,
            t_min: 0.0,
            t_max: 0.0,
        },
        radiance: Rgb::ZERO,
    };

    /// Whether there is any light.
    #[inline]
    pub fn is_some(&self) -> bool {
        self.radiance.max_element() > 0.0
    }

    /// The light that arrives.
    #[inline]
    pub fn unshadowed<T: Traverse>(&self, view: &SceneView<'_, T>) -> Rgb {
        self.radiance * transmittance(view, self.ray)
    }
}

/// Chooses an emitter point.
#[inline]
pub fn sample_light<S: Sampler>(
    tables: &Tables<'_>,
    sampler: &mut S,
    point: &SurfacePoint,
) -> DirectSample {
    let u_select = sampler.next_1d();
    let u = sampler.next_2d();
    emitter::sample_direct(tables, point.position, u_select, u)
}

/// Advances the sampler as [`sample_light`] does.
#[inline]
pub fn skip_light_numbers<S: Sampler>(sampler: &mut S) {
    sampler.next_1d();
    sampler.next_2d();
}

/// What the chosen light, one of `counts.emitter` samples that compete with `counts.bsdf` samples of the BSDF, adds to the
/// radiance from the surface, divided by their number.
#[inline]
pub fn evaluate_light(
    tables: &Tables<'_>,
    rules: &PathRules,
    light: &DirectSample,
    at: &Interaction<'_>,
    counts: SampleCounts,
) -> ShadowRay {
    if !light.is_some() {
        return ShadowRay::NONE;
    }
    let wo = at.point.frame.to_local(light.direction);
    if !rules.allows(at.point, light.direction, wo.z) {
        return ShadowRay::NONE;
    }
    let (value, pdf) = at.bsdf.eval_cosine_pdf(tables.data, at.wi, wo);
    if value.max_element() <= 0.0 {
        return ShadowRay::NONE;
    }
    weighted_contribution(light, at.point, counts, value, pdf)
}

/// What the chosen light adds where the BSDF times the cosine is `value` towards it, with the density `pdf`.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn weighted_contribution(
    light: &DirectSample,
    point: &SurfacePoint,
    counts: SampleCounts,
    value: Rgb,
    pdf: f32,
) -> ShadowRay {
    let weight = if light.is_delta != 0 {
        1.0
    } else {
        power_heuristic(counts.emitter * light.pdf, counts.bsdf * pdf)
    };
    ShadowRay {
        radiance: value * light.radiance * (weight / (light.pdf * counts.emitter)),
        ray: if light.distance < f32::MAX {
            point.segment_to(light.target)
        } else {
            point.spawn(light.direction)
        },
    }
}
