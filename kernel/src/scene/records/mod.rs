//! The plain records that describe a scene.
//!
//! Every record is `repr(C)`, `Pod`, built of 32-bit words without padding, so that a table of them is uploaded to a
//! storage buffer as it is. Kinds are `u32` constants in a module beside the record: shaders take no enums that carry
//! data. [`NONE`] marks an absent index.

mod camera;
mod emitter;
mod geometry;
mod material;
mod parameter;
mod texture;

pub use camera::{Camera, camera_kind, filter_kind};
pub use emitter::{Emitter, emitter_kind};
pub use geometry::{Instance, Quadric, Shape, Triangle, quadric_kind, shape_flag};
pub use material::{
    CoatRecord, FrameMap, LobeRecord, MAX_COATS, MAX_LOBES, Material, WeightFactor, distribution,
    frame_map_kind, lobe_flag, lobe_kind, material_flag,
};
pub use parameter::{RgbParameter, ScalarParameter};
pub use texture::{Texture, filter_mode, texel_format, texture_kind, wrap_mode};

use bytemuck::{Pod, Zeroable};

/// An absent index.
pub const NONE: u32 = u32::MAX;

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
