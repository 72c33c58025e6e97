//! Dense linear algebra in f64, as the reference of the block solver.

// Each test file uses its part.
#![allow(dead_code)]

use glam::{DMat2, DVec2, Mat2};

/// A square matrix by rows.
#[derive(Clone, Debug)]
pub struct Dense {
    pub n: usize,
    pub m: Vec<f64>,
}

/// The block in f64.
pub fn block(m: Mat2) -> DMat2 {
    m.as_dmat2()
}

impl Dense {
    /// Zeros.
    pub fn zeros(n: usize) -> Dense {
        Dense {
            n,
            m: vec![0.0; n * n],
        }
    }

    /// The block-tridiagonal matrix of `n` block rows.
    pub fn from_blocks(a: &[DMat2], b: &[DMat2], c: &[DMat2], n: usize) -> Dense {
        let mut d = Dense::zeros(2 * n);
        for i in 0..n {
            d.set(i, i, b[i]);
            if i > 0 {
                d.set(i, i - 1, a[i]);
            }
            if i + 1 < n {
                d.set(i, i + 1, c[i]);
            }
        }
        d
    }

    /// Sets a 2x2 block.
    pub fn set(&mut self, i: usize, j: usize, block: DMat2) {
        for r in 0..2 {
            for c in 0..2 {
                self.m[(2 * i + r) * self.n + 2 * j + c] = block.col(c)[r];
            }
        }
    }

    /// A 2x2 block.
    pub fn get(&self, i: usize, j: usize) -> DMat2 {
        let at = |r: usize, c: usize| self.m[(2 * i + r) * self.n + 2 * j + c];
        DMat2::from_cols(
            DVec2::new(at(0, 0), at(1, 0)),
            DVec2::new(at(0, 1), at(1, 1)),
        )
    }

    /// Largest absolute row sum.
    pub fn norm(&self) -> f64 {
        self.m
            .chunks(self.n)
            .map(|row| row.iter().map(|x| x.abs()).sum())
            .fold(0.0, f64::max)
    }

    /// Largest absolute column sum.
    pub fn column_norm(&self) -> f64 {
        (0..self.n)
            .map(|j| (0..self.n).map(|i| self.m[i * self.n + j].abs()).sum())
            .fold(0.0, f64::max)
    }

    /// Product with a vector.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        self.m
            .chunks(self.n)
            .map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum())
            .collect()
    }

    /// Inverse, ln |determinant| and its sign by Gauss-Jordan elimination with row pivoting.
    pub fn inverse(&self) -> (Dense, f64, f64) {
        let n = self.n;
        let mut a = self.m.clone();
        let mut inverse = Dense::zeros(n);
        for i in 0..n {
            inverse.m[i * n + i] = 1.0;
        }
        let (mut ln, mut sign) = (0.0, 1.0f64);
        for k in 0..n {
            let pivot = (k..n)
                .max_by(|&i, &j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs()))
                .unwrap();
            if pivot != k {
                sign = -sign;
                for j in 0..n {
                    a.swap(k * n + j, pivot * n + j);
                    inverse.m.swap(k * n + j, pivot * n + j);
                }
            }
            let p = a[k * n + k];
            ln += p.abs().ln();
            sign *= p.signum();
            for j in 0..n {
                a[k * n + j] /= p;
                inverse.m[k * n + j] /= p;
            }
            for i in 0..n {
                let f = a[i * n + k];
                if i != k && f != 0.0 {
                    for j in 0..n {
                        a[i * n + j] -= f * a[k * n + j];
                        inverse.m[i * n + j] -= f * inverse.m[k * n + j];
                    }
                }
            }
        }
        (inverse, ln, sign)
    }
}

/// Largest element's magnitude of a block.
pub fn size(m: DMat2) -> f64 {
    m.to_cols_array().iter().fold(0.0, |s, x| s.max(x.abs()))
}
