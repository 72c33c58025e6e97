//! A surface point with its BSDF: what a walk evaluates and samples where it arrives, and what a stored vertex is turned back into.
//!
//! The record is large, and every bounce writes it anew; algorithms keep one for each end of a path and lend it.

use super::evaluation::Interaction;
use crate::bsdf::{Bsdf, mode};
use crate::math::Ray;
use crate::scene::surface::{detail, surface_with};
use crate::scene::{Hit, SurfacePoint, Tables};
use glam::Vec3;

/// A surface point with its BSDF, for radiance.
#[derive(Clone, Copy)]
pub struct ShadingPoint {
    /// The point.
    pub point: SurfacePoint,
    /// Its BSDF; that of an earlier point as long as it has not been looked up.
    pub bsdf: Bsdf,
}

impl ShadingPoint {
    /// Nothing yet.
    pub const NONE: ShadingPoint = ShadingPoint {
        point: SurfacePoint::ZERO,
        bsdf: Bsdf::BLACK,
    };

    /// The point that `ray` has hit.
    #[inline]
    pub fn find(&mut self, tables: &Tables<'_>, ray: &Ray, hit: &Hit) {
        self.point = surface_with::<{ detail::TANGENTS }>(tables, ray, hit);
    }

    /// The BSDF as a walk along the unit world `direction` meets it.
    #[inline]
    pub fn look_up(&mut self, tables: &Tables<'_>, direction: Vec3) {
        let wi = self.point.frame.to_local(-direction);
        self.bsdf.look_up(tables, &self.point, wi, mode::RADIANCE);
    }

    /// What a walk along the unit world `direction`, for which the BSDF was looked up, evaluates here.
    #[inline]
    pub fn interaction(&self, direction: Vec3) -> Interaction<'_> {
        Interaction::new(&self.point, &self.bsdf, direction)
    }
}
