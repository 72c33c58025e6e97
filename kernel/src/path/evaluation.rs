//! What a surface scatters between two directions, and the densities of walks both ways.
//!
//! All algorithms evaluate one function: f(wc, wl) |cos wl|, with wc the direction along which a camera walk would have
//! arrived and wl that in which it would leave, towards the light. A light walk arrives from wl and leaves along wc; what it
//! carries on is the same number times the ratio of geometric cosines |wc.n_g| / |wl.n_g|, which together with the cosine of
//! the shading normal in the number is the adjoint correction |wi.n_s| |wo.n_g| / (|wi.n_g| |wo.n_s|) of Veach (1997,
//! equation 5.19) on top of the cosine with wc, under normal and bump maps and coats too. Nothing depends on the direction
//! of transport but this ratio, so strategies agree on the value of a path to rounding, whether a model is exactly
//! reciprocal or not.
//!
//! Invariant (tests): both modes give the same value for exchanged directions but for that ratio, and the densities
//! exchanged.

use super::rules::PathRules;
use crate::bsdf::{Bsdf, mode};
use crate::math::{Rgb, float};
use crate::scene::{SurfacePoint, Tables};
use glam::Vec3;

/// Value and densities between two directions.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation {
    /// f times the cosine, on light walks with the ratio of geometric cosines.
    pub value: Rgb,
    /// Density per solid angle of going on along the new direction.
    pub pdf: f32,
    /// Density per solid angle of the way back: of the direction from which the walk arrived, had it come along the new one.
    pub pdf_reverse: f32,
}

impl Evaluation {
    /// Nothing is scattered.
    pub const NONE: Evaluation = Evaluation {
        value: Vec3::ZERO,
        pdf: 0.0,
        pdf_reverse: 0.0,
    };

    /// Whether anything is scattered.
    #[inline]
    pub fn is_some(&self) -> bool {
        self.value.max_element() > 0.0
    }
}

/// Where a walk stands: a surface point, its material looked up in the mode of radiance, and the local direction from which
/// the walk arrived.
#[derive(Clone, Copy)]
pub struct Interaction<'a> {
    /// The point.
    pub point: &'a SurfacePoint,
    /// The material.
    pub bsdf: &'a Bsdf,
    /// Back along the walk, local.
    pub wi: Vec3,
    /// |cos| of that direction with the geometric normal.
    pub cosine: f32,
}

impl<'a> Interaction<'a> {
    /// At a point that a ray reached in the world `direction`; the material must have been looked up for it.
    #[inline]
    pub fn new(point: &'a SurfacePoint, bsdf: &'a Bsdf, direction: Vec3) -> Interaction<'a> {
        Interaction {
            point,
            bsdf,
            wi: point.frame.to_local(-direction),
            cosine: float::abs(point.geometric_normal.dot(direction)),
        }
    }

    /// What a walk of `transport_mode` (one of [`mode`]) carries on along the unit world `direction`.
    pub fn evaluate(
        &self,
        tables: &Tables<'_>,
        rules: &PathRules,
        transport_mode: u32,
        direction: Vec3,
    ) -> Evaluation {
        let (point, wi) = (self.point, self.wi);
        let wo = point.frame.to_local(direction);
        if !rules.allows(point, direction, wo.z) {
            return Evaluation::NONE;
        }
        let is_light_walk = transport_mode == mode::IMPORTANCE;
        let both = self
            .bsdf
            .eval_cosine_pdf_both(tables, point, wi, wo, is_light_walk);
        if both.value.max_element() <= 0.0 {
            return Evaluation::NONE;
        }
        let ratio = if is_light_walk {
            self.adjoint_ratio(direction)
        } else {
            1.0
        };
        Evaluation {
            value: both.value * ratio,
            pdf: both.pdf,
            pdf_reverse: both.pdf_reverse,
        }
    }

    /// The shading normal on the side from which the walk came, where nothing passes the surface; zero where something may.
    /// Nothing is scattered along directions that turn away from it.
    #[inline]
    pub fn facing(&self) -> Vec3 {
        if !self.bsdf.is_opaque() {
            Vec3::ZERO
        } else if self.wi.z > 0.0 {
            self.point.frame.n
        } else {
            -self.point.frame.n
        }
    }

    /// |wo.n_g| / |wi.n_g|, zero where the walk arrived along the surface.
    #[inline]
    pub fn adjoint_ratio(&self, direction: Vec3) -> f32 {
        if !(self.cosine > 0.0) {
            return 0.0;
        }
        float::abs(self.point.geometric_normal.dot(direction)) / self.cosine
    }
}
