//! Numbers, vectors, frames and mappings that everything else stands on.

pub mod affine;
pub mod block;
pub mod block_elimination;
pub mod block_tridiagonal;
pub mod disk_lobe;
pub mod distribution;
pub mod elementary;
pub mod filter;
pub mod float;
pub mod frame;
#[cfg(not(target_arch = "spirv"))]
pub mod lanes;
pub mod moebius;
pub mod ray;
pub mod scaled;
pub mod select;
pub mod slope_gaussian;
pub mod statistics;
#[cfg(not(target_arch = "spirv"))]
pub mod vectors;
pub mod warp;

pub use frame::Frame;
pub use ray::Ray;
pub use select::select;

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

/// Element `i` of a constant table, the last one beyond its end.
///
/// An index that may panic would make a shader compiler copy the function to all its callers.
#[inline]
pub fn entry<const N: usize>(table: [f32; N], i: usize) -> f32 {
    let i = if i < N { i } else { N - 1 };
    #[cfg(target_arch = "spirv")]
    // SAFETY: the index was brought into the table.
    unsafe {
        *table.get_unchecked(i)
    }
    #[cfg(not(target_arch = "spirv"))]
    table[i]
}

/// Element `i` of a table, on hosts zeros beyond its end: loops over lanes become vectors only where nothing can panic.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn element<T: Copy + bytemuck::Zeroable>(table: &[T], i: u32) -> T {
    #[cfg(target_arch = "spirv")]
    {
        table[i as usize]
    }
    #[cfg(not(target_arch = "spirv"))]
    match table.get(i as usize) {
        Some(value) => *value,
        None => T::zeroed(),
    }
}

/// A field of element `i` of a table, as [`element`]: for lanes, where whole records would be read in pieces of two words.
#[cfg_attr(target_arch = "spirv", inline)]
#[cfg_attr(not(target_arch = "spirv"), inline(always))]
pub fn field<T, U: bytemuck::Zeroable>(table: &[T], i: u32, of: impl FnOnce(&T) -> U) -> U {
    #[cfg(target_arch = "spirv")]
    {
        of(&table[i as usize])
    }
    #[cfg(not(target_arch = "spirv"))]
    match table.get(i as usize) {
        Some(value) => of(value),
        None => U::zeroed(),
    }
}
