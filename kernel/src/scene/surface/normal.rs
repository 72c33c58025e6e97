//! Unit normals and their derivatives.

use crate::math::float::{is_finite, sqrt};
use glam::Vec3;

/// Normalisation N -> n = N / |N| and what it does to derivatives.
#[derive(Clone, Copy)]
pub(super) struct NormalMap {
    /// The unit vector.
    pub n: Vec3,
    /// 1 / |N|, zero where the fallback was taken.
    pub inverse_length: f32,
}

impl NormalMap {
    /// Normalises `v`, or takes the unit `fallback` with zero derivatives when `v` is zero or not finite.
    #[inline]
    pub fn new(v: Vec3, fallback: Vec3) -> NormalMap {
        let l2 = v.length_squared();
        if l2 > 1e-30 && l2 < f32::MAX {
            let inverse_length = 1.0 / sqrt(l2);
            NormalMap {
                n: v * inverse_length,
                inverse_length,
            }
        } else {
            NormalMap {
                n: fallback,
                inverse_length: 0.0,
            }
        }
    }

    /// dn = (dN - n (n . dN)) / |N|.
    #[inline]
    pub fn derivative(&self, dv: Vec3) -> Vec3 {
        let d = (dv - self.n * self.n.dot(dv)) * self.inverse_length;
        if is_finite(d.x) && is_finite(d.y) && is_finite(d.z) {
            d
        } else {
            Vec3::ZERO
        }
    }
}

/// `v` normalised, or the unit `fallback` when `v` is zero or not finite.
#[inline]
pub(super) fn unit_or(v: Vec3, fallback: Vec3) -> Vec3 {
    NormalMap::new(v, fallback).n
}
