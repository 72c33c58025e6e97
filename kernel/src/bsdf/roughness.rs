//! The roughness of the part of a material that is not specular, which decides whether photons are gathered at a point or the camera walk goes on.

use super::{Bsdf, Lobe, lobe};
use crate::math::float::sqrt;
use crate::scene::lobe_kind;

/// Width of the lobe as the roughness of a microfacet model; one for lobes that are about diffuse, zero for discrete ones.
#[inline]
pub fn lobe_roughness(lobe: &Lobe) -> f32 {
    let kind = lobe.kind;
    if lobe::is_delta(kind) {
        return 0.0;
    }
    let is_peaked = kind == lobe_kind::ROUGH_CONDUCTOR
        || kind == lobe_kind::ROUGH_DIELECTRIC
        || kind == lobe_kind::ROUGH_COAT
        || kind == lobe_kind::DIFFRACTING_CONDUCTOR
        || kind == lobe_kind::WARD
        || kind == lobe_kind::SCHLICK_REFLECTION
        || kind == lobe_kind::THIN_TRANSMISSION;
    if is_peaked {
        return lobe.alpha.max_element().min(1.0);
    }
    if kind == lobe_kind::CLEARCOAT {
        return lobe.alpha.x.min(1.0);
    }
    if kind == lobe_kind::PHONG {
        // The exponent of Phong's distribution for a roughness is 2 / alpha^2 - 2.
        return sqrt(2.0 / (lobe.exponent.max(0.0) + 2.0));
    }
    1.0
}

impl Bsdf {
    /// Largest roughness of the lobes, zero where all are discrete.
    #[inline]
    pub fn roughness(&self) -> f32 {
        let mut largest: f32 = 0.0;
        for i in 0..self.lobe_count() {
            largest = largest.max(lobe_roughness(self.lobe_at(i)));
        }
        largest
    }
}
