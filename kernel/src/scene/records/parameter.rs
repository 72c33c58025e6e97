//! Parameters of materials, textures and emitters: constants that a texture may multiply.

use super::NONE;
use bytemuck::{Pod, Zeroable};

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
