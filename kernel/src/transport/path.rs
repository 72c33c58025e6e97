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
//! The walk is written as steps of a [`Path`], which [`radiance`] calls in a loop and [`super::staged`] one by one with
//! the path in a buffer.
//! Invariant (tests): the mean does not depend on `rr_depth`, on the sampler or on which of the two techniques is used.

use super::connection::{Connection, SampleCounts, connect, power_heuristic};
use super::settings::IntegratorSettings;
use crate::bsdf::{Bsdf, BsdfSample, event, mode, null_transmittance};
use crate::math::{Ray, Rgb};
pub use crate::path::rules::step;
use crate::path::rules::{MAX_SURVIVAL, is_same_side};
use crate::path::visibility::{MAX_NULL_CROSSINGS, has_masks, pass_through, transmittance};
use crate::sampler::Sampler;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{Hit, NONE, SceneView, SurfacePoint, Tables, Traverse, emitter};
use glam::Vec3;

/// Where a walk scattered last, for the weight of emission that it meets.
#[derive(Clone, Copy, Debug)]
pub struct Scattering {
    /// The point.
    pub position: Vec3,
    /// Density of the direction taken, times the number of such samples.
    pub pdf: f32,
    /// Number of emitter samples that compete with it; zero at the sensor and for a delta lobe.
    pub light_samples: f32,
}

impl Scattering {
    /// Weight of light that the walk found itself and that an emitter sample finds with density `other`.
    #[inline]
    fn weight(&self, other: f32) -> f32 {
        power_heuristic(self.pdf, self.light_samples * other)
    }
}

/// A random walk from the sensor and what it has gathered.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// The ray that is followed next.
    pub ray: Ray,
    /// Light gathered.
    pub radiance: Rgb,
    /// Radiance along the first ray per radiance along this one.
    pub throughput: Rgb,
    /// Product of relative indices along the path.
    pub eta: f32,
    /// Where it scattered last.
    pub last: Scattering,
    /// Edges between scatterings so far.
    pub depth: u32,
    /// Masks and hidden emitters passed.
    pub crossings: u32,
}

impl Path {
    /// A path that has not left the sensor.
    #[inline]
    pub fn new(ray: &Ray) -> Path {
        Path {
            ray: *ray,
            radiance: Rgb::ZERO,
            throughput: Rgb::ONE,
            eta: 1.0,
            last: Scattering {
                position: ray.origin,
                pdf: 0.0,
                light_samples: 0.0,
            },
            depth: 0,
            crossings: 0,
        }
    }

    /// Whether another edge is allowed.
    #[inline]
    pub fn may_continue(&self, settings: &IntegratorSettings) -> bool {
        self.depth < settings.max_depth
    }

    #[inline]
    pub(super) fn sees_emitters(&self, settings: &IntegratorSettings) -> bool {
        self.depth > 0 || settings.hide_emitters == 0
    }

    /// Gathers the light from infinity where the ray met nothing; the path ends.
    #[inline]
    pub fn escape(&mut self, tables: &Tables<'_>, settings: &IntegratorSettings) {
        if self.sees_emitters(settings) && tables.info.environment != NONE {
            let (emitted, pdf) = emitter::environment_radiance_and_pdf(tables, self.ray.direction);
            self.add_weighted(emitted, pdf);
        }
    }

    /// Gathers light that the walk found and that an emitter sample finds with density `other`.
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn add_weighted(&mut self, emitted: Rgb, other: f32) {
        let weight = if self.last.light_samples > 0.0 {
            self.last.weight(other)
        } else {
            1.0
        };
        self.radiance += self.throughput * emitted * weight;
    }

    /// Gathers what the surface at the ray's end emits; says what is next, one of [`step`].
    #[inline]
    pub fn arrive(
        &mut self,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        point: &SurfacePoint,
    ) -> u32 {
        if point.emitter != NONE {
            if !self.sees_emitters(settings) {
                return self.skip_surface(point);
            }
            self.add_emission(tables, point);
        }
        if self.depth + 1 >= settings.max_depth {
            // Masks are not counted: what shines behind one is on this last edge still.
            return if has_masks(tables, point) {
                self.continue_through_masks(tables, point)
            } else {
                step::END
            };
        }
        let wi = self.local_direction(point);
        if settings.strict_normals != 0 && !is_same_side(point, -self.ray.direction, wi.z) {
            return step::END;
        }
        step::SCATTER
    }

    /// Adds what the surface emits back along the ray.
    #[inline]
    pub fn add_emission(&mut self, tables: &Tables<'_>, point: &SurfacePoint) {
        let emitted = emitter::area_radiance(tables, point, -self.ray.direction);
        if emitted.max_element() > 0.0 {
            let other = if self.last.light_samples > 0.0 {
                emitter::pdf_direct(tables, self.last.position, point)
            } else {
                0.0
            };
            self.add_weighted(emitted, other);
        }
    }

    /// The direction back along the ray, in the frame of the point where it arrived.
    #[inline]
    pub fn local_direction(&self, point: &SurfacePoint) -> Vec3 {
        point.frame.to_local(-self.ray.direction)
    }

    /// Goes straight on behind the surface with what its masks let pass; says what is next, one of [`step`].
    #[inline]
    pub fn continue_through_masks(&mut self, tables: &Tables<'_>, point: &SurfacePoint) -> u32 {
        self.throughput *= null_transmittance(tables, point);
        if self.throughput.max_element() <= 0.0 {
            return step::END;
        }
        self.skip_surface(point)
    }

    /// Goes straight on through the surface.
    #[inline]
    fn skip_surface(&mut self, point: &SurfacePoint) -> u32 {
        self.crossings += 1;
        if self.crossings > MAX_NULL_CROSSINGS {
            return step::END;
        }
        pass_through(&mut self.ray, point);
        step::TRACE
    }

    /// Leaves the surface along a direction that the BSDF samples; says whether the path goes on, one of [`step`].
    #[inline]
    pub fn scatter<S: Sampler>(
        &mut self,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        sampler: &mut S,
        point: &SurfacePoint,
        bsdf: &Bsdf,
        wi: Vec3,
    ) -> u32 {
        let u1 = sampler.next_1d();
        let u2 = sampler.next_2d();
        let sample = bsdf.sample(tables.data, wi, u1, u2);
        self.scatter_along(settings, sampler, point, &sample)
    }

    /// Leaves the surface along a sampled direction; says whether the path goes on, one of [`step`].
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn scatter_along<S: Sampler>(
        &mut self,
        settings: &IntegratorSettings,
        sampler: &mut S,
        point: &SurfacePoint,
        sample: &BsdfSample,
    ) -> u32 {
        if sample.pdf <= 0.0 {
            return step::END;
        }
        self.throughput *= sample.weight;
        if self.throughput.max_element() <= 0.0 {
            return step::END;
        }
        if sample.event & event::NULL != 0 {
            return self.skip_surface(point);
        }
        let direction = point.frame.to_world(sample.wo).normalize();
        if settings.strict_normals != 0 && !is_same_side(point, direction, sample.wo.z) {
            return step::END;
        }
        self.last = Scattering {
            position: point.position,
            pdf: sample.pdf,
            light_samples: if sample.event & event::DELTA != 0 {
                0.0
            } else {
                1.0
            },
        };
        self.eta *= sample.eta;
        self.depth += 1;

        if self.depth >= settings.rr_depth {
            let survival = (self.throughput.max_element() * self.eta * self.eta).min(MAX_SURVIVAL);
            if sampler.next_1d() >= survival {
                return step::END;
            }
            self.throughput /= survival;
        }
        self.ray = point.spawn(direction);
        step::TRACE
    }
}

/// A shadow ray: the contribution of an emitter sample to a path, which counts if the ray is not occluded.
#[derive(Clone, Copy, Debug)]
pub struct ShadowRay {
    /// The light that the surface reflects, and the segment to the emitter.
    pub connection: Connection,
    /// The path's throughput at the surface.
    pub throughput: Rgb,
}

impl ShadowRay {
    /// No light.
    pub const NONE: ShadowRay = ShadowRay {
        connection: Connection::NONE,
        throughput: Rgb::ZERO,
    };

    /// The contribution that is not occluded.
    #[inline]
    pub fn unshadowed<T: Traverse>(&self, view: &SceneView<'_, T>) -> Rgb {
        let Connection { radiance, ray } = self.connection;
        // In this order: wavefronts store the first product only.
        self.throughput * radiance * transmittance(view, ray)
    }
}

impl Path {
    /// One bounce, from what the path's ray meets to its next ray: gathers emission, samples an emitter into `light`, and
    /// scatters. Says what is next, [`step::TRACE`] or [`step::END`]. `bsdf` is room for the surface's.
    #[inline]
    pub fn bounce<S: Sampler>(
        &mut self,
        tables: &Tables<'_>,
        settings: &IntegratorSettings,
        sampler: &mut S,
        hit: &Hit,
        bsdf: &mut Bsdf,
        light: &mut ShadowRay,
    ) -> u32 {
        light.connection.radiance = Rgb::ZERO;
        if !hit.is_hit() {
            self.escape(tables, settings);
            return step::END;
        }
        let point = surface_with::<{ detail::TANGENTS }>(tables, &self.ray, hit);
        let next = self.arrive(tables, settings, &point);
        if next != step::SCATTER {
            return next;
        }
        let wi = self.local_direction(&point);
        bsdf.look_up(tables, &point, wi, mode::RADIANCE);
        if bsdf.has_smooth() {
            let strict = settings.strict_normals != 0;
            let counts = SampleCounts::ONE;
            *light = ShadowRay {
                connection: connect(tables, sampler, &point, bsdf, wi, strict, counts),
                throughput: self.throughput,
            };
        }
        let next = self.scatter(tables, settings, sampler, &point, bsdf, wi);
        if self.may_continue(settings) {
            next
        } else {
            step::END
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
    let mut path = Path::new(ray);
    let mut bsdf = Bsdf::BLACK;
    let mut light = ShadowRay::NONE;
    let mut continues = path.may_continue(settings);
    while continues {
        let hit = view.traverse.closest_hit(&path.ray);
        let next = path.bounce(&view.tables, settings, sampler, &hit, &mut bsdf, &mut light);
        if light.connection.is_some() {
            path.radiance += light.unshadowed(view);
        }
        continues = next != step::END;
    }
    path.radiance
}
