//! One solution of a block-tridiagonal system, by elimination from both ends at once.
//!
//! ```text
//! rows from the top      L_i = B_i - A_i L_{i-1}^-1 C_{i-1},    y_i = L_i^-1 (h_i - A_i y_{i-1}),    U_i = L_i^-1 C_i
//! rows from the bottom   M_j = B_j - C_j M_{j+1}^-1 A_{j+1},    y_j = M_j^-1 (h_j - C_j y_{j+1}),    W_j = M_j^-1 A_j
//! the middle row m       (B_m - A_m U_{m-1} - C_m W_{m+1}) x_m = h_m - A_m y_{m-1} - C_m y_{m+1}
//! and outwards again     x_i = y_i - U_i x_{i+1},               x_j = y_j - W_j x_{j-1}
//! ```
//!
//! The time of elimination is that of its longest chain of dependent operations, one reciprocal of a determinant per block
//! ([`super::block_tridiagonal`]). Two ends make two chains of half the length (van der Vorst 1987, "Large tridiagonal and block
//! tridiagonal linear systems on vector and parallel computers"), which share the lanes of a [`Vec4`]: (top.x, top.y, bottom.x,
//! bottom.y). The right-hand side is eliminated along, in the shadow of the chain.
//!
//! It serves where a single solution is needed, as in each iteration of a walk, and keeps no factors. Determinants, rows of
//! the inverse and transfer matrices come from [`super::block_tridiagonal::BlockLu`]. A system is singular if one of these
//! pivots is within rounding error of a singular block, by the same measure as there. Its pivots differ from those of
//! `BlockLu` but for the first, so either solver, both being without pivoting, may refuse a system that the other solves.
//! Checked: backward error against f64, agreement with `BlockLu`, singular and ill-conditioned input.

use super::block::{LARGEST, SINGULAR, SMALLEST, adjugate_product, product, row_of};
use glam::{Mat2, Vec2, Vec4, Vec4Swizzles};

/// Solves J x = h in place, for the first `len` block rows of `a`, `b`, `c` ([`super::block_tridiagonal`]; `a[0]` and
/// `c[len - 1]` are ignored). False, and zeros, when there is no finite solution.
#[inline]
pub fn solve<const N: usize>(
    a: &[Mat2; N],
    b: &[Mat2; N],
    c: &[Mat2; N],
    len: usize,
    x: &mut [Vec2; N],
) -> bool {
    if len == 0 {
        return true;
    }
    let middle = len / 2;
    if len > N || middle >= N {
        return refuse(x);
    }
    // What the outward pass needs of each pair of rows: U and W by columns, and y.
    let mut first_columns = [Vec4::ZERO; N];
    let mut second_columns = [Vec4::ZERO; N];
    let mut y = [Vec4::ZERO; N];
    // A U and C W, A y and C y, all without the division by the determinant, which runs beside their products.
    let (mut carried_top, mut carried_bottom) = (Vec4::ZERO, Vec4::ZERO);
    let mut carried_h = Vec4::ZERO;
    let mut quotient = Vec4::ZERO;
    let mut regular = true;
    // The partner of row i; an even number of rows gets one more, of the identity, at the bottom.
    let last = len - len % 2;
    for i in 0..middle {
        let j = last - i;
        let mut b_bottom = Vec4::new(1.0, 0.0, 0.0, 1.0);
        let (mut a_bottom, mut c_above, mut h_bottom) = (Vec4::ZERO, Vec4::ZERO, Vec2::ZERO);
        if j < len && j > 0 {
            b_bottom = row_of(b[j]);
            a_bottom = row_of(a[j]);
            c_above = row_of(c[j - 1]);
            h_bottom = x[j];
        }
        let b_top = row_of(b[i]);
        let a_below = row_of(a[i + 1]);

        let top = b_top - carried_top * quotient.x;
        let bottom = b_bottom - carried_bottom * quotient.z;
        let h = pair(x[i], h_bottom) - carried_h * quotient;
        let determinant = determinants(top, bottom);
        regular &= is_regular(
            largest_elements(top, bottom),
            determinant,
            largest_elements(b_top, b_bottom),
        );
        quotient = 1.0 / determinant;

        let u = adjugate_product(top, row_of(c[i]));
        let w = adjugate_product(bottom, a_bottom);
        let z = adjugates_times(top, bottom, h);
        first_columns[i] = first_column(u, w) * quotient;
        second_columns[i] = second_column(u, w) * quotient;
        y[i] = z * quotient;

        carried_top = product(a_below, u);
        carried_bottom = product(c_above, w);
        carried_h =
            first_column(a_below, c_above) * z.xxzz() + second_column(a_below, c_above) * z.yyww();
    }

    let b_middle = row_of(b[middle]);
    let pivot = b_middle - carried_top * quotient.x - carried_bottom * quotient.z;
    let determinant = determinants(pivot, pivot);
    regular &= is_regular(
        largest_elements(pivot, pivot),
        determinant,
        largest_elements(b_middle, b_middle),
    );
    let carried = carried_h * quotient;
    let h = pair(x[middle], x[middle]) - carried - carried.zwxy();
    // Both halves are x_m.
    let mut outer = adjugates_times(pivot, pivot, h) * (1.0 / determinant);
    let mut finite = outer.abs().cmple(Vec4::splat(f32::MAX));
    x[middle] = Vec2::new(outer.x, outer.y);
    let mut i = middle;
    while i > 0 {
        i -= 1;
        outer = y[i] - first_columns[i] * outer.xxzz() - second_columns[i] * outer.yyww();
        finite &= outer.abs().cmple(Vec4::splat(f32::MAX));
        x[i] = Vec2::new(outer.x, outer.y);
        let j = last - i;
        if j < len {
            x[j] = Vec2::new(outer.z, outer.w);
        }
    }
    if !(regular && finite.all()) {
        return refuse(x);
    }
    true
}

#[inline]
fn refuse<const N: usize>(x: &mut [Vec2; N]) -> bool {
    for i in 0..N {
        x[i] = Vec2::ZERO;
    }
    false
}

#[inline]
fn pair(top: Vec2, bottom: Vec2) -> Vec4 {
    Vec4::new(top.x, top.y, bottom.x, bottom.y)
}

#[inline]
fn first_column(top: Vec4, bottom: Vec4) -> Vec4 {
    Vec4::new(top.x, top.y, bottom.x, bottom.y)
}

#[inline]
fn second_column(top: Vec4, bottom: Vec4) -> Vec4 {
    Vec4::new(top.z, top.w, bottom.z, bottom.w)
}

/// Both determinants, each twice.
#[inline]
fn determinants(top: Vec4, bottom: Vec4) -> Vec4 {
    let other_diagonals = Vec4::new(top.w, top.z, bottom.w, bottom.z);
    let products = first_column(top, bottom) * other_diagonals;
    products.xxzz() - products.yyww()
}

/// Both adjugates times a vector each.
#[inline]
fn adjugates_times(top: Vec4, bottom: Vec4, h: Vec4) -> Vec4 {
    let sign = Vec4::new(1.0, -1.0, 1.0, -1.0);
    Vec4::new(top.w, top.y, bottom.w, bottom.y) * (h.xxzz() * sign)
        - Vec4::new(top.z, top.x, bottom.z, bottom.x) * (h.yyww() * sign)
}

/// Magnitudes of the largest elements, each twice.
#[inline]
fn largest_elements(top: Vec4, bottom: Vec4) -> Vec4 {
    let (top, bottom) = (top.abs(), bottom.abs());
    let larger = first_column(top, bottom).max(second_column(top, bottom));
    larger.max(larger.yxwz())
}

/// [`super::block::is_regular`] of four lanes.
#[inline]
fn is_regular(scale: Vec4, determinant: Vec4, before: Vec4) -> bool {
    let regular = scale.cmpgt(Vec4::splat(SMALLEST))
        & scale.cmplt(Vec4::splat(LARGEST))
        & determinant
            .abs()
            .cmpgt(SINGULAR * scale * scale.max(before));
    regular.all()
}
