//! Structures of arrays: one lane per ray or path.
//!
//! A loop over lanes whose body is one of the crate's scalar functions becomes a loop over vectors, so that what is written for
//! one path serves for sixteen at once. The compiler vectorises a loop if its body makes no calls, holds no inner loop,
//! cannot panic, and provably does not read what it writes. Hence reads by an index are total ([`crate::math::element`],
//! [`Vec3Lanes::gather`]), and inputs and outputs are separate arguments.

use bytemuck::Zeroable;
use glam::Vec3;

/// Lanes of the widest vector. Loops run up to the next multiple of it; results in the lanes beyond the count are never read.
pub const VECTOR_WIDTH: usize = 16;

/// `count` rounded up to a multiple of [`VECTOR_WIDTH`], at most `N`.
#[inline(always)]
pub fn round_up_to_vector<const N: usize>(count: usize) -> usize {
    let count = if count < N { count } else { N };
    let up = (count + (VECTOR_WIDTH - 1)) & !(VECTOR_WIDTH - 1);
    if up < N { up } else { N }
}

/// Lane `i`; the last lane if `i` is beyond the end.
#[inline(always)]
pub fn gather<T: Copy, const N: usize>(lanes: &[T; N], i: u32) -> T {
    let i = i as usize;
    lanes[if i < N { i } else { N - 1 }]
}

/// A three-dimensional vector per lane.
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

    /// Lane `i`; the last lane if `i` is beyond the end.
    #[inline(always)]
    pub fn gather(&self, i: u32) -> Vec3 {
        Vec3::new(gather(&self.x, i), gather(&self.y, i), gather(&self.z, i))
    }
}
