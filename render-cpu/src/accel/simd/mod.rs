//! Vectors of floats, and the geometry that is written once for all of their widths.
//!
//! [`SimdFloat`] is what an instruction set has to offer: arithmetic, comparisons that give masks, and choices by masks. The
//! tests of [`boxes`], [`triangles`] and [`spheres`] ask for nothing else, and are compiled for each width: eight lanes
//! with AVX2 ([`avx2`]), sixteen with AVX-512 ([`avx512`]). Another instruction set needs an implementation of the three
//! traits here and nothing more.
//!
//! # How it is compiled
//! Methods are inlined into functions that carry the features of the instruction set, and only there do the instructions
//! behind them become single instructions. So everything here is `#[inline(always)]` and holds no closures, which the
//! compiler might leave outside; and vectors are only made where the processor has been asked for its features, which is
//! the reason behind every `unsafe` in the implementations.
//!
//! # Rounding
//! An operator is one rounded operation: nothing is fused unless [`SimdFloat::mul_add`] says so. The tests give the bits of
//! the scalar functions of [`halflight_kernel::scene::intersect`], whatever the width.

/// Implements an operator of two vectors by an instruction.
#[cfg(target_arch = "x86_64")]
macro_rules! operator {
    ($vector:ident, $name:ident, $method:ident, $instruction:ident) => {
        impl $name for $vector {
            type Output = $vector;
            #[inline(always)]
            fn $method(self, other: $vector) -> $vector {
                // SAFETY: see the modules of the instruction sets.
                $vector(unsafe { $instruction(self.0, other.0) })
            }
        }
    };
}

#[cfg(target_arch = "x86_64")]
pub mod avx2;
#[cfg(target_arch = "x86_64")]
pub mod avx512;
pub mod boxes;
pub mod spheres;
pub mod triangles;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Lanes that hold a float each.
pub trait SimdFloat:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A choice of lanes.
    type Mask: SimdMask;
    /// Lanes that hold an integer each.
    type Word: SimdWord<Mask = Self::Mask>;

    /// The same number in all lanes.
    fn splat(x: f32) -> Self;
    /// The lesser; `other` where one is a NaN.
    fn min(self, other: Self) -> Self;
    /// The greater; `other` where one is a NaN.
    fn max(self, other: Self) -> Self;
    /// Magnitudes.
    fn abs(self) -> Self;
    /// Square roots.
    fn sqrt(self) -> Self;
    /// self x factor + term, rounded once.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// The lanes of a mask where self < other.
    fn lt(self, other: Self, mask: Self::Mask) -> Self::Mask;
    /// The lanes of a mask where self <= other.
    fn le(self, other: Self, mask: Self::Mask) -> Self::Mask;
    /// The lanes of a mask where self > other.
    fn gt(self, other: Self, mask: Self::Mask) -> Self::Mask;
    /// The lanes of a mask where self >= other.
    fn ge(self, other: Self, mask: Self::Mask) -> Self::Mask;
    /// The lanes of a mask where both are equal.
    fn eq(self, other: Self, mask: Self::Mask) -> Self::Mask;
    /// The lanes of a mask where they are not equal, because one is a NaN for example.
    fn ne(self, other: Self, mask: Self::Mask) -> Self::Mask;
    /// `yes` in the lanes of a mask, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

/// A choice of lanes.
pub trait SimdMask:
    Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self>
{
    /// Every lane.
    fn all() -> Self;
    /// Whether any lane is chosen.
    fn any(self) -> bool;
}

/// Lanes that hold a 32-bit integer without a sign each.
pub trait SimdWord: Copy {
    /// A choice of lanes.
    type Mask: SimdMask;

    /// The same integer in all lanes.
    fn splat(x: u32) -> Self;
    /// The lanes of a mask where self < other.
    fn lt(self, other: Self, mask: Self::Mask) -> Self::Mask;
    /// The lanes of a mask where they differ.
    fn ne(self, other: Self, mask: Self::Mask) -> Self::Mask;
    /// The lanes of a mask where any bit of `bits` is set.
    fn test(self, bits: Self, mask: Self::Mask) -> Self::Mask;
    /// Shifted to the right.
    fn shr<const PLACES: u32>(self) -> Self;
    /// `yes` in the lanes of a mask, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

/// Differences by components.
#[inline(always)]
pub fn minus<F: SimdFloat>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// x + y + z of the products, from the left.
#[inline(always)]
pub fn dot<F: SimdFloat>(a: [F; 3], b: [F; 3]) -> F {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The cross product.
#[inline(always)]
pub fn cross<F: SimdFloat>(a: [F; 3], b: [F; 3]) -> [F; 3] {
    [
        a[1] * b[2] - b[1] * a[2],
        a[2] * b[0] - b[2] * a[0],
        a[0] * b[1] - b[0] * a[1],
    ]
}

/// By components, `yes` in the lanes of a mask, `no` elsewhere.
#[inline(always)]
pub fn select3<F: SimdFloat>(mask: F::Mask, yes: [F; 3], no: [F; 3]) -> [F; 3] {
    [
        F::select(mask, yes[0], no[0]),
        F::select(mask, yes[1], no[1]),
        F::select(mask, yes[2], no[2]),
    ]
}
