//! Numbers side by side, a lane for each of many rays or paths.
//!
//! Structures of arrays, so that a loop over lanes whose body is a function of this crate becomes one over vectors: what
//! is written for one path serves for sixteen at once. A compiler does that where the body neither calls nor loops nor may
//! panic, and where it sees that what is written is not read; hence [`super::element`] and [`Vec3Lanes::pick`], which are total,
//! and arguments apart for input and output.
//!
//! Hosts only: a shader's lanes are the device's.

use bytemuck::Zeroable;
use glam::Vec3;

/// Lanes of a vector of the widest kind. Loops run to the next multiple of it, over lanes that nobody reads.
pub const VECTOR: usize = 16;

/// The number of lanes that a loop over `count` of `N` runs over: a multiple of [`VECTOR`] where `N` is.
#[inline(always)]
pub fn whole<const N: usize>(count: usize) -> usize {
    let count = if count < N { count } else { N };
    let up = (count + (VECTOR - 1)) & !(VECTOR - 1);
    if up < N { up } else { N }
}

/// Lane `i`, the last one beyond the end.
#[inline(always)]
pub fn pick<T: Copy, const N: usize>(lanes: &[T; N], i: u32) -> T {
    let i = i as usize;
    lanes[if i < N { i } else { N - 1 }]
}

/// A vector for each lane.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Zeroable)]
pub struct Vec3Lanes<const N: usize> {
    /// First components.
    pub x: [f32; N],
    /// Second components.
    pub y: [f32; N],
    /// Third components.
    pub z: [f32; N],
}

impl<const N: usize> Vec3Lanes<N> {
    /// Lane `i < N`.
    #[inline(always)]
    pub fn get(&self, i: usize) -> Vec3 {
        Vec3::new(self.x[i], self.y[i], self.z[i])
    }

    /// Sets lane `i < N`.
    #[inline(always)]
    pub fn set(&mut self, i: usize, v: Vec3) {
        self.x[i] = v.x;
        self.y[i] = v.y;
        self.z[i] = v.z;
    }

    /// Lane `i`, the last one beyond the end.
    #[inline(always)]
    pub fn pick(&self, i: u32) -> Vec3 {
        Vec3::new(pick(&self.x, i), pick(&self.y, i), pick(&self.z, i))
    }
}
