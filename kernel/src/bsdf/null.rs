//! Null scattering: light continues straight through the surface.
//!
//! f = delta(wo + wi) / |cos|, a single direction with discrete probability one. Masks and index-matched boundaries are
//! mixtures with this lobe. It has no side and no frame: the direction is -wi whatever the shading normal is.

use super::{BsdfSample, Lobe, event};
use crate::math::Rgb;
use glam::{Vec2, Vec3};

/// Zero: a delta distribution has no value.
#[inline]
pub fn eval(_lobe: &Lobe, _wi: Vec3, _wo: Vec3) -> Rgb {
    Vec3::ZERO
}

/// Zero: a delta distribution has no density.
#[inline]
pub fn pdf(_lobe: &Lobe, _wi: Vec3, _wo: Vec3) -> f32 {
    0.0
}

/// The direction straight on.
#[inline]
pub fn sample(_lobe: &Lobe, wi: Vec3, _u1: f32, _u2: Vec2) -> BsdfSample {
    BsdfSample {
        wo: -wi,
        weight: Vec3::ONE,
        pdf: 1.0,
        eta: 1.0,
        event: event::TRANSMISSION | event::DELTA | event::NULL,
    }
}
