//! The plain records that describe a scene.
//!
//! Every record is `repr(C)`, `Pod`, built of 32-bit words without padding, so that a table of them is uploaded to a
//! storage buffer as it is. Kinds are `u32` constants in a module beside the record: shaders take no enums that carry
//! data. [`NONE`] marks an absent index.

use bytemuck::{Pod, Zeroable};

/// An absent index.
pub const NONE: u32 = u32::MAX;

/// An RGB parameter: a constant, multiplied by a texture when one is given.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct RgbParameter {
    /// The constant, or the factor on the texture.
    pub value: [f32; 3],
    /// Index into the textures, or [`NONE`].
    pub texture: u32,
}

impl RgbParameter {
    /// A constant.
    pub const fn constant(value: [f32; 3]) -> RgbParameter {
        RgbParameter {
            value,
            texture: NONE,
        }
    }
    /// A texture as it is.
    pub const fn textured(texture: u32) -> RgbParameter {
        RgbParameter {
            value: [1.0; 3],
            texture,
        }
    }
}

/// A scalar parameter: a constant, multiplied by the luminance of a texture when one is given.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ScalarParameter {
    /// The constant, or the factor on the texture.
    pub value: f32,
    /// Index into the textures, or [`NONE`].
    pub texture: u32,
}

impl ScalarParameter {
    /// A constant.
    pub const fn constant(value: f32) -> ScalarParameter {
        ScalarParameter {
            value,
            texture: NONE,
        }
    }
}

/// Three vertices of a mesh; the indices address the position, normal and uv tables alike.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Triangle {
    /// Indices into the position table. Normals, uvs and attributes are found through the shape's offsets.
    pub vertices: [u32; 3],
    /// Index into the shapes.
    pub shape: u32,
}

/// Kinds of [`Quadric`].
pub mod quadric_kind {
    /// Unit sphere at the origin; u is the azimuth over 2 pi, v the polar angle from +z over pi.
    pub const SPHERE: u32 = 0;
    /// Unit disk in z = 0 with normal +z; u is the radius, v the azimuth over 2 pi.
    pub const DISK: u32 = 1;
    /// Unit-radius cylinder around z from 0 to 1 without caps; u is the azimuth over 2 pi, v is z.
    pub const CYLINDER: u32 = 2;
}

/// An analytic shape: a canonical surface under an affine map.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Quadric {
    /// Object to world, three rows of four.
    pub to_world: [f32; 12],
    /// World to object, three rows of four.
    pub to_object: [f32; 12],
    /// One of [`quadric_kind`].
    pub kind: u32,
    /// Index into the shapes.
    pub shape: u32,
}

/// Flags of [`Shape`].
pub mod shape_flag {
    /// The geometric normal points against the surface's parametric normal.
    pub const FLIP_NORMALS: u32 = 1;
    /// Vertex normals are ignored.
    pub const FACE_NORMALS: u32 = 2;
}

/// What a group of primitives shares.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Shape {
    /// Index into the materials.
    pub material: u32,
    /// Index into the emitters, or [`NONE`].
    pub emitter: u32,
    /// Bits of [`shape_flag`].
    pub flags: u32,
    /// `normals[i + normal_offset]` (wrapping) is the normal of vertex `i`; [`NONE`] without vertex normals.
    pub normal_offset: u32,
    /// `uvs[i + uv_offset]` (wrapping) is the uv of vertex `i`; [`NONE`] without uvs.
    pub uv_offset: u32,
    /// First word in `data` of the mesh's vertex attributes: attribute `a`, vertex `i - first_vertex`, three words
    /// each; textures of kind `VERTEX_ATTRIBUTE` or `FACE_ATTRIBUTE` hold the attribute's own offset instead.
    pub first_vertex: u32,
    /// First triangle of the mesh (for face attributes and area sampling), or the quadric's index.
    pub first_primitive: u32,
    /// Number of triangles of the mesh, or 1 for a quadric.
    pub primitive_count: u32,
}

/// A placed copy of a group of primitives. Instance 0 is the world itself, with the identity.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Instance {
    /// Object to world, three rows of four.
    pub to_world: [f32; 12],
    /// World to object, three rows of four.
    pub to_object: [f32; 12],
    /// Root of the group's subtree in the shader's BVH nodes.
    pub root: u32,
    /// Index of the group (bottom-level structure) on the host.
    pub group: u32,
}

/// Kinds of [`Texture`].
pub mod texture_kind {
    /// Image: `data[0]` first word in `texels`, `data[1]` width, `data[2]` height, `data[3]` format
    /// ([`super::texel_format`]), `data[4]` filter ([`super::filter_mode`]), `data[5]` wrap ([`super::wrap_mode`]).
    pub const BITMAP: u32 = 0;
    /// `color0` where floor(u) + floor(v) is even after scaling by two per unit square, `color1` elsewhere.
    pub const CHECKERBOARD: u32 = 1;
    /// Interpolated vertex attribute: `data[0]` first word in `data`, `data[1]` channels (1 or 3), `data[2]` the
    /// mesh's first vertex.
    pub const VERTEX_ATTRIBUTE: u32 = 2;
    /// Face attribute: `data[0]` first word in `data`, `data[1]` channels (1 or 3), `data[2]` the mesh's first triangle.
    pub const FACE_ATTRIBUTE: u32 = 3;
    /// `color0` times the texture in `color0.texture` (nested scaling).
    pub const SCALE: u32 = 4;
}

/// Formats of texels, one or more `u32` words each.
pub mod texel_format {
    /// Four bytes, R lowest, sRGB-encoded R, G, B and linear A.
    pub const RGBA8_SRGB: u32 = 0;
    /// Four bytes, R lowest, linear.
    pub const RGBA8_LINEAR: u32 = 1;
    /// Three words, each the bits of an `f32`.
    pub const RGB32F: u32 = 2;
}

/// How a bitmap is looked up between texels.
pub mod filter_mode {
    /// Bilinear.
    pub const BILINEAR: u32 = 0;
    /// Nearest texel.
    pub const NEAREST: u32 = 1;
}

/// What lies outside the unit square of a bitmap.
pub mod wrap_mode {
    /// The image again.
    pub const REPEAT: u32 = 0;
    /// The image mirrored.
    pub const MIRROR: u32 = 1;
    /// The border texel.
    pub const CLAMP: u32 = 2;
    /// Zero (Mitsuba 0.6).
    pub const ZERO: u32 = 3;
    /// One (Mitsuba 0.6).
    pub const ONE: u32 = 4;
}

/// A texture over a surface's uv.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Texture {
    /// One of [`texture_kind`].
    pub kind: u32,
    /// See the kinds.
    pub data: [u32; 6],
    /// Affine map applied to (u, v) first: rows (a, b, c), (d, e, f).
    pub to_uv: [f32; 6],
    /// First colour or nested texture.
    pub color0: RgbParameter,
    /// Second colour or nested texture.
    pub color1: RgbParameter,
}

/// A material: a run of lobes. Nested plugins are flattened into it when the scene is built.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Material {
    /// First lobe.
    pub first_lobe: u32,
    /// Number of lobes, at most [`crate::bsdf::MAX_LOBES`].
    pub lobe_count: u32,
    /// Bits of [`material_flag`].
    pub flags: u32,
}

/// Flags of [`Material`].
pub mod material_flag {
    /// Some lobe is [`super::lobe_kind::NULL`]: shadow rays may pass.
    pub const HAS_NULL: u32 = 1;
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
    /// Rough diffuse reflection (Oren-Nayar).
    pub const ROUGH_DIFFUSE: u32 = 9;
    /// Conductor with reflection at the microfacets and diffraction at their finer roughness (CTD).
    pub const DIFFRACTING_CONDUCTOR: u32 = 10;
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
    pub coats: [CoatRecord; crate::bsdf::MAX_COATS],
    /// Exponent of the exponential power distribution.
    pub exponent: ScalarParameter,
}

/// A dielectric coat as what is below it sees it; its reflection is a lobe of its own.
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

/// Kinds of [`Emitter`].
pub mod emitter_kind {
    /// Emission of a shape, `radiance` on the side of its normal.
    pub const AREA: u32 = 0;
    /// `radiance` holds the intensity, position at the origin of `to_world`.
    pub const POINT: u32 = 1;
    /// Intensity along +z, falling off linearly in the angle between the beam width `parameters[0]` and the cutoff
    /// `parameters[1]` (radians from the axis), with an optional texture.
    pub const SPOT: u32 = 2;
    /// Pinhole projection of a texture along +z: `parameters[0]`, `[1]` are the tangents of half the field of view.
    pub const PROJECTOR: u32 = 3;
    /// `radiance` holds the irradiance on a surface facing it, light travels along +z of `to_world`.
    pub const DIRECTIONAL: u32 = 4;
    /// The same radiance from everywhere.
    pub const CONSTANT: u32 = 5;
    /// Latitude-longitude image in local frame with +y up; texture in `radiance.texture`.
    pub const ENVIRONMENT: u32 = 6;
}

/// A light source.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Emitter {
    /// One of [`emitter_kind`].
    pub kind: u32,
    /// Radiance, intensity or irradiance; texture where the kind takes one.
    pub radiance: RgbParameter,
    /// Local to world, three rows of four.
    pub to_world: [f32; 12],
    /// World to local, three rows of four.
    pub to_local: [f32; 12],
    /// See the kinds.
    pub parameters: [f32; 4],
    /// Index into the shapes (area), or [`NONE`].
    pub shape: u32,
    /// Area of the shape (area), or zero.
    pub area: f32,
    /// First word in `data` of the sampling table: for a mesh the cumulative areas of its triangles normalised to one
    /// (`primitive_count` words, see [`super::emitter::fill_shape_areas`]), not used by analytic shapes; for an
    /// environment the marginal over rows (h words) and then w conditionals per row (w * h words), all cumulative and
    /// normalised to one per row (see [`super::emitter::environment`]); [`NONE`] samples it uniformly.
    pub distribution: u32,
    /// Width of an environment's table: the image's width.
    pub width: u32,
    /// Height of an environment's table: one less than the image's, which has rows on both poles.
    pub height: u32,
    /// Probability of choosing this emitter.
    pub selection_pdf: f32,
    /// Sum of the selection probabilities up to and including this emitter.
    pub selection_cdf: f32,
}

/// Kinds of [`Camera`].
pub mod camera_kind {
    /// Pinhole.
    pub const PERSPECTIVE: u32 = 0;
    /// Thin lens with `aperture_radius` focused at `focus_distance`.
    pub const THIN_LENS: u32 = 1;
    /// Parallel rays along +z; the film spans [-1, 1] in x of the local frame.
    pub const ORTHOGRAPHIC: u32 = 2;
}

/// Reconstruction filters.
pub mod filter_kind {
    /// Box, radius `filter_parameters[0]`.
    pub const BOX: u32 = 0;
    /// Tent, radius `filter_parameters[0]`.
    pub const TENT: u32 = 1;
    /// Truncated gaussian, radius and standard deviation, shifted to zero at the radius.
    pub const GAUSSIAN: u32 = 2;
    /// Mitchell-Netravali, radius 2, parameters B and C in `[1]`, `[2]`.
    pub const MITCHELL: u32 = 3;
    /// Catmull-Rom, radius 2.
    pub const CATMULL_ROM: u32 = 4;
    /// Lanczos-windowed sinc, radius `filter_parameters[0]` (lobes).
    pub const LANCZOS: u32 = 5;
}

/// The sensor and its film.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Camera {
    /// One of [`camera_kind`].
    pub kind: u32,
    /// Camera to world, three rows of four; the camera looks along +z, +y is up in the image, +x is left.
    pub to_world: [f32; 12],
    /// World to camera, three rows of four.
    pub to_camera: [f32; 12],
    /// Width and height of the whole film in pixels.
    pub film_size: [u32; 2],
    /// First pixel of the crop window.
    pub crop_offset: [u32; 2],
    /// Width and height of the crop window in pixels.
    pub crop_size: [u32; 2],
    /// Tangent of half the horizontal field of view (perspective kinds), or half the film's width in local units.
    pub tan_half_width: f32,
    /// Tangent of half the vertical field of view (perspective kinds), or half the film's height in local units.
    pub tan_half_height: f32,
    /// Shift of the principal point as a fraction of the film's width and height.
    pub principal_point_offset: [f32; 2],
    /// Radius of a thin lens.
    pub aperture_radius: f32,
    /// Distance of the plane in focus.
    pub focus_distance: f32,
    /// Nearest and farthest z in camera space that is seen.
    pub clip: [f32; 2],
    /// One of [`filter_kind`].
    pub filter: u32,
    /// See the kinds.
    pub filter_parameters: [f32; 3],
    /// First word in `data` of the filter's table (see [`crate::math::filter`]).
    pub filter_table: u32,
    /// Number of steps of the table over [-radius, radius]; it has twice as many words. Zero samples evenly.
    pub filter_table_size: u32,
}

/// Flags of [`SceneInfo`].
pub mod scene_flag {
    /// Some material has [`super::material_flag::HAS_NULL`]: shadow rays must look at what they meet.
    pub const HAS_NULL: u32 = 1;
}

/// Facts about the whole scene.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SceneInfo {
    /// Centre of the bounding sphere.
    pub center: [f32; 3],
    /// Radius of the bounding sphere, positive.
    pub radius: f32,
    /// Index of the environment or constant emitter, or [`NONE`].
    pub environment: u32,
    /// First word in `data` of the 256 linear values of sRGB bytes.
    pub srgb_table: u32,
    /// Bits of [`scene_flag`].
    pub flags: u32,
}
