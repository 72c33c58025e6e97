//! Unidirectional path tracing with next event estimation.
//!
//! The rendering equation's Neumann series, estimated by a random walk from the sensor (Kajiya 1986). At every vertex
//! with a smooth lobe one emitter point is sampled; light found by the walk itself and light found by that sample are
//! combined with the power heuristic (Veach 1997, Section 9.2.3):
//!
//! ```text
//! L = sum_k beta_k [ w_b Le(x_k) + w_e f(x_k) cos Le / p_e ],   w_a = p_a^2 / (p_a^2 + p_b^2)
//! ```
//!
//! Densities are per solid angle at the vertex that scatters. Straight passage through a mask (a null event) leaves the
//! vertex of reference, its density and the depth as they are. Paths end at `max_depth` edges, and at random from
//! `rr_depth` edges on with survival min(max(beta) eta^2, 0.95), where eta^2 undoes the scaling of refracted radiance.
//! Invariant (tests): the mean does not depend on `rr_depth`, on the sampler or on which of the two techniques is used.

use super::IntegratorSettings;
use super::visibility::{MAX_NULL_CROSSINGS, pass_through, transmittance};
use crate::bsdf::{Bsdf, event, mode};
use crate::math::{Ray, Rgb};
use crate::sampler::Sampler;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{NONE, SceneView, SurfacePoint, Traverse, emitter};
use glam::Vec3;

/// Highest probability of survival, so that a lossless chain ends too.
const MAX_SURVIVAL: f32 = 0.95;

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

/// Where the walk scattered last, for the weight of emission that it meets.
#[derive(Clone, Copy)]
struct Scattering {
    position: Vec3,
    pdf: f32,
    /// No emitter sample competes: sensor, or a delta lobe.
    alone: bool,
}

/// Radiance along `ray`, one sample.
pub fn radiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: &mut S,
    ray: &Ray,
) -> Rgb {
    let tables = &view.tables;
    let mut ray = *ray;
    let mut radiance = Rgb::ZERO;
    let mut throughput = Rgb::ONE;
    // Product of relative indices along the path.
    let mut eta = 1.0;
    let mut last = Scattering {
        position: ray.origin,
        pdf: 0.0,
        alone: true,
    };
    let mut bsdf = Bsdf::BLACK;
    let mut depth = 0;
    let mut crossings = 0;

    while depth < settings.max_depth {
        let hit = view.traverse.closest_hit(&ray);
        let visible = depth > 0 || settings.hide_emitters == 0;
        if !hit.is_hit() {
            if visible && tables.info.environment != NONE {
                let (emitted, pdf) = emitter::environment_radiance_and_pdf(tables, ray.direction);
                let weight = if last.alone {
                    1.0
                } else {
                    power_heuristic(last.pdf, pdf)
                };
                radiance += throughput * emitted * weight;
            }
            break;
        }
        let point = surface_with::<{ detail::TANGENTS }>(tables, &ray, &hit);
        if point.emitter != NONE {
            if !visible {
                crossings += 1;
                if crossings > MAX_NULL_CROSSINGS {
                    break;
                }
                pass_through(&mut ray, &point);
                continue;
            }
            let emitted = emitter::area_radiance(tables, &point, -ray.direction);
            if emitted.max_element() > 0.0 {
                let weight = if last.alone {
                    1.0
                } else {
                    power_heuristic(last.pdf, emitter::pdf_direct(tables, last.position, &point))
                };
                radiance += throughput * emitted * weight;
            }
        }
        if depth + 1 >= settings.max_depth {
            break;
        }

        let wi = point.frame.to_local(-ray.direction);
        if settings.strict_normals != 0 && !is_same_side(&point, -ray.direction, wi.z) {
            break;
        }
        bsdf.look_up(tables, &point, wi, mode::RADIANCE);
        if bsdf.has_smooth() {
            radiance += throughput
                * emitter_sample(
                    view,
                    sampler,
                    &point,
                    &bsdf,
                    wi,
                    settings.strict_normals != 0,
                    SampleCounts {
                        emitter: 1.0,
                        bsdf: 1.0,
                    },
                );
        }

        let u1 = sampler.next_1d();
        let u2 = sampler.next_2d();
        let sample = bsdf.sample(tables.data, wi, u1, u2);
        if sample.pdf <= 0.0 {
            break;
        }
        throughput *= sample.weight;
        if throughput.max_element() <= 0.0 {
            break;
        }
        if sample.event & event::NULL != 0 {
            crossings += 1;
            if crossings > MAX_NULL_CROSSINGS {
                break;
            }
            pass_through(&mut ray, &point);
            continue;
        }
        let direction = point.frame.to_world(sample.wo).normalize();
        if settings.strict_normals != 0 && !is_same_side(&point, direction, sample.wo.z) {
            break;
        }
        last = Scattering {
            position: point.position,
            pdf: sample.pdf,
            alone: sample.event & event::DELTA != 0,
        };
        eta *= sample.eta;
        depth += 1;

        if depth >= settings.rr_depth {
            let survival = (throughput.max_element() * eta * eta).min(MAX_SURVIVAL);
            if sampler.next_1d() >= survival {
                break;
            }
            throughput /= survival;
        }
        ray = point.spawn(direction);
    }
    radiance
}

/// Light of one emitter point reflected towards `wi`, one of `emitter_count` samples that compete with `bsdf_count`
/// samples of the BSDF, divided by their number.
pub(super) fn emitter_sample<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    sampler: &mut S,
    point: &SurfacePoint,
    bsdf: &Bsdf,
    wi: Vec3,
    strict_normals: bool,
    counts: SampleCounts,
) -> Rgb {
    let tables = &view.tables;
    let u_select = sampler.next_1d();
    let u = sampler.next_2d();
    let light = emitter::sample_direct(tables, point.position, u_select, u);
    if light.pdf <= 0.0 || light.radiance.max_element() <= 0.0 {
        return Rgb::ZERO;
    }
    let wo = point.frame.to_local(light.direction);
    if strict_normals && !is_same_side(point, light.direction, wo.z) {
        return Rgb::ZERO;
    }
    let (value, pdf) = bsdf.eval_cosine_pdf(tables.data, wi, wo);
    if value.max_element() <= 0.0 {
        return Rgb::ZERO;
    }
    let weight = if light.is_delta {
        1.0
    } else {
        power_heuristic(counts.emitter * light.pdf, counts.bsdf * pdf)
    };
    value
        * light.radiance
        * (weight / (light.pdf * counts.emitter))
        * transmittance(view, point, &light)
}

/// How many samples of each technique a vertex takes.
#[derive(Clone, Copy)]
pub(super) struct SampleCounts {
    pub emitter: f32,
    pub bsdf: f32,
}

/// Whether a direction with local cosine `cos_theta` is on the same side of both normals.
#[inline]
pub(super) fn is_same_side(point: &SurfacePoint, direction: Vec3, cos_theta: f32) -> bool {
    point.geometric_normal.dot(direction) * cos_theta > 0.0
}
