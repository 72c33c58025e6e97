//! Numerics: float functions, vectors, frames, sampling maps, distributions, small linear systems.

pub mod affine;
pub mod block;
pub mod block_elimination;
pub mod block_tridiagonal;
pub mod distribution;
pub mod filter;
pub mod float;
pub mod frame;
pub mod moebius;
pub mod ray;
pub mod scaled;
pub mod select;
pub mod statistics;
pub mod table;
pub mod warp;

pub use frame::Frame;
pub use ray::Ray;
pub use select::select;
#[cfg(not(target_arch = "spirv"))]
pub use table::within;
pub use table::{element, entry, field};

/// Linear RGB with sRGB primaries.
pub type Rgb = glam::Vec3;

/// Luminance of linear sRGB (Rec. 709 weights).
#[inline]
pub fn luminance(c: Rgb) -> f32 {
    0.212_671 * c.x + 0.715_160 * c.y + 0.072_169 * c.z
}

/// A vector from a plain record's array.
#[inline]
pub fn vec3(a: [f32; 3]) -> glam::Vec3 {
    glam::Vec3::new(a[0], a[1], a[2])
}
