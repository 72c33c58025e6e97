//! Path tracing and direct illumination in stages, with the state of every path in a buffer between them.
//!
//! A shader that holds a whole path is large: compilers of graphics drivers copy every function to its callers, and all
//! scattering models are called from several places. Here each stage is one step of [`super::path`] or
//! [`super::direct`] for one path, which a front end runs over all paths before the next (Laine, Karras and Aila 2013,
//! "Megakernels Considered Harmful"). Stages find the surface point and the BSDF again from the hit rather than storing
//! them. A path goes through
//!
//! - path tracing: [`begin`], then [`trace`], [`arrive`], [`light`], [`evaluate`], [`shadow`], [`sample`], [`mix`] and
//!   [`scatter`] until it ends;
//! - direct illumination: [`begin`], then [`trace`], [`arrive`], `emitter_samples` times [`light`], [`evaluate`] and
//!   [`shadow`], `bsdf_samples` times [`sample`], [`mix`] and [`branch`] with [`trace`] and [`follow`] until the branch
//!   ends, and [`continue_through_masks`]; then from [`trace`] on again until it ends.
//!
//! A stage leaves paths alone whose step is another's. Invariant (tests): the same numbers, to the bit, as
//! [`super::path::radiance`] and [`super::direct::radiance`].

use super::connection::{
    Connection, SampleCounts, evaluate_light, sample_light, skip_light_numbers,
};
use super::direct;
use super::path::{Path, Scattering, step};
use super::pixel::camera_ray;
use super::settings::IntegratorSettings;
use super::settings::integrator_kind;
use crate::bsdf::{Bsdf, BsdfSample, mode};
use crate::math::{Ray, Rgb, vec3};
use crate::path::visibility::transmittance;
use crate::sampler::{AnySampler, Sampler};
use crate::scene::emitter::DirectSample;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{Hit, SceneView, SurfacePoint, Tables, Traverse};
use bytemuck::{Pod, Zeroable};

/// A ray as plain numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct RayRecord {
    origin: [f32; 3],
    t_min: f32,
    direction: [f32; 3],
    t_max: f32,
}

impl RayRecord {
    #[inline]
    fn new(ray: &Ray) -> RayRecord {
        RayRecord {
            origin: [ray.origin.x, ray.origin.y, ray.origin.z],
            t_min: ray.t_min,
            direction: [ray.direction.x, ray.direction.y, ray.direction.z],
            t_max: ray.t_max,
        }
    }

    #[inline]
    fn ray(&self) -> Ray {
        Ray {
            origin: vec3(self.origin),
            direction: vec3(self.direction),
            t_min: self.t_min,
            t_max: self.t_max,
        }
    }
}

/// A [`DirectSample`] as plain numbers.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LightRecord {
    direction: [f32; 3],
    distance: f32,
    target: [f32; 3],
    pdf: f32,
    radiance: [f32; 3],
    is_delta: u32,
}

impl LightRecord {
    #[inline]
    fn new(light: &DirectSample) -> LightRecord {
        LightRecord {
            direction: numbers(light.direction),
            distance: light.distance,
            target: numbers(light.target),
            pdf: light.pdf,
            radiance: numbers(light.radiance),
            is_delta: light.is_delta as u32,
        }
    }

    #[inline]
    fn sample(&self) -> DirectSample {
        DirectSample {
            direction: vec3(self.direction),
            distance: self.distance,
            target: vec3(self.target),
            radiance: vec3(self.radiance),
            pdf: self.pdf,
            is_delta: self.is_delta != 0,
            ..DirectSample::NONE
        }
    }
}

/// A path between two stages.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PathRecord {
    ray: RayRecord,
    radiance: [f32; 3],
    eta: f32,
    throughput: [f32; 3],
    /// Reconstruction weight of the sample.
    weight: f32,
    last_position: [f32; 3],
    last_pdf: f32,
    last_light_samples: f32,
    depth: u32,
    crossings: u32,
    /// One of [`step`].
    step: u32,
    hit: Hit,
    sampler: AnySampler,
    light: LightRecord,
    /// The direction that the BSDF sampled, see [`BsdfSample`].
    sample_wo: [f32; 3],
    sample_pdf: f32,
    sample_weight: [f32; 3],
    sample_eta: f32,
    sample_event: u32,
    /// The lobe that it was sampled from.
    sample_lobe: u32,
    /// What the emitter sample adds if it is not occluded.
    connection: [f32; 3],
    connection_ray: RayRecord,
}

impl PathRecord {
    #[inline]
    fn path(&self) -> Path {
        Path {
            ray: self.ray.ray(),
            radiance: vec3(self.radiance),
            throughput: vec3(self.throughput),
            eta: self.eta,
            last: Scattering {
                position: vec3(self.last_position),
                pdf: self.last_pdf,
                light_samples: self.last_light_samples,
            },
            depth: self.depth,
            crossings: self.crossings,
        }
    }

    #[inline]
    fn store(&mut self, path: &Path) {
        self.ray = RayRecord::new(&path.ray);
        self.radiance = numbers(path.radiance);
        self.throughput = numbers(path.throughput);
        self.eta = path.eta;
        self.last_position = numbers(path.last.position);
        self.last_pdf = path.last.pdf;
        self.last_light_samples = path.last.light_samples;
        self.depth = path.depth;
        self.crossings = path.crossings;
    }

    #[inline]
    fn sample(&self) -> BsdfSample {
        BsdfSample {
            wo: vec3(self.sample_wo),
            weight: vec3(self.sample_weight),
            pdf: self.sample_pdf,
            eta: self.sample_eta,
            event: self.sample_event,
        }
    }

    #[inline]
    fn store_sample(&mut self, sample: &BsdfSample) {
        self.sample_wo = numbers(sample.wo);
        self.sample_weight = numbers(sample.weight);
        self.sample_pdf = sample.pdf;
        self.sample_eta = sample.eta;
        self.sample_event = sample.event;
    }

    /// Where the path arrived.
    #[inline]
    fn point(&self, tables: &Tables<'_>) -> SurfacePoint {
        surface_with::<{ detail::TANGENTS }>(tables, &self.ray.ray(), &self.hit)
    }

    /// The sample's radiance so far, times its reconstruction weight.
    #[inline]
    pub fn estimate(&self) -> Rgb {
        vec3(self.radiance) * self.weight
    }

    /// Whether nothing is left to do.
    #[inline]
    pub fn has_ended(&self) -> bool {
        self.step == step::END
    }
}

#[inline]
fn numbers(v: Rgb) -> [f32; 3] {
    [v.x, v.y, v.z]
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
    let ray = RayRecord::new(&sample.ray);
    let mut record = PathRecord {
        ray,
        radiance: [0.0; 3],
        eta: 1.0,
        throughput: [0.0; 3],
        weight: sample.weight,
        last_position: [0.0; 3],
        last_pdf: 0.0,
        last_light_samples: 0.0,
        depth: 0,
        crossings: 0,
        step: if may_begin(settings, &path) {
            step::TRACE
        } else {
            step::END
        },
        hit: Hit::MISS,
        sampler,
        light: LightRecord::new(&DirectSample::NONE),
        sample_wo: [0.0; 3],
        sample_pdf: 0.0,
        sample_weight: [0.0; 3],
        sample_eta: 1.0,
        sample_event: 0,
        sample_lobe: 0,
        connection: [0.0; 3],
        connection_ray: ray,
    };
    record.store(&path);
    record
}

/// Direct illumination sees emitters whatever its depth.
#[inline]
fn may_begin(settings: &IntegratorSettings, path: &Path) -> bool {
    settings.kind == integrator_kind::DIRECT || path.may_continue(settings)
}

/// Finds what the path's ray meets.
#[inline]
pub fn trace<T: Traverse>(view: &SceneView<'_, T>, record: &mut PathRecord) {
    if record.step == step::TRACE {
        record.hit = view.traverse.closest_hit(&record.ray.ray());
    }
}

/// Gathers the light at the ray's end, and finds out whether the path scatters there.
#[inline]
pub fn arrive(tables: &Tables<'_>, settings: &IntegratorSettings, record: &mut PathRecord) {
    if record.step != step::TRACE {
        return;
    }
    let mut path = record.path();
    if record.hit.is_hit() {
        record.step = path.arrive(tables, settings, &record.point(tables));
    } else {
        path.escape(tables, settings);
        record.step = step::END;
    }
    record.radiance = numbers(path.radiance);
    // Behind a mask on the last edge less is left.
    record.throughput = numbers(path.throughput);
    record.crossings = path.crossings;
    record.ray = RayRecord::new(&path.ray);
}

/// Chooses an emitter point for [`evaluate`].
#[inline]
pub fn light(tables: &Tables<'_>, record: &mut PathRecord) {
    if record.step != step::SCATTER {
        return;
    }
    // The numbers are drawn only where there is something to light, which `evaluate` finds out.
    let mut sampler = record.sampler;
    let light = sample_light(tables, &mut sampler, &record.point(tables));
    record.light = LightRecord::new(&light);
}

/// How much light of the chosen emitter point the surface reflects, for [`shadow`] to see whether it arrives.
#[inline]
pub fn evaluate(tables: &Tables<'_>, settings: &IntegratorSettings, record: &mut PathRecord) {
    record.connection = [0.0; 3];
    if record.step != step::SCATTER {
        return;
    }
    let point = record.point(tables);
    let wi = record.path().local_direction(&point);
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
    let strict = settings.strict_normals != 0;
    let light = record.light.sample();
    let connection = evaluate_light(tables, &light, &point, &bsdf, wi, strict, counts);
    record.connection = numbers(connection.radiance);
    record.connection_ray = RayRecord::new(&connection.ray);
}

/// Gathers the light of the emitter point that [`light`] chose, if it is visible.
#[inline]
pub fn shadow<T: Traverse>(view: &SceneView<'_, T>, record: &mut PathRecord) {
    let connection = Connection {
        radiance: vec3(record.connection),
        ray: record.connection_ray.ray(),
    };
    if record.step != step::SCATTER || !connection.is_some() {
        return;
    }
    let light = vec3(record.throughput) * connection.radiance;
    let radiance = vec3(record.radiance) + light * transmittance(view, connection.ray);
    record.radiance = numbers(radiance);
}

/// Samples a direction of one lobe, for [`mix`].
#[inline]
pub fn sample(tables: &Tables<'_>, record: &mut PathRecord) {
    if record.step != step::SCATTER {
        return;
    }
    let point = record.point(tables);
    let wi = record.path().local_direction(&point);
    let bsdf = Bsdf::at(tables, &point, wi, mode::RADIANCE);
    let mut sampler = record.sampler;
    let u1 = sampler.next_1d();
    let u2 = sampler.next_2d();
    record.sampler = sampler;
    let (sample, lobe) = bsdf.sample_lobe(tables.data, wi, u1, u2);
    record.store_sample(&sample);
    record.sample_lobe = lobe;
}

/// Makes the sample of a lobe that of the whole BSDF, for [`scatter`] and [`branch`].
#[inline]
pub fn mix(tables: &Tables<'_>, record: &mut PathRecord) {
    if record.step != step::SCATTER {
        return;
    }
    let point = record.point(tables);
    let wi = record.path().local_direction(&point);
    let bsdf = Bsdf::at(tables, &point, wi, mode::RADIANCE);
    let sample = bsdf.mix(tables.data, wi, record.sample(), record.sample_lobe);
    record.store_sample(&sample);
}

/// Leaves the surface along the sampled direction.
#[inline]
pub fn scatter(tables: &Tables<'_>, settings: &IntegratorSettings, record: &mut PathRecord) {
    if record.step != step::SCATTER {
        return;
    }
    let mut path = record.path();
    let mut sampler = record.sampler;
    let point = record.point(tables);
    let next = path.scatter_along(settings, &mut sampler, &point, &record.sample());
    record.step = if path.may_continue(settings) {
        next
    } else {
        step::END
    };
    record.sampler = sampler;
    record.store(&path);
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
        let mut path = Path::new(&record.ray.ray());
        let point = record.point(tables);
        branch.step = direct::start_branch(&mut path, settings, &point, &record.sample());
        branch.store(&path);
    }
}

/// Gathers the light at the end of a branch's edge for the path that it belongs to, once there is no more.
#[inline]
pub fn follow(
    tables: &Tables<'_>,
    settings: &IntegratorSettings,
    record: &mut PathRecord,
    branch: &mut PathRecord,
) {
    if branch.step != step::TRACE {
        return;
    }
    let mut path = branch.path();
    branch.step = if branch.hit.is_hit() {
        direct::follow_branch(&mut path, tables, &branch.point(tables))
    } else {
        path.escape(tables, settings);
        step::END
    };
    branch.store(&path);
    if branch.step == step::END {
        let radiance = vec3(record.radiance) + vec3(record.throughput) * path.radiance;
        record.radiance = numbers(radiance);
    }
}

/// Goes on behind the masks of the surface, once all samples of direct illumination are taken there.
#[inline]
pub fn continue_through_masks(tables: &Tables<'_>, record: &mut PathRecord) {
    if record.step != step::SCATTER {
        return;
    }
    let mut path = record.path();
    let point = record.point(tables);
    record.step = path.continue_through_masks(tables, &point);
    record.store(&path);
}
