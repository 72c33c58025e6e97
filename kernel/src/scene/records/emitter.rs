//! Light sources.

use super::RgbParameter;
use bytemuck::{Pod, Zeroable};

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
    /// A beam without width along +z of `to_world` from its origin: `radiance` holds its power.
    pub const COLLIMATED: u32 = 7;
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
    /// Index into the shapes (area), or [`NONE`](super::NONE).
    pub shape: u32,
    /// Area of the shape (area), or zero.
    pub area: f32,
    /// First word in `data` of the sampling table: for a mesh the cumulative areas of its triangles normalised to one
    /// (`primitive_count` words, see [`crate::scene::emitter::fill_shape_areas`]), not used by analytic shapes; for an
    /// environment the marginal over rows (h words) and then w conditionals per row (w * h words), all cumulative and
    /// normalised to one per row (see [`crate::scene::emitter::environment`]); [`NONE`](super::NONE) samples it uniformly.
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
