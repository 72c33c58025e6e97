//! The arrival of a walk at a surface and its departure, the same for all walks that are connected, merged or kept as photons.
//!
//! ```text
//! surface point -> hidden emitter? -> partial sums of the weights -> emission -> depth, masks, strict normals -> BSDF
//! ```
//!
//! What the steps look up lies in a [`ShadingPoint`], which the caller lends: it is large, and every bounce writes it anew.

use super::connection::Connector;
use super::evaluation::Interaction;
use super::rules::step;
use super::shading_point::ShadingPoint;
use super::walk::Walk;
use crate::bsdf::mode;
use crate::math::Rgb;
#[cfg(not(target_arch = "spirv"))]
use crate::regularize::near_specular::is_near_specular;
use crate::sampler::Sampler;
use crate::scene::{Hit, SurfacePoint};
use glam::Vec3;

impl Connector<'_> {
    /// What a walk does where its ray ends: the radiance that a camera walk has met, unweighted by visibility, and what is next,
    /// one of [`step`]. Where that is [`step::SCATTER`], all of `site` has been looked up.
    #[inline]
    pub fn arrive(&self, walk: &mut Walk, hit: &Hit, site: &mut ShadingPoint) -> (Rgb, u32) {
        if !hit.is_hit() {
            return (self.escaped(walk), step::END);
        }
        site.find(self.tables, &walk.subpath.ray, hit);
        if self.is_hidden(walk, &site.point) {
            return (Vec3::ZERO, walk.subpath.skip_surface(&site.point));
        }
        self.arrive_at(walk, site)
    }

    /// [`Connector::arrive`] at the point of `site`, which the walk does not pass as a hidden emitter.
    #[inline]
    pub fn arrive_at(&self, walk: &mut Walk, site: &mut ShadingPoint) -> (Rgb, u32) {
        let tables = self.tables;
        walk.update_weights(tables, &self.rules, &self.strategies, &site.point);
        let found = self.emitted(walk, &site.point);
        let next = walk.subpath.arrive(tables, &self.rules, &site.point);
        if next == step::SCATTER {
            site.look_up(tables, walk.subpath.ray.direction);
            self.sharpen(walk.subpath.ray.direction, site);
        }
        (found, next)
    }

    /// [`Walk::scatter`] at a vertex, with the rules and the heuristic of this connector there; returns what is next, one of
    /// [`step`].
    #[inline]
    pub fn scatter<S: Sampler>(
        &self,
        walk: &mut Walk,
        at: &Interaction<'_>,
        sampler: &mut S,
    ) -> u32 {
        let h = self.heuristic_at(at.point.position);
        walk.scatter(self.tables, &self.rules, h, sampler, at)
    }

    /// Makes lobes of a surface specular whose roughness its regularisation takes for none, where a walk came along `direction`.
    #[inline]
    pub fn sharpen(&self, direction: Vec3, site: &mut ShadingPoint) {
        // Shaders have no regularisation.
        #[cfg(not(target_arch = "spirv"))]
        if self.regularization.half_tangent > 0.0 {
            let wi = site.point.frame.to_local(-direction);
            let data = self.tables.data;
            let regularization = &self.regularization;
            site.bsdf.sharpen(data, wi, |lobe| {
                is_near_specular(lobe, regularization.quantile, regularization.half_tangent)
            });
        }
        #[cfg(target_arch = "spirv")]
        let _ = (direction, site);
    }

    /// Whether a walk from the sensor does not see the surface.
    #[inline]
    pub fn is_hidden(&self, walk: &Walk, point: &SurfacePoint) -> bool {
        walk.mode == mode::RADIANCE && walk.subpath.is_hidden(&self.rules, point)
    }
}
