//! 2x2 blocks: determinant, guarded inverse, and products of blocks kept as four numbers in a row.
//!
//! `Vec4(m_00, m_10, m_01, m_11)` is the block of columns (x, y) and (z, w). Written with swizzles, a product is two
//! multiplications and an addition of four lanes, which is what the solvers' chains of dependent products need:
//!
//! `M R = M.xyxy R.xxzz + M.zwzw R.yyww`,
//! `adj(M) R = det(M) M^-1 R = M.wywy (R.xxzz s) - M.zxzx (R.yyww s)`, `s = (1, -1, 1, -1)`.
//!
//! A block is refused as singular when it cannot be distinguished from one ([`SINGULAR`]); all others with a largest element between
//! 1e-15 and 1e15 are inverted by Cramer's rule. Checked: inverses at any scale against f64, refusals.

use super::float::abs;
use glam::{Mat2, Vec2, Vec4, Vec4Swizzles};

/// A block whose determinant is below this times the square of its largest element is singular, and so is a pivot whose
/// smaller singular value is below this times the block of J it came from: 2^-23, where all is rounding error.
pub const SINGULAR: f32 = 1.2e-7;

/// The range of a block's largest element: its square times [`SINGULAR`] is still a normal number.
pub(super) const LARGEST: f32 = 1e15;
/// See [`LARGEST`].
pub(super) const SMALLEST: f32 = 1e-15;

/// The inverse of a block.
#[derive(Clone, Copy, Debug)]
pub struct BlockInverse {
    /// The inverse; zero for a singular block.
    pub inverse: Mat2,
    /// Determinant of the block; zero for a singular one.
    pub determinant: f32,
}

/// Inverse of a 2x2 block, with the guards of this module.
#[inline]
pub fn invert(m: Mat2) -> BlockInverse {
    let block = row_of(m);
    let determinant = determinant2(m);
    if !is_regular(block, determinant, Vec4::ZERO) {
        return BlockInverse {
            inverse: Mat2::ZERO,
            determinant: 0.0,
        };
    }
    BlockInverse {
        inverse: block_of(adjugate(block) * (1.0 / determinant)),
        determinant,
    }
}

/// Determinant of a 2x2 matrix.
#[inline]
pub fn determinant2(m: Mat2) -> f32 {
    m.x_axis.x * m.y_axis.y - m.x_axis.y * m.y_axis.x
}

/// A block as four numbers, column by column.
#[inline]
pub(super) fn row_of(m: Mat2) -> Vec4 {
    Vec4::new(m.x_axis.x, m.x_axis.y, m.y_axis.x, m.y_axis.y)
}

/// The block of four numbers.
#[inline]
pub(super) fn block_of(v: Vec4) -> Mat2 {
    Mat2::from_cols(Vec2::new(v.x, v.y), Vec2::new(v.z, v.w))
}

/// M R.
#[inline]
pub(super) fn product(m: Vec4, r: Vec4) -> Vec4 {
    m.xyxy() * r.xxzz() + m.zwzw() * r.yyww()
}

/// M x.
#[inline]
pub(super) fn apply(m: Vec4, x: Vec2) -> Vec2 {
    Vec2::new(m.x * x.x + m.z * x.y, m.y * x.x + m.w * x.y)
}

/// M^T x.
#[inline]
pub(super) fn apply_transposed(m: Vec4, x: Vec2) -> Vec2 {
    Vec2::new(m.x * x.x + m.y * x.y, m.z * x.x + m.w * x.y)
}

/// det(M) M^-1.
#[inline]
pub(super) fn adjugate(m: Vec4) -> Vec4 {
    m.wyzx() * Vec4::new(1.0, -1.0, -1.0, 1.0)
}

/// det(M) M^-1 R. The signs are R's, which is known before M.
#[inline]
pub(super) fn adjugate_product(m: Vec4, r: Vec4) -> Vec4 {
    let sign = Vec4::new(1.0, -1.0, 1.0, -1.0);
    m.wywy() * (r.xxzz() * sign) - m.zxzx() * (r.yyww() * sign)
}

/// Magnitude of the largest element.
#[inline]
pub(super) fn largest_element(m: Vec4) -> f32 {
    abs(m.x).max(abs(m.y)).max(abs(m.z).max(abs(m.w)))
}

/// Whether a block with this determinant, the remainder of an elimination from `before`, is regular beyond rounding error.
#[inline]
pub(super) fn is_regular(m: Vec4, determinant: f32, before: Vec4) -> bool {
    let scale = largest_element(m);
    // The larger singular value is about `scale`, the smaller one the determinant over that. A NaN may be lost in a
    // maximum, but not in the determinant.
    scale > SMALLEST
        && scale < LARGEST
        && abs(determinant) > SINGULAR * scale * scale.max(largest_element(before))
}
