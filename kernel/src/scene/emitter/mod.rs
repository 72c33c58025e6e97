//! Light sources: choosing one, sampling its direct illumination at a point, and the densities of both.
//!
//! Direct light at a reference point x is estimated by `radiance f cos V / pdf` with a [`DirectSample`]: first one
//! emitter is chosen by the cumulative `selection_cdf` of the table, then a direction towards it. `pdf` is per solid
//! angle at x and includes the probability of the choice; for delta lights (point, spot, projector, directional) it is
//! that probability alone, and `radiance` holds the light's irradiance on a surface that faces it.
//!
//! - [`area`]: emission of shapes, one-sided;
//! - [`environment`]: light from infinity in all directions;
//! - [`delta`]: light from one point or one direction;
//! - [`position`], [`emission`]: points of emitters and rays that leave them.
//!
//! Invariants (tests): for every kind the density integrates to one over the directions in which it can sample, equals
//! the density that [`pdf_direct`] or [`pdf_environment`] state for the sampled direction, and the radiance equals the
//! one found by looking in that direction.

pub mod area;
pub mod delta;
mod direct_sample;
pub mod emission;
pub mod environment;
pub mod position;
mod sphere;

pub use area::{area_radiance, pdf_direct};
#[cfg(not(target_arch = "spirv"))]
pub(crate) use area::{on_sphere, on_triangle};
pub use direct_sample::DirectSample;
pub use environment::{
    environment_radiance, environment_radiance_and_pdf, environment_table_size,
    environment_table_words, pdf_environment,
};
#[cfg(not(target_arch = "spirv"))]
pub use {
    area::fill_shape_areas,
    environment::fill_environment_distribution,
    host::{fill_selection, power},
};

use super::features;
use super::records::*;
use super::surface::SurfacePoint;
use super::view::Tables;
use glam::{Vec2, Vec3};

/// Chooses an emitter with `u` in [0, 1); [`NONE`] in a scene without light.
#[inline]
pub fn select_emitter(tables: &Tables<'_>, u: f32) -> u32 {
    let count = tables.emitters.len() as u32;
    if count == 0 {
        return NONE;
    }
    // The first emitter whose cumulative probability is above u.
    let mut low = 0;
    let mut high = count - 1;
    while low < high {
        let middle = (low + high) / 2;
        if tables.emitters[middle as usize].selection_cdf > u {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    if tables.emitters[low as usize].selection_pdf > 0.0 {
        low
    } else {
        NONE
    }
}

/// Samples the light that arrives at `reference` without obstacles, `u_select` choosing the emitter and `u` the
/// direction.
pub fn sample_direct(tables: &Tables<'_>, reference: Vec3, u_select: f32, u: Vec2) -> DirectSample {
    let emitter = select_emitter(tables, u_select);
    if emitter == NONE {
        return DirectSample::NONE;
    }
    let mut sample = sample_emitter(tables, emitter, reference, u);
    sample.pdf *= tables.emitters[emitter as usize].selection_pdf;
    sample
}

/// [`sample_direct`], and the sampled point of an area light (undefined for other emitters).
pub fn sample_direct_with_point(
    tables: &Tables<'_>,
    reference: Vec3,
    u_select: f32,
    u: Vec2,
) -> (DirectSample, SurfacePoint) {
    let emitter = select_emitter(tables, u_select);
    if emitter == NONE {
        return (DirectSample::NONE, SurfacePoint::ZERO);
    }
    let record = &tables.emitters[emitter as usize];
    let is_area = tables.has(features::AREA_LIGHTS) && record.kind == emitter_kind::AREA;
    let (mut sample, point) = if is_area {
        area::sample_with_point(tables, emitter, reference, u)
    } else {
        let sample = sample_emitter(tables, emitter, reference, u);
        (sample, SurfacePoint::ZERO)
    };
    sample.pdf *= record.selection_pdf;
    (sample, point)
}

/// The density of [`sample_direct`] for a given emitter, as [`DirectSample::pdf`] states it: per solid angle at `reference`
/// for the `point` of an area light or for the `direction` in which light from infinity travels, the probability of the
/// choice for delta lights, zero for a collimated beam.
pub fn pdf_direct_of(
    tables: &Tables<'_>,
    emitter: u32,
    reference: Vec3,
    point: &SurfacePoint,
    direction: Vec3,
) -> f32 {
    let record = &tables.emitters[emitter as usize];
    if record.kind == emitter_kind::AREA {
        pdf_direct(tables, reference, point)
    } else if record.kind == emitter_kind::CONSTANT || record.kind == emitter_kind::ENVIRONMENT {
        environment::pdf(tables, emitter, -direction) * record.selection_pdf
    } else if record.kind == emitter_kind::COLLIMATED {
        0.0
    } else {
        record.selection_pdf
    }
}

/// Samples the light of one emitter; `pdf` does not hold the probability of choosing it.
pub fn sample_emitter(tables: &Tables<'_>, emitter: u32, reference: Vec3, u: Vec2) -> DirectSample {
    let kind = tables.emitters[emitter as usize].kind;
    if tables.has(features::AREA_LIGHTS) && kind == emitter_kind::AREA {
        area::sample(tables, emitter, reference, u)
    } else if tables.has(features::ENVIRONMENT)
        && (kind == emitter_kind::CONSTANT || kind == emitter_kind::ENVIRONMENT)
    {
        environment::sample(tables, emitter, u)
    } else if tables.has(features::DELTA_LIGHTS) {
        delta::sample(tables, emitter, reference)
    } else {
        DirectSample::NONE
    }
}

/// Facts that are computed once per scene, on the host: they visit whole tables and sum in `f64`.
#[cfg(not(target_arch = "spirv"))]
mod host {
    use super::super::records::*;
    use super::super::view::Tables;
    use super::{area, delta, environment};

    /// An estimate of the emitted power by luminance in W, for [`fill_selection`]. Light from infinity counts by what
    /// enters the scene's bounding sphere.
    pub fn power(tables: &Tables<'_>, emitter: u32) -> f32 {
        let emitter = &tables.emitters[emitter as usize];
        let power = match emitter.kind {
            emitter_kind::AREA => area::power(tables, emitter),
            emitter_kind::CONSTANT | emitter_kind::ENVIRONMENT => {
                environment::power(tables, emitter)
            }
            _ => delta::power(tables, emitter),
        };
        if power > 0.0 {
            (power as f32).min(f32::MAX)
        } else {
            0.0
        }
    }

    /// Sets the selection probabilities of all emitters: half of the choices by power, half evenly among the emitters
    /// that have any, because a weak light nearby matters more than its power says.
    pub fn fill_selection(emitters: &mut [Emitter], powers: &[f32]) {
        let count = emitters.len();
        let total: f64 = powers.iter().map(|p| f64::from(*p)).sum();
        let lit = powers.iter().filter(|p| **p > 0.0).count();
        let weight = |power: f32| {
            if power > 0.0 {
                (0.5 * f64::from(power) / total + 0.5 / lit as f64) as f32
            } else {
                0.0
            }
        };
        for (emitter, power) in emitters.iter_mut().zip(powers) {
            emitter.selection_pdf = weight(*power);
        }
        // Normalised as any cumulative table (see `fill_cdf`), but inside the records; the probabilities are the
        // differences of what is stored.
        let last = powers.iter().rposition(|p| *p > 0.0).unwrap_or(count);
        let total: f64 = emitters.iter().map(|e| f64::from(e.selection_pdf)).sum();
        let mut sum = 0.0;
        let mut previous = 0.0;
        for (i, emitter) in emitters.iter_mut().enumerate() {
            sum += f64::from(emitter.selection_pdf);
            let cdf = if i >= last {
                1.0
            } else {
                (sum / total.max(f64::MIN_POSITIVE)) as f32
            };
            emitter.selection_cdf = cdf;
            emitter.selection_pdf = cdf - previous;
            previous = cdf;
        }
    }
}
