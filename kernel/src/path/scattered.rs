//! What happens at a vertex, for expressions: a discrete event, or diffuse and glossy scattering by shares.

use super::expression::scattering;
use crate::bsdf::{Bsdf, diffuse_share, event, lobe};
use crate::math::Rgb;
use crate::scene::{NONE, lobe_kind};
use glam::Vec3;

/// Kinds of scattering of a lobe, as bits of [`scattering`].
pub fn kinds_of_lobe(kind: u32) -> u32 {
    if kind == lobe_kind::NULL {
        return 0;
    }
    let bits = lobe::events(kind);
    let is_diffuse = diffuse_share::is_diffuse(kind);
    let mut first = 0;
    if bits & event::DELTA != 0 {
        first |= 1 << scattering::SPECULAR_REFLECTION;
    }
    if is_diffuse || kind == lobe_kind::ROUGH_PLASTIC {
        first |= 1 << scattering::DIFFUSE_REFLECTION;
    }
    if !is_diffuse && !lobe::is_delta(kind) {
        first |= 1 << scattering::GLOSSY_REFLECTION;
    }
    let mut kinds = 0;
    if bits & event::REFLECTION != 0 {
        kinds |= first;
    }
    if bits & event::TRANSMISSION != 0 {
        kinds |= first << 1;
    }
    kinds
}

/// What happens at a vertex, for expressions.
#[derive(Clone, Copy, Debug)]
pub struct Scattered {
    /// Whether it is a discrete event.
    pub is_specular: bool,
    /// Whether light passes to the other side.
    pub is_transmitted: bool,
    /// Share of diffuse scattering in what is no discrete event.
    pub diffuse: Rgb,
}

impl Scattered {
    /// A discrete event, with its bits of [`event`].
    #[inline]
    pub fn specular(bits: u32) -> Scattered {
        Scattered {
            is_specular: true,
            is_transmitted: bits & event::TRANSMISSION != 0,
            diffuse: Vec3::ZERO,
        }
    }

    /// Scattering that is no discrete event, by the smooth part of a BSDF between two local directions.
    #[inline]
    pub fn smooth(bsdf: &Bsdf, data: &[f32], wi: Vec3, wo: Vec3) -> Scattered {
        Scattered {
            is_specular: false,
            is_transmitted: wi.z * wo.z < 0.0,
            diffuse: bsdf.diffuse_share(data, wi, wo),
        }
    }

    /// A sample of a BSDF towards the local direction `wo`, with its bits of [`event`].
    #[inline]
    pub fn sampled(bsdf: &Bsdf, data: &[f32], wi: Vec3, wo: Vec3, bits: u32) -> Scattered {
        if bits & event::DELTA != 0 {
            Scattered::specular(bits)
        } else {
            Scattered::smooth(bsdf, data, wi, wo)
        }
    }

    /// The kind of [`scattering`], if there is but one; [`NONE`] for diffuse and glossy at once.
    #[inline]
    pub fn kind(&self) -> u32 {
        let kind = if self.is_specular {
            scattering::SPECULAR_REFLECTION
        } else if self.diffuse == Vec3::ONE {
            scattering::DIFFUSE_REFLECTION
        } else if self.diffuse == Vec3::ZERO {
            scattering::GLOSSY_REFLECTION
        } else {
            return NONE;
        };
        kind + self.is_transmitted as u32
    }
}
