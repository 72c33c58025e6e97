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
//! vertex of reference, its density and the depth as they are, on the last edge as on any other. Paths end at `max_depth`
//! edges, and at random from `rr_depth` edges on with survival min(max(beta) eta^2, 0.95), where eta^2 undoes the scaling of refracted radiance.
//!
//! The order of the stages of a bounce is that of [`super::bounce`]; what each computes stands here. [`SinglePath`] runs them
//! for one path; [`super::staged`] keeps paths in buffers between them, the wavefront in lanes.
//! Invariant (tests): the mean does not depend on `rr_depth`, on the sampler or on which of the two techniques is used.

use super::bounce::{Rays, Shading, bounce, shade};
use super::connection::{SampleCounts, ShadowRay, evaluate_light, power_heuristic, sample_light};
use super::settings::IntegratorSettings;
use crate::bsdf::{Bsdf, BsdfSample, event, mode};
use crate::math::{Ray, Rgb};
pub use crate::path::rules::step;
use crate::path::{Interaction, PathRules, Subpath};
use crate::sampler::Sampler;
use crate::scene::emitter::DirectSample;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{Hit, NONE, SceneView, SurfacePoint, Tables, Traverse, emitter};
use bytemuck::{Pod, Zeroable};

/// A random walk from the sensor and what it has gathered.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Path {
    /// Its moving end.
    pub subpath: Subpath,
    /// Light gathered.
    pub radiance: Rgb,
    /// Density of the direction in which it scattered last, times the number of such samples.
    pub last_pdf: f32,
    /// Number of emitter samples that competed with that direction; zero at the sensor and for a delta lobe.
    pub light_samples: f32,
}

impl Path {
    /// A path that has not left the sensor.
    #[inline]
    pub fn new(ray: &Ray) -> Path {
        Path {
            subpath: Subpath::new(ray, Rgb::ONE),
            radiance: Rgb::ZERO,
            last_pdf: 0.0,
            light_samples: 0.0,
        }
    }

    /// Gathers the light from infinity where the ray met nothing; the path ends.
    #[inline]
    pub fn escape(&mut self, tables: &Tables<'_>, rules: &PathRules) {
        if self.subpath.sees_emitters(rules) && tables.info.environment != NONE {
            let direction = self.subpath.ray.direction;
            let (emitted, pdf) = emitter::environment_radiance_and_pdf(tables, direction);
            self.add_weighted(emitted, pdf);
        }
    }

    /// Gathers light that the walk found and that an emitter sample finds with density `other`.
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn add_weighted(&mut self, emitted: Rgb, other: f32) {
        let weight = if self.light_samples > 0.0 {
            power_heuristic(self.last_pdf, self.light_samples * other)
        } else {
            1.0
        };
        self.radiance += self.subpath.throughput * emitted * weight;
    }

    /// Gathers what the surface at the ray's end emits; returns what is next, one of [`step`].
    #[inline]
    pub fn arrive(&mut self, tables: &Tables<'_>, rules: &PathRules, point: &SurfacePoint) -> u32 {
        if self.subpath.is_hidden(rules, point) {
            return self.subpath.skip_surface(point);
        }
        if point.emitter != NONE {
            self.add_emission(tables, point);
        }
        self.subpath.arrive(tables, rules, point)
    }

    /// Adds what the surface emits back along the ray.
    #[inline]
    pub fn add_emission(&mut self, tables: &Tables<'_>, point: &SurfacePoint) {
        let emitted = emitter::area_radiance(tables, point, -self.subpath.ray.direction);
        if emitted.max_element() > 0.0 {
            let other = if self.light_samples > 0.0 {
                emitter::pdf_direct(tables, self.subpath.position, point)
            } else {
                0.0
            };
            self.add_weighted(emitted, other);
        }
    }

    /// Leaves the surface along a sampled direction; returns whether the path goes on, one of [`step`].
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn scatter<S: Sampler>(
        &mut self,
        rules: &PathRules,
        sampler: &mut S,
        point: &SurfacePoint,
        sample: &BsdfSample,
    ) -> u32 {
        if sample.pdf <= 0.0 {
            return step::END;
        }
        let subpath = &mut self.subpath;
        subpath.throughput *= sample.weight;
        if subpath.throughput.max_element() <= 0.0 {
            return step::END;
        }
        if sample.event & event::NULL != 0 {
            return subpath.skip_surface(point);
        }
        let direction = point.frame.to_world(sample.wo).normalize();
        if !rules.allows(point, direction, sample.wo.z) {
            return step::END;
        }
        self.last_pdf = sample.pdf;
        self.light_samples = if sample.event & event::DELTA != 0 {
            0.0
        } else {
            1.0
        };
        subpath.eta *= sample.eta;
        let survival = subpath.camera_survival();
        subpath.continue_along(rules, sampler, point, direction, survival)
    }
}

/// One path and what its stages hand on: the driver of a loop, and of what a wavefront's lanes do not take.
pub struct SinglePath<'a, T: Traverse, S> {
    /// The scene.
    pub view: &'a SceneView<'a, T>,
    /// The rules.
    pub rules: PathRules,
    /// Samples that compete at a surface.
    pub counts: SampleCounts,
    /// The path's random numbers.
    pub sampler: &'a mut S,
    /// Storage for the surface's BSDF.
    pub bsdf: &'a mut Bsdf,
    /// The path.
    pub path: Path,
    /// What its ray met.
    pub hit: Hit,
    /// One of [`step`].
    pub next: u32,
    /// The emitter sample of the last surface.
    pub shadow_ray: ShadowRay,
    pub(super) point: SurfacePoint,
    pub(super) sample: BsdfSample,
    lobe: u32,
    pub(super) light: DirectSample,
}

impl<'a, T: Traverse, S> SinglePath<'a, T, S> {
    /// A path before its next ray is traced.
    #[inline]
    pub fn new(
        view: &'a SceneView<'a, T>,
        rules: PathRules,
        sampler: &'a mut S,
        bsdf: &'a mut Bsdf,
        path: Path,
    ) -> SinglePath<'a, T, S> {
        SinglePath {
            view,
            rules,
            counts: SampleCounts::ONE,
            sampler,
            bsdf,
            next: if path.subpath.may_continue(&rules) {
                step::TRACE
            } else {
                step::END
            },
            path,
            hit: Hit::MISS,
            shadow_ray: ShadowRay::NONE,
            point: SurfacePoint::ZERO,
            sample: BsdfSample::NONE,
            lobe: 0,
            light: DirectSample::NONE,
        }
    }

    #[inline]
    pub(super) fn interaction(&self) -> Interaction<'_> {
        Interaction::new(&self.point, self.bsdf, self.path.subpath.ray.direction)
    }

    #[inline]
    pub(super) fn is_lit(&self) -> bool {
        self.next == step::SCATTER && self.bsdf.has_smooth()
    }
}

impl<T: Traverse, S: Sampler> SinglePath<'_, T, S> {
    #[inline]
    pub(super) fn choose_light(&mut self) {
        self.light = sample_light(&self.view.tables, self.sampler, &self.point);
    }
}

impl<T: Traverse, S: Sampler> Shading for SinglePath<'_, T, S> {
    #[inline]
    fn arrive(&mut self) {
        let tables = &self.view.tables;
        if !self.hit.is_hit() {
            self.path.escape(tables, &self.rules);
            self.next = step::END;
            return;
        }
        let subpath = &self.path.subpath;
        self.point = surface_with::<{ detail::TANGENTS }>(tables, &subpath.ray, &self.hit);
        self.next = self.path.arrive(tables, &self.rules, &self.point);
        if self.next == step::SCATTER {
            let wi = self.path.subpath.local_direction(&self.point);
            self.bsdf.look_up(tables, &self.point, wi, mode::RADIANCE);
        }
    }

    #[inline]
    fn sample_emitter(&mut self) {
        if self.is_lit() {
            self.choose_light();
        }
    }

    #[inline]
    fn evaluate_emitter(&mut self) {
        self.shadow_ray = ShadowRay::NONE;
        if self.is_lit() {
            let tables = &self.view.tables;
            let at = self.interaction();
            self.shadow_ray = evaluate_light(tables, &self.rules, &self.light, &at, self.counts);
            self.shadow_ray.radiance = self.path.subpath.throughput * self.shadow_ray.radiance;
        }
    }

    #[inline]
    fn sample_bsdf(&mut self) {
        if self.next == step::SCATTER {
            let u1 = self.sampler.next_1d();
            let u2 = self.sampler.next_2d();
            let wi = self.path.subpath.local_direction(&self.point);
            let data = self.view.tables.data;
            (self.sample, self.lobe) = self.bsdf.sample_lobe(data, wi, u1, u2);
        }
    }

    #[inline]
    fn mix_lobes(&mut self) {
        if self.next == step::SCATTER {
            let wi = self.path.subpath.local_direction(&self.point);
            let data = self.view.tables.data;
            self.sample = self.bsdf.mix(data, wi, self.sample, self.lobe);
        }
    }

    #[inline]
    fn scatter(&mut self) {
        if self.next == step::SCATTER {
            let (point, sample) = (&self.point, &self.sample);
            self.next = self.path.scatter(&self.rules, self.sampler, point, sample);
        }
    }
}

impl<T: Traverse, S> Rays for SinglePath<'_, T, S> {
    #[inline]
    fn trace(&mut self) {
        self.hit = self.view.traverse.closest_hit(&self.path.subpath.ray);
    }

    #[inline]
    fn trace_shadow_rays(&mut self) {
        if self.shadow_ray.is_some() {
            self.path.radiance += self.shadow_ray.unshadowed(self.view);
        }
    }
}

/// Radiance along `ray`, one sample.
pub fn radiance<T: Traverse, S: Sampler>(
    view: &SceneView<'_, T>,
    settings: &IntegratorSettings,
    sampler: &mut S,
    ray: &Ray,
) -> Rgb {
    let mut bsdf = Bsdf::BLACK;
    let mut driver = SinglePath::new(view, settings.rules, sampler, &mut bsdf, Path::new(ray));
    while driver.next != step::END {
        bounce(&mut driver, shade);
    }
    driver.path.radiance
}
