//! LU factorisation of block-tridiagonal matrices over 2x2 blocks.
//!
//! ```text
//!     | B0 C0          |        L_0 = B_0,   U_i = L_i^-1 C_i,   L_{i+1} = B_{i+1} - A_{i+1} U_i
//! J = | A1 B1 C1       |        J = (block lower: A_i, L_i) (block unit upper: U_i)
//!     |    A2 B2 C2    |        det J = product of det L_i
//!     |       ..  ..   |
//! ```
//!
//! The constraints of a light path form such a matrix (Kaplanyan 2017, equation 7.3), so everything that a path needs from
//! J^-1 costs time linear in its length: solutions, the determinant, a block row of the inverse (D_i of equation 8.1) and the
//! transfer matrices T_i, which say how x_i moves with a vertex behind the last row.
//!
//! For a single solution, [`super::block_elimination`] takes a third of the time.
//!
//! There is no pivoting across blocks; inside a block Cramer's rule is exact enough at any scale. A pivot L_i that is
//! singular to rounding error ([`super::block::SINGULAR`]), or a number that is not finite, makes the factorisation `singular`:
//! its determinant is zero and every solution is refused. Growth without pivoting is bounded by the pivots' conditions, and
//! [`BlockLu::condition`] estimates that of the whole. Checked: backward error against f64, determinant, inverse rows and
//! transfer matrices against a dense solve, singular inputs.

use super::block::{
    adjugate, adjugate_product, apply, apply_transposed, block_of, determinant2, is_regular,
    product, row_of,
};
use super::float::abs;
use super::scaled::{Scaled, is_finite2};
use glam::{Mat2, Vec2, Vec4};

/// The factors of a matrix of up to `N` block rows.
#[derive(Clone, Copy, Debug)]
pub struct BlockLu<const N: usize> {
    /// A_i.
    lower: [Vec4; N],
    /// L_i^-1.
    pivot_inverse: [Vec4; N],
    /// L_i^-1 A_i.
    pivot_lower: [Vec4; N],
    /// U_i; that of the last row belongs to the vertex behind it.
    upper: [Vec4; N],
    /// det L_i.
    pivot: [f32; N],
    len: usize,
    singular: bool,
}

impl<const N: usize> BlockLu<N> {
    /// Of a matrix that has no inverse.
    pub const SINGULAR: BlockLu<N> = BlockLu {
        lower: [Vec4::ZERO; N],
        pivot_inverse: [Vec4::ZERO; N],
        pivot_lower: [Vec4::ZERO; N],
        upper: [Vec4::ZERO; N],
        pivot: [0.0; N],
        len: 0,
        singular: true,
    };

    /// Factors the first `len` block rows. `a[0]` is ignored; `c[len - 1]` is used by [`BlockLu::transfer`] only. More rows
    /// than the slices or the capacity hold count as singular.
    #[inline]
    pub fn factor(a: &[Mat2], b: &[Mat2], c: &[Mat2], len: usize) -> BlockLu<N> {
        let mut lu = BlockLu {
            len,
            singular: false,
            ..BlockLu::SINGULAR
        };
        if len > N || len > a.len() || len > b.len() || len > c.len() {
            lu.refuse();
            return lu;
        }
        // U and the next A U are kept without the division by det L, which then runs beside their products.
        let mut carried = Vec4::ZERO;
        let mut quotient = 0.0;
        for i in 0..len {
            let (before, above) = (row_of(b[i]), row_of(c[i]));
            let below = if i == 0 { Vec4::ZERO } else { row_of(a[i]) };
            let pivot = before - carried * quotient;
            let determinant = pivot.x * pivot.w - pivot.y * pivot.z;
            if !is_regular(pivot, determinant, before) {
                lu.refuse();
                return lu;
            }
            let next = adjugate_product(pivot, above);
            quotient = 1.0 / determinant;
            let upper = next * quotient;
            // The last C is part of no pivot.
            if !upper.abs().cmple(Vec4::splat(f32::MAX)).all() {
                lu.refuse();
                return lu;
            }
            lu.lower[i] = below;
            lu.pivot_inverse[i] = adjugate(pivot) * quotient;
            lu.pivot_lower[i] = adjugate_product(pivot, below) * quotient;
            lu.upper[i] = upper;
            lu.pivot[i] = determinant;
            if i + 1 < len {
                carried = product(row_of(a[i + 1]), next);
            }
        }
        lu
    }

    #[inline]
    fn refuse(&mut self) {
        self.len = 0;
        self.singular = true;
    }

    /// Whether a pivot was singular or the input not finite. Every result is then zero.
    #[inline]
    pub fn is_singular(&self) -> bool {
        self.singular
    }

    /// The determinant with its sign.
    #[inline]
    pub fn determinant(&self) -> Scaled {
        if self.singular {
            return Scaled::ZERO;
        }
        let mut determinant = Scaled::ONE;
        for i in 0..self.len.min(N) {
            determinant = determinant.times(self.pivot[i]);
        }
        determinant
    }

    /// Solves J x = h in place. False, and zeros, when there is no finite solution.
    #[inline]
    pub fn solve(&self, x: &mut [Vec2; N]) -> bool {
        let n = self.len.min(N);
        // L y = h, then U x = y.
        let mut y = Vec2::ZERO;
        for i in 0..n {
            y = apply(self.pivot_inverse[i], x[i]) - apply(self.pivot_lower[i], y);
            x[i] = y;
        }
        let mut above = Vec2::ZERO;
        let mut finite = !self.singular;
        let mut i = n;
        while i > 0 {
            i -= 1;
            if i + 1 < n {
                above = x[i] - apply(self.upper[i], above);
            } else {
                above = x[i];
            }
            x[i] = above;
            finite = finite && is_finite2(above);
        }
        if !finite {
            for i in 0..N {
                x[i] = Vec2::ZERO;
            }
        }
        finite
    }

    /// Solves J^T x = h in place; as [`BlockLu::solve`].
    #[inline]
    pub fn solve_transposed(&self, x: &mut [Vec2; N]) -> bool {
        let n = self.len.min(N);
        let mut y = Vec2::ZERO;
        for i in 0..n {
            if i > 0 {
                y = x[i] - apply_transposed(self.upper[i - 1], y);
            } else {
                y = x[i];
            }
            x[i] = y;
        }
        let mut below = Vec2::ZERO;
        let mut finite = !self.singular;
        let mut i = n;
        while i > 0 {
            i -= 1;
            if i + 1 < n {
                below = x[i] - apply_transposed(self.lower[i + 1], below);
            } else {
                below = x[i];
            }
            below = apply_transposed(self.pivot_inverse[i], below);
            x[i] = below;
            finite = finite && is_finite2(below);
        }
        if !finite {
            for i in 0..N {
                x[i] = Vec2::ZERO;
            }
        }
        finite
    }

    /// Block row `row` of the inverse: how unknown `row` moves with each right-hand side. Zeros when singular.
    #[inline]
    pub fn row_of_inverse(&self, row: usize, out: &mut [Mat2; N]) {
        let n = self.len.min(N);
        for i in 0..N {
            out[i] = Mat2::ZERO;
        }
        if row >= n {
            return;
        }
        // X J = E_row: first Z U = E_row, then X L = Z.
        let mut z = Mat2::IDENTITY;
        for i in row..n {
            if i > row {
                z = -z * block_of(self.upper[i - 1]);
            }
            out[i] = z;
        }
        let mut x = Mat2::ZERO;
        let mut i = n;
        while i > 0 {
            i -= 1;
            let carried = if i + 1 < n {
                x * block_of(self.lower[i + 1])
            } else {
                Mat2::ZERO
            };
            x = (out[i] - carried) * block_of(self.pivot_inverse[i]);
            out[i] = x;
        }
    }

    /// The blocks D_i of the last block row of the inverse (Kaplanyan 2017, equation 8.1).
    #[inline]
    pub fn last_row_of_inverse(&self, out: &mut [Mat2; N]) {
        let n = self.len.min(N);
        self.row_of_inverse(if n > 0 { n - 1 } else { N }, out);
    }

    /// Transfer matrices T_i = dx_i / dx_vertex for i < `vertex` at fixed right-hand sides, T_vertex = 1 and
    /// T_i = -U_i T_{i+1}. `vertex` may be the one behind the last row, which `c[len - 1]` couples to it. Zeros when singular.
    #[inline]
    pub fn transfer(&self, vertex: usize, out: &mut [Mat2; N]) {
        for i in 0..N {
            out[i] = Mat2::ZERO;
        }
        if self.singular || vertex > self.len {
            return;
        }
        let mut t = Mat2::IDENTITY;
        if vertex < N {
            out[vertex] = t;
        }
        let mut i = vertex.min(N);
        while i > 0 {
            i -= 1;
            t = -block_of(self.upper[i]) * t;
            out[i] = t;
        }
    }

    /// The determinant of T_row = dx_row / dx_vertex, `prod det C_i / det L_i`: it keeps its precision where the elements of
    /// the matrix cancel, and its range where they overflow. `c` is what was factored. Zero when singular.
    #[inline]
    pub fn transfer_determinant(&self, c: &[Mat2], row: usize, vertex: usize) -> Scaled {
        if self.singular || vertex > self.len || vertex > c.len() {
            return Scaled::ZERO;
        }
        let (mut above, mut below) = (Scaled::ONE, Scaled::ONE);
        for i in row..vertex.min(N) {
            above = above.times(determinant2(c[i]));
            below = below.times(self.pivot[i]);
        }
        above.over(below)
    }

    /// det L_row, zero when singular.
    #[inline]
    pub fn pivot_determinant(&self, row: usize) -> Scaled {
        if self.singular || row >= self.len.min(N) {
            return Scaled::ZERO;
        }
        Scaled::ONE.times(self.pivot[row])
    }

    /// Estimate of the condition in the 1-norm, `|J| |J^-1|`, from below and rarely off by more than a factor of three
    /// (Hager 1984, "Condition Estimates"); `a`, `b`, `c` are what was factored. [`f32::MAX`] when singular.
    #[inline]
    pub fn condition(&self, a: &[Mat2], b: &[Mat2], c: &[Mat2]) -> f32 {
        let n = self.len.min(N);
        if self.singular || n > a.len() || n > b.len() || n > c.len() {
            return f32::MAX;
        }
        if n == 0 {
            return 1.0;
        }
        let mut x = [Vec2::ZERO; N];
        for i in 0..n {
            x[i] = Vec2::splat(0.5 / n as f32);
        }
        let mut estimate = 0.0;
        let mut round = 0;
        while round < 3 {
            if !self.solve(&mut x) {
                return f32::MAX;
            }
            let mut size = 0.0;
            for i in 0..n {
                size += abs(x[i].x) + abs(x[i].y);
                x[i] = Vec2::new(sign(x[i].x), sign(x[i].y));
            }
            if !(size > estimate) {
                break;
            }
            estimate = size;
            if !self.solve_transposed(&mut x) {
                return f32::MAX;
            }
            let (mut best, mut at, mut second) = (0.0, 0, false);
            for i in 0..n {
                if abs(x[i].x) > best {
                    (best, at, second) = (abs(x[i].x), i, false);
                }
                if abs(x[i].y) > best {
                    (best, at, second) = (abs(x[i].y), i, true);
                }
            }
            for i in 0..n {
                x[i] = if i != at {
                    Vec2::ZERO
                } else if second {
                    Vec2::Y
                } else {
                    Vec2::X
                };
            }
            round += 1;
        }
        let mut norm = 0.0;
        for i in 0..n {
            let above = if i > 0 { c[i - 1] } else { Mat2::ZERO };
            let below = if i + 1 < n { a[i + 1] } else { Mat2::ZERO };
            let sum = column_sums(above) + column_sums(b[i]) + column_sums(below);
            norm = sum.x.max(sum.y).max(norm);
        }
        (estimate * norm).min(f32::MAX)
    }
}

#[inline]
fn sign(x: f32) -> f32 {
    if x < 0.0 { -1.0 } else { 1.0 }
}

#[inline]
fn column_sums(m: Mat2) -> Vec2 {
    Vec2::new(
        abs(m.x_axis.x) + abs(m.x_axis.y),
        abs(m.y_axis.x) + abs(m.y_axis.y),
    )
}
