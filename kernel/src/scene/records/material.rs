//! Materials: lobes, their coats, mixing factors, and maps that perturb their frames.

use super::{NONE, RgbParameter, ScalarParameter};
use bytemuck::{Pod, Zeroable};

/// The most lobes of a flattened material.
pub const MAX_LOBES: usize = 8;

/// The most coats above a lobe.
pub const MAX_COATS: usize = 2;

/// A material: a run of lobes. Nested plugins are flattened into it when the scene is built.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Material {
    /// First lobe.
    pub first_lobe: u32,
    /// Number of lobes, at most [`MAX_LOBES`].
    pub lobe_count: u32,
    /// Bits of [`material_flag`].
    pub flags: u32,
}

/// Flags of [`Material`].
pub mod material_flag {
    /// Some lobe is [`super::lobe_kind::NULL`]: shadow rays may pass.
    pub const HAS_NULL: u32 = 1;
    /// Some parameter of some lobe has a texture.
    pub const TEXTURED: u32 = 4;
    /// First of the eight bits that accelerators of an algorithm may use; zeros are no information.
    pub const ACCELERATOR_SHIFT: u32 = 8;
}

/// Scattering models.
pub mod lobe_kind {
    /// Lambertian reflection.
    pub const DIFFUSE: u32 = 0;
    /// Smooth conductor.
    pub const CONDUCTOR: u32 = 1;
    /// Rough conductor.
    pub const ROUGH_CONDUCTOR: u32 = 2;
    /// Smooth dielectric boundary.
    pub const DIELECTRIC: u32 = 3;
    /// Thin dielectric slab.
    pub const THIN_DIELECTRIC: u32 = 4;
    /// Rough dielectric boundary.
    pub const ROUGH_DIELECTRIC: u32 = 5;
    /// Diffuse base under a smooth dielectric.
    pub const PLASTIC: u32 = 6;
    /// Diffuse base under a rough dielectric.
    pub const ROUGH_PLASTIC: u32 = 7;
    /// No interaction: light passes straight on.
    pub const NULL: u32 = 8;
    /// Reflection at the surface of a smooth coat.
    pub const COAT: u32 = 12;
    /// Reflection at the surface of a rough coat.
    pub const ROUGH_COAT: u32 = 13;
    /// Measured isotropic reflectance in the Rusinkiewicz parametrisation.
    pub const MERL: u32 = 14;
    /// Measured reflectance over directions that follow the material (Dupuy and Jakob).
    pub const MEASURED: u32 = 15;
    /// Rough diffuse reflection (Oren-Nayar).
    pub const ROUGH_DIFFUSE: u32 = 9;
    /// Conductor with reflection at the microfacets and diffraction at their finer roughness (CTD).
    pub const DIFFRACTING_CONDUCTOR: u32 = 10;
    /// Power of the cosine to the mirror direction (modified Phong).
    pub const PHONG: u32 = 16;
    /// Elliptical Gaussian over the slope of the half vector (Ward); [`super::LobeRecord::distribution`] is one of
    /// [`crate::bsdf::ward::variant`].
    pub const WARD: u32 = 17;
    /// Lambertian transmission.
    pub const DIFFUSE_TRANSMISSION: u32 = 18;
    /// Diffuse part of the principled model.
    pub const PRINCIPLED_DIFFUSE: u32 = 19;
    /// Sheen of the principled model.
    pub const SHEEN: u32 = 20;
    /// Microfacets that reflect with Schlick's approximation.
    pub const SCHLICK_REFLECTION: u32 = 21;
    /// Clear coat of the principled model.
    pub const CLEARCOAT: u32 = 22;
    /// Transmission through a thin rough sheet.
    pub const THIN_TRANSMISSION: u32 = 23;
    /// Single scattering in a thin layer (Hanrahan and Krueger); [`super::LobeRecord::distribution`] is one of
    /// [`crate::bsdf::hanrahan_krueger::layer_parameters`].
    pub const HANRAHAN_KRUEGER: u32 = 24;
    /// Number of values that kinds take.
    pub const COUNT: u32 = 25;
}

/// Microfacet distributions.
pub mod distribution {
    /// Beckmann.
    pub const BECKMANN: u32 = 0;
    /// GGX (Trowbridge-Reitz).
    pub const GGX: u32 = 1;
    /// Power of the cosine, with the exponent 2 / alpha^2 - 2.
    pub const PHONG: u32 = 2;
    /// Exponential power of the slope, with [`super::LobeRecord::exponent`].
    pub const EXPONENTIAL_POWER: u32 = 3;
}

/// Flags of [`LobeRecord`].
pub mod lobe_flag {
    /// The lobe exists where wi is above the surface.
    pub const FRONT: u32 = 1;
    /// The lobe exists where wi is below the surface.
    pub const BACK: u32 = 2;
    /// Below the surface both directions are mirrored first (two-sided materials).
    pub const FLIP_BACK: u32 = 4;
    /// Plastic: the diffuse albedo shifts with internal reflection (1 - rho F_int per channel).
    pub const NONLINEAR: u32 = 8;
    /// Distribution of normals is sampled as a whole rather than its visible part.
    pub const SAMPLE_ALL_NORMALS: u32 = 16;
    /// The coats follow the surface and only what is below them the lobe's perturbed frame; else both share that frame.
    pub const COATS_OUTSIDE_FRAME: u32 = 32;
    /// The roughnesses are those of the principled model: `alpha_u` is the root of the width, `alpha_v` the anisotropy.
    pub const PRINCIPLED_ROUGHNESS: u32 = 64;
    /// The factor on transmission is the root of what is given, as light passes the surface twice.
    pub const ROOT_TRANSMITTANCE: u32 = 128;
    /// Schlick's reflectance is the hue of what is given times that of the index.
    pub const TINTED: u32 = 256;
}

/// One scattering model with its parameters.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct LobeRecord {
    /// One of [`lobe_kind`].
    pub kind: u32,
    /// One of [`distribution`].
    pub distribution: u32,
    /// Bits of [`lobe_flag`].
    pub flags: u32,
    /// First [`WeightFactor`].
    pub first_factor: u32,
    /// Number of factors; their product is the lobe's weight in the material.
    pub factor_count: u32,
    /// Index into the perturbed frames, or [`NONE`].
    pub frame: u32,
    /// Diffuse reflectance.
    pub reflectance: RgbParameter,
    /// Factor on specular reflection.
    pub specular_reflectance: RgbParameter,
    /// Factor on specular transmission.
    pub specular_transmittance: RgbParameter,
    /// Real index of refraction: per channel for conductors; interior over exterior, in every channel, for dielectrics.
    pub eta: RgbParameter,
    /// Imaginary index of refraction (conductors).
    pub k: RgbParameter,
    /// Roughness along the tangent.
    pub alpha_u: ScalarParameter,
    /// Roughness along the bitangent.
    pub alpha_v: ScalarParameter,
    /// First word in `data` of the model's table (rough transmittance, measured values), or [`NONE`].
    pub table: u32,
    /// Rows of a table of rough transmittance: 1 at a constant roughness, else over the roughness.
    pub table_rows: u32,
    /// Precomputed scalar of the model: internal diffuse Fresnel reflectance of plastics.
    pub internal_reflectance: f32,
    /// Absorption coefficient times thickness of the model's own layer (plastics).
    pub optical_depth: RgbParameter,
    /// Number of coats above the lobe.
    pub coat_count: u32,
    /// The coats, outermost first.
    pub coats: [CoatRecord; MAX_COATS],
    /// Exponent of the exponential power distribution.
    pub exponent: ScalarParameter,
}

#[cfg(not(target_arch = "spirv"))]
impl LobeRecord {
    /// Whether the lobe is a scattering model alone: it is weighted by nothing, has no coats, absorption or perturbed frame,
    /// and is not [`lobe_kind::NULL`].
    pub fn is_plain(&self) -> bool {
        self.kind != lobe_kind::NULL
            && self.factor_count == 0
            && self.coat_count == 0
            && self.frame == NONE
            && self.optical_depth.value == [0.0; 3]
    }

    /// Whether one of the model's parameters has a texture.
    pub fn is_textured(&self) -> bool {
        let colours = [
            &self.reflectance,
            &self.specular_reflectance,
            &self.specular_transmittance,
            &self.eta,
            &self.k,
            &self.optical_depth,
        ];
        let scalars = [&self.alpha_u, &self.alpha_v, &self.exponent];
        colours.iter().any(|p| p.texture != NONE) || scalars.iter().any(|p| p.texture != NONE)
    }
}

#[cfg(not(target_arch = "spirv"))]
impl Material {
    /// The flags of a material of the given lobes.
    pub fn flags_of(lobes: &[LobeRecord]) -> u32 {
        let mut flags = 0;
        if lobes.iter().any(|lobe| lobe.kind == lobe_kind::NULL) {
            flags |= material_flag::HAS_NULL;
        }
        if lobes.iter().any(LobeRecord::is_textured) {
            flags |= material_flag::TEXTURED;
        }
        flags
    }
}

/// A dielectric coat in its effect on the lobe below: refraction, transmittance, absorption. Its reflection is a separate lobe.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct CoatRecord {
    /// Index below the coat's surface over the index above it.
    pub eta: f32,
    /// Absorption coefficient times thickness.
    pub optical_depth: RgbParameter,
    /// Roughness of the coat's surface, for the table.
    pub alpha: ScalarParameter,
    /// First word in `data` of the table of rough transmittance, or [`NONE`] for that of a smooth surface.
    pub table: u32,
    /// Rows of the table, see [`LobeRecord::table_rows`].
    pub table_rows: u32,
}

impl CoatRecord {
    /// Nothing.
    pub const NONE: CoatRecord = CoatRecord {
        eta: 1.0,
        optical_depth: RgbParameter::constant([0.0; 3]),
        alpha: ScalarParameter::constant(0.0),
        table: NONE,
        table_rows: 1,
    };
}

/// One factor of a lobe's weight: the parameter, or one minus it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct WeightFactor {
    /// The mixing parameter, clamped to [0, 1].
    pub parameter: ScalarParameter,
    /// 1 for one minus the parameter, 0 for the parameter.
    pub complement: u32,
}

/// Kinds of [`FrameMap`].
pub mod frame_map_kind {
    /// Texture holds normals: RGB in [0, 1] to xyz in [-1, 1].
    pub const NORMAL: u32 = 0;
    /// Texture holds a displacement along the normal.
    pub const BUMP: u32 = 1;
}

/// A perturbation of the shading frame. Maps nest: `parent` is applied first.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct FrameMap {
    /// One of [`frame_map_kind`].
    pub kind: u32,
    /// Index into the textures.
    pub texture: u32,
    /// Factor on a bump map's displacement.
    pub scale: f32,
    /// Index of the map applied before this one, or [`NONE`].
    pub parent: u32,
}
