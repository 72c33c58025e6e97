//! The moving end of a random walk: what walks of all algorithms keep, and the steps that do not depend on what they gather.
//!
//! A walk follows its ray to a surface, where [`Subpath::arrive`] applies the rules ([`super::rules`]); it passes straight
//! through what does not count as a vertex ([`Subpath::skip_surface`], [`Subpath::continue_through_masks`]), or scatters
//! and leaves along a new ray ([`Subpath::continue_along`]). Path tracing adds the radiance that it gathers
//! ([`crate::transport::path::Path`]), subpaths that are connected add what their weights need ([`super::Walk`]).
//!
//! The record is plain data, laid out for storage buffers with scalar alignment: shaders and checkpoints hold it as it is.

use super::rules::{MAX_SURVIVAL, PathRules, step};
use super::visibility::{MAX_NULL_CROSSINGS, has_masks, pass_through};
use crate::bsdf::null_transmittance;
use crate::math::{Ray, Rgb};
use crate::sampler::Sampler;
use crate::scene::{NONE, SurfacePoint, Tables};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;

/// The moving end of a walk.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Subpath {
    /// The ray that is followed next.
    pub ray: Ray,
    /// From the sensor: radiance along the first ray per radiance along this one. From an emitter: what the ray carries.
    pub throughput: Rgb,
    /// Product of relative indices along the walk.
    pub eta: f32,
    /// Where it scattered last, or its start.
    pub position: Vec3,
    /// Edges between scatterings so far.
    pub depth: u32,
    /// Masks and hidden emitters passed.
    pub crossings: u32,
}

impl Subpath {
    /// A walk on its first ray, which carries `throughput`.
    #[inline]
    pub fn new(ray: &Ray, throughput: Rgb) -> Subpath {
        Subpath {
            ray: *ray,
            throughput,
            eta: 1.0,
            position: ray.origin,
            depth: 0,
            crossings: 0,
        }
    }

    /// Whether another edge is allowed.
    #[inline]
    pub fn may_continue(&self, rules: &PathRules) -> bool {
        self.depth < rules.max_depth
    }

    /// Whether a walk from the sensor sees emitters on its present edge.
    #[inline]
    pub fn sees_emitters(&self, rules: &PathRules) -> bool {
        self.depth > 0 || rules.hide_emitters == 0
    }

    /// Whether the surface is an emitter that a walk from the sensor passes as if it were not there.
    #[inline]
    pub fn is_hidden(&self, rules: &PathRules, point: &SurfacePoint) -> bool {
        point.emitter != NONE && !self.sees_emitters(rules)
    }

    /// The direction back along the ray, in the frame of the point where it arrived.
    #[inline]
    pub fn local_direction(&self, point: &SurfacePoint) -> Vec3 {
        point.frame.to_local(-self.ray.direction)
    }

    /// What the walk does at a surface, one of [`step`]: on the last edge, whose vertex can only be seen, it goes on with what
    /// masks let pass, because they do not count as vertices; elsewhere it scatters, unless strict normals forbid.
    #[inline]
    pub fn arrive(&mut self, tables: &Tables<'_>, rules: &PathRules, point: &SurfacePoint) -> u32 {
        if self.depth + 1 >= rules.max_depth {
            return if has_masks(tables, point) {
                self.continue_through_masks(tables, point)
            } else {
                step::END
            };
        }
        let wi = self.local_direction(point);
        if rules.allows(point, -self.ray.direction, wi.z) {
            step::SCATTER
        } else {
            step::END
        }
    }

    /// Goes straight on behind the surface with what its masks let pass; returns what is next, one of [`step`].
    #[inline]
    pub fn continue_through_masks(&mut self, tables: &Tables<'_>, point: &SurfacePoint) -> u32 {
        self.throughput *= null_transmittance(tables, point);
        if self.throughput.max_element() <= 0.0 {
            return step::END;
        }
        self.skip_surface(point)
    }

    /// Goes straight on through the surface; returns what is next, one of [`step`].
    #[inline]
    pub fn skip_surface(&mut self, point: &SurfacePoint) -> u32 {
        self.crossings += 1;
        if self.crossings > MAX_NULL_CROSSINGS {
            return step::END;
        }
        pass_through(&mut self.ray, point);
        step::TRACE
    }

    /// Leaves the surface along the world `direction`; what it carries and its index are those behind the surface already. From
    /// `rr_depth` edges on it goes on with the probability `survival` only. Returns what is next, one of [`step`].
    #[cfg_attr(target_arch = "spirv", inline)]
    #[cfg_attr(not(target_arch = "spirv"), inline(always))]
    pub fn continue_along<S: Sampler>(
        &mut self,
        rules: &PathRules,
        sampler: &mut S,
        point: &SurfacePoint,
        direction: Vec3,
        survival: f32,
    ) -> u32 {
        self.position = point.position;
        self.depth += 1;
        if self.depth >= rules.rr_depth {
            if sampler.next_1d() >= survival {
                return step::END;
            }
            self.throughput /= survival;
        }
        self.ray = point.spawn(direction);
        if self.may_continue(rules) {
            step::TRACE
        } else {
            step::END
        }
    }

    /// The probability with which a walk from the sensor survives ([`super::rules`]).
    #[inline]
    pub fn camera_survival(&self) -> f32 {
        (self.throughput.max_element() * self.eta * self.eta).min(MAX_SURVIVAL)
    }

    /// The probability with which a walk from an emitter survives, which began with `initial` as its largest channel.
    #[inline]
    pub fn light_survival(&self, initial: f32) -> f32 {
        (self.throughput.max_element() / initial).min(MAX_SURVIVAL)
    }
}
