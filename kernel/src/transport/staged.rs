//! Path tracing and direct illumination in stages, with the state of every path in a buffer between them.
//!
//! A shader that holds a full path is large: compilers of graphics drivers copy every function to its callers, and all
//! scattering models are called from several places. Here each function is one stage of [`super::bounce`] for one path, which
//! a front end runs over all paths before the next (Laine, Karras and Aila 2013, "Megakernels Considered Harmful"). Stages
//! find the surface point and the BSDF again from the hit rather than storing them, and leave paths alone whose step is
//! another's. The record is plain data, laid out for storage buffers with scalar alignment.
//!
//! Invariant (tests): the same numbers, to the bit, as [`super::path::radiance`] and [`super::direct::radiance`].

use super::connection::{
    SampleCounts, ShadowRay, evaluate_light, sample_light, skip_light_numbers,
};
use super::direct;
use super::path::{Path, step};
use super::pixel::camera_ray;
use super::settings::{IntegratorSettings, integrator_kind};
use crate::bsdf::{Bsdf, BsdfSample, mode};
use crate::math::Rgb;
use crate::path::Interaction;
use crate::sampler::{AnySampler, Sampler};
use crate::scene::emitter::DirectSample;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{Hit, SceneView, SurfacePoint, Tables, Traverse};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// A path between two stages.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PathRecord {
    path: Path,
    /// Reconstruction weight of the sample.
    weight: f32,
    /// One of [`step`].
    step: u32,
    hit: Hit,
    sampler: AnySampler,
    light: DirectSample,
    shadow_ray: ShadowRay,
    sample: BsdfSample,
    /// The lobe that it was sampled from.
    lobe: u32,
}

impl PathRecord {
    /// Where the path arrived.
    #[inline]
    fn point(&self, tables: &Tables<'_>) -> SurfacePoint {
        let ray = self.path.subpath.ray;
        surface_with::<{ detail::TANGENTS }>(tables, &ray, &self.hit)
    }

    /// The local direction back along the ray.
    #[inline]
    fn local_direction(&self, point: &SurfacePoint) -> Vec3 {
        let subpath = self.path.subpath;
        subpath.local_direction(point)
    }

    /// The sample's radiance so far, times its reconstruction weight.
    #[inline]
    pub fn estimate(&self) -> Rgb {
        self.path.radiance * self.weight
    }

    /// Whether nothing is left to do.
    #[inline]
    pub fn has_ended(&self) -> bool {
        self.step == step::END
    }
}

/// A path on its ray from the sensor, as [`super::sample_pixel`] chooses it.
#[inline]
pub fn begin(
    tables: &Tables<'_>,
    settings: &IntegratorSettings,
    sampler: AnySampler,
    pixel: [u32; 2],
) -> PathRecord {
    let mut sampler = sampler;
    let sample = camera_ray(tables, &mut sampler, pixel);
    let path = Path::new(&sample.ray);
    // Direct illumination sees emitters whatever its depth.
    let is_direct = settings.kind == integrator_kind::DIRECT;
    PathRecord {
        path,
        weight: sample.weight,
        step: if is_direct || path.subpath.may_continue(&settings.rules) {
            step::TRACE
        } else {
            step::END
        },
        hit: Hit::MISS,
        sampler,
        light: DirectSample::NONE,
        shadow_ray: ShadowRay::NONE,
        sample: BsdfSample::NONE,
        lobe: 0,
    }
}

/// Finds what the path's ray meets.
#[inline]
pub fn trace<T: Traverse>(view: &SceneView<'_, T>, record: &mut PathRecord) {
    if record.step == step::TRACE {
        let ray = record.path.subpath.ray;
        record.hit = view.traverse.closest_hit(&ray);
    }
}

/// Gathers the light at the ray's end, and finds out whether the path scatters there.
#[inline]
pub fn arrive(tables: &Tables<'_>, settings: &IntegratorSettings, record: &mut PathRecord) {
    if record.step != step::TRACE {
        return;
    }
    let mut path = record.path;
    if record.hit.is_hit() {
        record.step = path.arrive(tables, &settings.rules, &record.point(tables));
    } else {
        path.escape(tables, &settings.rules);
        record.step = step::END;
    }
    record.path = path;
}

/// Chooses an emitter point for [`evaluate_emitter`].
#[inline]
pub fn sample_emitter(tables: &Tables<'_>, record: &mut PathRecord) {
    if record.step != step::SCATTER {
        return;
    }
    // The numbers are drawn only where there is something to light, which `evaluate_emitter` finds out.
    let mut sampler = record.sampler;
    record.light = sample_light(tables, &mut sampler, &record.point(tables));
}

/// Makes a shadow ray of the emitter point.
#[inline]
pub fn evaluate_emitter(
    tables: &Tables<'_>,
    settings: &IntegratorSettings,
    record: &mut PathRecord,
) {
    record.shadow_ray = ShadowRay::NONE;
    if record.step != step::SCATTER {
        return;
    }
    let point = record.point(tables);
    let wi = record.local_direction(&point);
    let bsdf = Bsdf::at(tables, &point, wi, mode::RADIANCE);
    if !bsdf.has_smooth() {
        return;
    }
    let mut sampler = record.sampler;
    skip_light_numbers(&mut sampler);
    record.sampler = sampler;
    let counts = if settings.kind == integrator_kind::DIRECT {
        SampleCounts::of(settings)
    } else {
        SampleCounts::ONE
    };
    let path = record.path;
    let light = record.light;
    let at = Interaction::new(&point, &bsdf, path.subpath.ray.direction);
    let mut shadow_ray = evaluate_light(tables, &settings.rules, &light, &at, counts);
    shadow_ray.radiance = path.subpath.throughput * shadow_ray.radiance;
    record.shadow_ray = shadow_ray;
}

/// Adds the light of the emitter point, if it is visible.
#[inline]
pub fn trace_shadow_ray<T: Traverse>(view: &SceneView<'_, T>, record: &mut PathRecord) {
    let shadow_ray = record.shadow_ray;
    if shadow_ray.is_some() {
        let radiance = record.path.radiance + shadow_ray.unshadowed(view);
        record.path.radiance = radiance;
    }
}

/// Samples a direction of one lobe, for [`mix_lobes`].
#[inline]
pub fn sample_bsdf(tables: &Tables<'_>, record: &mut PathRecord) {
    if record.step != step::SCATTER {
        return;
    }
    let point = record.point(tables);
    let wi = record.local_direction(&point);
    let bsdf = Bsdf::at(tables, &point, wi, mode::RADIANCE);
    let mut sampler = record.sampler;
    let u1 = sampler.next_1d();
    let u2 = sampler.next_2d();
    record.sampler = sampler;
    let (sample, lobe) = bsdf.sample_lobe(tables.data, wi, u1, u2);
    record.sample = sample;
    record.lobe = lobe;
}

/// Makes the sample of a lobe that of the whole BSDF, for [`scatter`] and [`branch`].
#[inline]
pub fn mix_lobes(tables: &Tables<'_>, record: &mut PathRecord) {
    if record.step != step::SCATTER {
        return;
    }
    let point = record.point(tables);
    let wi = record.local_direction(&point);
    let bsdf = Bsdf::at(tables, &point, wi, mode::RADIANCE);
    let sample = record.sample;
    record.sample = bsdf.mix(tables.data, wi, sample, record.lobe);
}

/// Leaves the surface along the sampled direction.
#[inline]
pub fn scatter(tables: &Tables<'_>, settings: &IntegratorSettings, record: &mut PathRecord) {
    if record.step != step::SCATTER {
        return;
    }
    let mut path = record.path;
    let mut sampler = record.sampler;
    let sample = record.sample;
    let point = record.point(tables);
    record.step = path.scatter(&settings.rules, &mut sampler, &point, &sample);
    record.sampler = sampler;
    record.path = path;
}

/// Starts one of the BSDF samples of direct illumination as a path of its own.
#[inline]
pub fn branch(
    tables: &Tables<'_>,
    settings: &IntegratorSettings,
    record: &PathRecord,
    branch: &mut PathRecord,
) {
    branch.step = step::END;
    if record.step == step::SCATTER {
        let ray = record.path.subpath.ray;
        let mut path = Path::new(&ray);
        let sample = record.sample;
        let point = record.point(tables);
        let counts = SampleCounts::of(settings);
        branch.step = direct::start_branch(&mut path, &settings.rules, counts, &point, &sample);
        branch.path = path;
    }
}

/// Gathers the light at the end of a branch's edge for the path that it belongs to, once there is no more.
#[inline]
pub fn follow_branch(
    tables: &Tables<'_>,
    settings: &IntegratorSettings,
    record: &mut PathRecord,
    branch: &mut PathRecord,
) {
    if branch.step != step::TRACE {
        return;
    }
    let mut path = branch.path;
    branch.step = if branch.hit.is_hit() {
        direct::follow_branch(&mut path, tables, &branch.point(tables))
    } else {
        path.escape(tables, &settings.rules);
        step::END
    };
    branch.path = path;
    if branch.step == step::END {
        let throughput = record.path.subpath.throughput;
        let radiance = record.path.radiance + throughput * path.radiance;
        record.path.radiance = radiance;
    }
}

/// Goes on behind the masks of the surface, once all samples of direct illumination are taken there.
#[inline]
pub fn continue_through_masks(tables: &Tables<'_>, record: &mut PathRecord) {
    if record.step != step::SCATTER {
        return;
    }
    let mut subpath = record.path.subpath;
    let point = record.point(tables);
    record.step = subpath.continue_through_masks(tables, &point);
    record.path.subpath = subpath;
}
