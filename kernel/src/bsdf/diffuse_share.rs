//! The share of diffuse lobes in what a material scatters.
//!
//! Path expressions tell diffuse from glossy scattering, but a material may do both into the same direction. Its value there
//! is then divided exactly, f = f_D + f_G, so that the parts of an image add up to it. Discrete directions are neither.

use super::{Bsdf, Lobe, lobe, rough_plastic};
use crate::math::Rgb;
use crate::scene::lobe_kind;
use glam::Vec3;

/// Whether lobes of the kind scatter diffusely where they are smooth.
#[inline]
pub fn is_diffuse(kind: u32) -> bool {
    kind == lobe_kind::DIFFUSE
        || kind == lobe_kind::ROUGH_DIFFUSE
        || kind == lobe_kind::DIFFUSE_TRANSMISSION
        || kind == lobe_kind::PRINCIPLED_DIFFUSE
        || kind == lobe_kind::SHEEN
        || kind == lobe_kind::PLASTIC
}

impl Bsdf {
    /// f_D / f per channel, for a pair of directions in the frame of the surface; zero where nothing is scattered.
    pub fn diffuse_share(&self, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
        let (mut some_diffuse, mut some_glossy) = (false, false);
        for i in 0..self.lobe_count() {
            let kind = self.lobe_at(i).kind;
            if kind == lobe_kind::ROUGH_PLASTIC {
                some_diffuse = true;
                some_glossy = true;
            } else if is_diffuse(kind) {
                some_diffuse = true;
            } else if !lobe::is_delta(kind) {
                some_glossy = true;
            }
        }
        if !(some_diffuse && some_glossy) {
            return Vec3::splat(if some_diffuse { 1.0 } else { 0.0 });
        }
        let (mut diffuse, mut all) = (Vec3::ZERO, Vec3::ZERO);
        for i in 0..self.lobe_count() {
            let own = self.lobe_at(i);
            let value = lobe::eval_cosine(own, data, wi, wo) * own.weight;
            all += value;
            if own.kind == lobe_kind::ROUGH_PLASTIC {
                // Its base alone.
                let base = Lobe {
                    specular_reflectance: Vec3::ZERO,
                    ..*own
                };
                diffuse += lobe::eval_cosine(&base, data, wi, wo) * own.weight;
            } else if is_diffuse(own.kind) {
                diffuse += value;
            }
        }
        Vec3::new(
            share(diffuse.x, all.x),
            share(diffuse.y, all.y),
            share(diffuse.z, all.z),
        )
    }
}

/// [`Bsdf::diffuse_share`] of a lobe of rough plastic alone.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn of_rough_plastic(own: &Lobe, data: &[f32], wi: Vec3, wo: Vec3) -> Rgb {
    let (base, coat) = rough_plastic::base_and_coat(own, data, wi, wo);
    let all = base + coat;
    Vec3::new(
        share(base.x, all.x),
        share(base.y, all.y),
        share(base.z, all.z),
    )
}

/// part / all, in [0, 1].
#[inline]
fn share(part: f32, all: f32) -> f32 {
    if all > 0.0 {
        (part / all).min(1.0).max(0.0)
    } else {
        0.0
    }
}
