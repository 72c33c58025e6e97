//! Direct illumination with chosen numbers of emitter and BSDF samples.
//!
//! Emission seen directly plus one scattering: n_e emitter samples and n_b BSDF samples combined with the power
//! heuristic for several samples per technique, w_a = (n_a p_a)^2 / sum (n_i p_i)^2 (Veach 1997, Section 9.2.2). With
//! one of the counts zero the other technique stands alone, as in Veach's comparison figures; light that it cannot find
//! (a delta light with BSDF samples only) is then missing, which is what such a figure shows. Straight passage through
//! masks does not count as scattering.

use super::IntegratorSettings;
use super::path::{SampleCounts, emitter_sample, is_same_side, power_heuristic};
use super::visibility::{MAX_NULL_CROSSINGS, pass_through};
use crate::bsdf::{Bsdf, event, mode};
use crate::math::{Ray, Rgb};
use crate::sampler::Sampler;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{NONE, SceneView, SurfacePoint, Traverse, emitter};
use glam::Vec3;

/// Radiance along `ray` with at most one scattering.
pub fn radiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: &mut S,
    ray: &Ray,
) -> Rgb {
    let tables = &view.tables;
    let mut ray = *ray;
    let mut radiance = Rgb::ZERO;
    let mut transmitted = Rgb::ONE;
    let mut crossings = 0;
    while crossings <= MAX_NULL_CROSSINGS {
        crossings += 1;
        let hit = view.traverse.closest_hit(&ray);
        if !hit.is_hit() {
            if settings.hide_emitters == 0 && tables.info.environment != NONE {
                radiance += transmitted * emitter::environment_radiance(tables, ray.direction);
            }
            break;
        }
        let point = surface_with::<{ detail::TANGENTS }>(tables, &ray, &hit);
        if point.emitter != NONE {
            if settings.hide_emitters != 0 {
                pass_through(&mut ray, &point);
                continue;
            }
            radiance += transmitted * emitter::area_radiance(tables, &point, -ray.direction);
        }
        if settings.max_depth < 2 {
            break;
        }
        let wi = point.frame.to_local(-ray.direction);
        if settings.strict_normals != 0 && !is_same_side(&point, -ray.direction, wi.z) {
            break;
        }
        let bsdf = Bsdf::at(tables, &point, wi, mode::RADIANCE);
        if bsdf.has_smooth() {
            let counts = SampleCounts {
                emitter: settings.emitter_samples as f32,
                bsdf: settings.bsdf_samples as f32,
            };
            for _ in 0..settings.emitter_samples {
                radiance += transmitted
                    * emitter_sample(
                        view,
                        sampler,
                        &point,
                        &bsdf,
                        wi,
                        settings.strict_normals != 0,
                        counts,
                    );
            }
        }
        for _ in 0..settings.bsdf_samples {
            radiance += transmitted * bsdf_sample(view, settings, sampler, &point, &bsdf, wi);
        }
        // The walk behind a mask is deterministic: what passes is scaled by the null weight.
        transmitted *= bsdf.null_transmittance();
        if transmitted.max_element() <= 0.0 {
            break;
        }
        pass_through(&mut ray, &point);
    }
    radiance
}

/// One of the BSDF samples, divided by their number.
fn bsdf_sample<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: &mut S,
    point: &SurfacePoint,
    bsdf: &Bsdf,
    wi: Vec3,
) -> Rgb {
    let tables = &view.tables;
    let u1 = sampler.next_1d();
    let u2 = sampler.next_2d();
    let sample = bsdf.sample(tables.data, wi, u1, u2);
    if sample.pdf <= 0.0 || sample.event & event::NULL != 0 {
        return Rgb::ZERO;
    }
    let direction = point.frame.to_world(sample.wo).normalize();
    if settings.strict_normals != 0 && !is_same_side(point, direction, sample.wo.z) {
        return Rgb::ZERO;
    }
    let bsdf_count = settings.bsdf_samples as f32;
    let emitter_count = if sample.event & event::DELTA != 0 {
        0.0
    } else {
        settings.emitter_samples as f32
    };
    let mut throughput = sample.weight * (1.0 / bsdf_count);
    let mut ray = point.spawn(direction);
    let mut radiance = Rgb::ZERO;
    let mut crossings = 0;
    while crossings <= MAX_NULL_CROSSINGS {
        crossings += 1;
        let hit = view.traverse.closest_hit(&ray);
        if !hit.is_hit() {
            if tables.info.environment != NONE {
                let other = emitter::pdf_environment(tables, direction);
                radiance += throughput
                    * emitter::environment_radiance(tables, direction)
                    * power_heuristic(bsdf_count * sample.pdf, emitter_count * other);
            }
            break;
        }
        let light = surface_with::<{ detail::TANGENTS }>(tables, &ray, &hit);
        if light.emitter != NONE {
            let emitted = emitter::area_radiance(tables, &light, -direction);
            if emitted.max_element() > 0.0 {
                let other = emitter::pdf_direct(tables, point.position, &light);
                radiance += throughput
                    * emitted
                    * power_heuristic(bsdf_count * sample.pdf, emitter_count * other);
            }
        }
        let behind = Bsdf::at(
            tables,
            &light,
            light.frame.to_local(-direction),
            mode::RADIANCE,
        );
        throughput *= behind.null_transmittance();
        if throughput.max_element() <= 0.0 {
            break;
        }
        pass_through(&mut ray, &light);
    }
    radiance
}
