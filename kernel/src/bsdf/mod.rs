//! Scattering models, one per file, and the mixture that a material makes of them at a surface point.
//!
//! A [`Lobe`] is a model with its parameters looked up; [`Bsdf`] is the weighted sum of a material's lobes. Both are
//! plain values. Directions are in the local frame of the surface point: z is the shading normal, `wi` is known (towards
//! the sensor on camera paths), `wo` is sampled.

pub mod clearcoat;
pub mod coat;
pub mod coat_reflection;
pub mod conductor;
pub mod dielectric;
pub mod diffracting_conductor;
pub mod diffraction_table;
pub mod diffuse;
pub mod diffuse_share;
pub mod diffuse_transmission;
pub mod frame_map;
pub mod fresnel;
pub mod hanrahan_krueger;
pub mod lobe;
mod lobe_frame;
pub mod local_roughness;
pub mod lookup;
pub mod measured;
mod measured_grid;
// As the next one, built on hosts.
#[cfg(not(target_arch = "spirv"))]
pub mod measured_table;
pub mod merl;
// Hosts build the table when a scene is built: it takes a tenth of a second.
#[cfg(not(target_arch = "spirv"))]
pub mod merl_table;
pub mod microfacet;
pub mod mixture;
pub mod model;
pub mod null;
pub mod phong;
pub mod plastic;
pub mod principled_diffuse;
pub mod reverse;
pub mod rough_conductor;
pub mod rough_dielectric;
pub mod rough_diffuse;
pub mod rough_plastic;
pub mod rough_transmittance;
pub mod roughness;
pub mod schlick_reflection;
pub mod sheen;
pub mod thin_dielectric;
pub mod thin_transmission;
pub mod ward;

pub use coat::Coat;
pub use local_roughness::local_beckmann_roughness;
pub use lookup::null_transmittance;
pub use mixture::Bsdf;

use crate::math::{Frame, Rgb};
use crate::scene::MAX_COATS;
use bytemuck::{Pod, Zeroable};
use glam::{Vec2, Vec3};

/// What kind of interaction a sample is: bits.
pub mod event {
    /// wo on the side of wi.
    pub const REFLECTION: u32 = 1;
    /// wo on the other side.
    pub const TRANSMISSION: u32 = 2;
    /// A single direction: `pdf` is a discrete probability, `eval` is zero there.
    pub const DELTA: u32 = 4;
    /// Rough but peaked.
    pub const GLOSSY: u32 = 8;
    /// Broad.
    pub const DIFFUSE: u32 = 16;
    /// Null scattering: straight through the surface.
    pub const NULL: u32 = 32;
    /// Only the direction is set, weight and density are not: within shaders, never of a finished sample.
    pub const UNWEIGHTED: u32 = 64;
}

/// Which quantity travels along the path, for the scaling of refracted radiance.
pub mod mode {
    /// Radiance, on paths from the sensor: transmission is scaled by 1/eta^2.
    pub const RADIANCE: u32 = 0;
    /// Importance, on paths from a light: no scaling.
    pub const IMPORTANCE: u32 = 1;
}

/// Value of a BSDF or lobe for a pair of directions, and the densities of sampling either from the other.
#[derive(Clone, Copy, Debug)]
pub struct BsdfValue {
    /// f, times the cosine that the function which returns it states.
    pub value: Rgb,
    /// Density per solid angle of sampling wo where wi is known.
    pub pdf: f32,
    /// Density per solid angle of sampling wi where wo is known.
    pub pdf_reverse: f32,
}

impl BsdfValue {
    /// Nothing is scattered.
    pub const ZERO: BsdfValue = BsdfValue {
        value: Vec3::ZERO,
        pdf: 0.0,
        pdf_reverse: 0.0,
    };
}

/// A sampled direction.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct BsdfSample {
    /// The direction; undefined when `pdf` is zero.
    pub wo: Vec3,
    /// f cos / pdf.
    pub weight: Rgb,
    /// Density per solid angle, a discrete probability for [`event::DELTA`]; zero for no sample.
    pub pdf: f32,
    /// Index on the side of wo over the index on the side of wi (1 for reflection).
    pub eta: f32,
    /// Bits of [`event`].
    pub event: u32,
}

/// A reflected direction with the density and the value of its model, `weighted!(sample, pdf, value)`. In shaders
/// [`Bsdf::mix`] computes both, which evaluates all lobes anyway: their compilers would inline a second copy of the model here.
macro_rules! weighted {
    ($sample:expr, $pdf:expr, $value:expr) => {{
        #[cfg(target_arch = "spirv")]
        {
            $sample.unweighted()
        }
        #[cfg(not(target_arch = "spirv"))]
        {
            $sample.weighted($pdf, $value)
        }
    }};
}
use weighted;

impl BsdfSample {
    /// No sample.
    pub const NONE: BsdfSample = BsdfSample {
        wo: Vec3::Z,
        weight: Vec3::ZERO,
        pdf: 0.0,
        eta: 1.0,
        event: 0,
    };

    /// A reflected direction that has not been weighted.
    #[inline]
    pub(crate) fn towards(wo: Vec3, event: u32) -> BsdfSample {
        BsdfSample {
            wo,
            weight: Vec3::ONE,
            pdf: 1.0,
            eta: 1.0,
            event,
        }
    }

    /// The reflected direction with the density and the value of its model.
    #[cfg(not(target_arch = "spirv"))]
    #[inline]
    pub(crate) fn weighted(self, pdf: f32, value: Rgb) -> BsdfSample {
        if pdf <= 0.0 {
            return BsdfSample::NONE;
        }
        BsdfSample {
            weight: value * (self.wo.z / pdf),
            pdf,
            ..self
        }
    }

    /// The direction, marked as one that [`Bsdf::mix`] is to weight.
    #[cfg(target_arch = "spirv")]
    #[inline]
    pub(crate) fn unweighted(self) -> BsdfSample {
        BsdfSample {
            event: self.event | event::UNWEIGHTED,
            ..self
        }
    }
}

/// A sample of a model that reflects above the horizon only: `direction` draws wo, which may fall below it, and `eval_pdf` gives
/// the value and the density there.
#[inline]
pub(crate) fn sample_reflection(
    wi: Vec3,
    direction: impl FnOnce() -> BsdfSample,
    eval_pdf: impl FnOnce(Vec3) -> (Rgb, f32),
) -> BsdfSample {
    if wi.z <= 0.0 {
        return BsdfSample::NONE;
    }
    let sample = direction();
    if sample.wo.z <= 0.0 {
        return BsdfSample::NONE;
    }
    // Shaders weight the sample in `Bsdf::mix`, see `weighted!`.
    #[cfg(target_arch = "spirv")]
    {
        let _ = eval_pdf;
        sample.unweighted()
    }
    #[cfg(not(target_arch = "spirv"))]
    {
        let (value, pdf) = eval_pdf(sample.wo);
        sample.weighted(pdf, value)
    }
}

/// A scattering model with its parameters looked up at a point.
#[derive(Clone, Copy, Debug)]
pub struct Lobe {
    /// One of [`crate::scene::lobe_kind`].
    pub kind: u32,
    /// One of [`crate::scene::distribution`].
    pub distribution: u32,
    /// Bits of [`crate::scene::lobe_flag`].
    pub flags: u32,
    /// Weight in the material, in [0, 1].
    pub weight: f32,
    /// Perturbed shading frame in the local coordinates of the surface point.
    pub frame: Frame,
    /// Whether `frame` differs from the surface's.
    pub has_frame: bool,
    /// Diffuse reflectance.
    pub reflectance: Rgb,
    /// Factor on specular reflection.
    pub specular_reflectance: Rgb,
    /// Factor on specular transmission.
    pub specular_transmittance: Rgb,
    /// Real index of refraction (see [`crate::scene::LobeRecord::eta`]).
    pub eta: Vec3,
    /// Imaginary index of refraction.
    pub k: Vec3,
    /// Roughness along the tangent and the bitangent.
    pub alpha: Vec2,
    /// Table in `data`, or NONE.
    pub table: u32,
    /// See [`crate::scene::LobeRecord::table_rows`].
    pub table_rows: u32,
    /// See [`crate::scene::LobeRecord::internal_reflectance`].
    pub internal_reflectance: f32,
    /// Absorption coefficient times thickness of the model's own layer.
    pub optical_depth: Vec3,
    /// Number of coats above the lobe.
    pub coat_count: u32,
    /// The coats, outermost first.
    pub coats: [Coat; MAX_COATS],
    /// Exponent of the exponential power distribution.
    pub exponent: f32,
    /// One of [`mode`].
    pub mode: u32,
    /// The features that the scene uses, see [`crate::scene::features`].
    #[cfg(target_arch = "spirv")]
    pub features: u32,
}
