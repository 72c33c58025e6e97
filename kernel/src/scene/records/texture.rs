//! Textures: bitmaps, checkerboards, grids, wireframes, attributes of meshes.

use super::RgbParameter;
use bytemuck::{Pod, Zeroable};

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
    /// Lines of the value of `color1` along whole u and v, on the value of `color0`: `data[0]` holds the bits of half their width.
    pub const GRID: u32 = 5;
    /// Lines of the value of `color1` along the edges of triangles, on the value of `color0`: `data[0]` and `data[1]` hold the bits of
    /// the distances from an edge within which the first is not, and beyond which only the second is mixed in.
    pub const WIREFRAME: u32 = 6;
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
