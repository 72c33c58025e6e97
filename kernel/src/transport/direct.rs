//! Direct illumination with chosen numbers of emitter and BSDF samples.
//!
//! Emission seen directly plus one scattering: n_e emitter samples and n_b BSDF samples combined with the power
//! heuristic for several samples per technique, w_a = (n_a p_a)^2 / sum (n_i p_i)^2 (Veach 1997, Section 9.2.2). With
//! one of the counts zero the other technique stands alone, as in Veach's comparison figures; light that it cannot find
//! (a delta light with BSDF samples only) is then missing, which is what such a figure shows. Straight passage through
//! masks does not count as scattering, and is deterministic: what is seen behind a mask is scaled by its null weight.
//!
//! The walk from the sensor and those of the BSDF samples, its branches, are [`Path`]s of which each step is called here,
//! or by [`super::staged`].

use super::connection::{SampleCounts, connect};
use super::path::{Path, Scattering, step};
use super::settings::IntegratorSettings;
use crate::bsdf::{Bsdf, BsdfSample, event, mode};
use crate::math::{Ray, Rgb};
use crate::path::rules::is_same_side;
use crate::path::visibility::transmittance;
use crate::sampler::Sampler;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{SceneView, SurfacePoint, Tables, Traverse};

impl SampleCounts {
    /// Those of the settings.
    #[inline]
    pub fn of(settings: &IntegratorSettings) -> SampleCounts {
        SampleCounts {
            emitter: settings.direct.emitter_samples as f32,
            bsdf: settings.direct.bsdf_samples as f32,
        }
    }
}

/// Radiance along `ray` with at most one scattering.
pub fn radiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: &mut S,
    ray: &Ray,
) -> Rgb {
    let tables = &view.tables;
    let mut path = Path::new(ray);
    loop {
        let hit = view.traverse.closest_hit(&path.ray);
        if !hit.is_hit() {
            path.escape(tables, settings);
            break;
        }
        let point = surface_with::<{ detail::TANGENTS }>(tables, &path.ray, &hit);
        let next = path.arrive(tables, settings, &point);
        if next == step::TRACE {
            continue;
        }
        if next == step::END {
            break;
        }
        let wi = path.local_direction(&point);
        let bsdf = Bsdf::at(tables, &point, wi, mode::RADIANCE);
        if bsdf.has_smooth() {
            for _ in 0..settings.direct.emitter_samples {
                let light = connect(
                    tables,
                    sampler,
                    &point,
                    &bsdf,
                    wi,
                    settings.strict_normals != 0,
                    SampleCounts::of(settings),
                );
                if light.is_some() {
                    path.radiance +=
                        path.throughput * light.radiance * transmittance(view, light.ray);
                }
            }
        }
        for _ in 0..settings.direct.bsdf_samples {
            let mut branch = Path::new(&path.ray);
            let u1 = sampler.next_1d();
            let u2 = sampler.next_2d();
            let sample = bsdf.sample(tables.data, wi, u1, u2);
            let mut next = start_branch(&mut branch, settings, &point, &sample);
            while next == step::TRACE {
                let hit = view.traverse.closest_hit(&branch.ray);
                if !hit.is_hit() {
                    branch.escape(tables, settings);
                    break;
                }
                let light = surface_with::<{ detail::TANGENTS }>(tables, &branch.ray, &hit);
                next = follow_branch(&mut branch, tables, &light);
            }
            path.radiance += path.throughput * branch.radiance;
        }
        if path.continue_through_masks(tables, &point) == step::END {
            break;
        }
    }
    path.radiance
}

/// Makes `branch` one of the BSDF samples, divided by their number; says what is next, one of [`step`].
#[inline]
pub fn start_branch(
    branch: &mut Path,
    settings: &IntegratorSettings,
    point: &SurfacePoint,
    sample: &BsdfSample,
) -> u32 {
    if sample.pdf <= 0.0 || sample.event & event::NULL != 0 {
        return step::END;
    }
    let direction = point.frame.to_world(sample.wo).normalize();
    if settings.strict_normals != 0 && !is_same_side(point, direction, sample.wo.z) {
        return step::END;
    }
    let counts = SampleCounts::of(settings);
    branch.last = Scattering {
        position: point.position,
        pdf: counts.bsdf * sample.pdf,
        light_samples: if sample.event & event::DELTA != 0 {
            0.0
        } else {
            counts.emitter
        },
    };
    branch.depth = 1;
    branch.throughput = sample.weight * (1.0 / counts.bsdf);
    branch.ray = point.spawn(direction);
    step::TRACE
}

/// What a branch does where it meets a surface: gathers its light, and looks behind its masks.
#[inline]
pub fn follow_branch(branch: &mut Path, tables: &Tables<'_>, point: &SurfacePoint) -> u32 {
    branch.add_emission(tables, point);
    branch.continue_through_masks(tables, point)
}
