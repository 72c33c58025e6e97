//! Random block-tridiagonal systems and the backward error of their solutions.

// Each test file uses its part.
#![allow(dead_code)]

use crate::dense::{Dense, block, size};
use glam::{DMat2, Mat2, Vec2};
use halflight_kernel::math::block_tridiagonal::BlockLu;
use proptest::prelude::*;

/// Capacity of the tests.
pub const N: usize = 32;

/// Half a unit in the last place of one.
pub const ROUNDING: f64 = 0.5 * f32::EPSILON as f64;

#[derive(Clone, Debug)]
pub struct System {
    pub a: [Mat2; N],
    pub b: [Mat2; N],
    pub c: [Mat2; N],
    pub h: [Vec2; N],
    pub n: usize,
}

impl System {
    pub fn dense(&self) -> Dense {
        let blocks = |m: &[Mat2]| m.iter().map(|m| block(*m)).collect::<Vec<_>>();
        Dense::from_blocks(&blocks(&self.a), &blocks(&self.b), &blocks(&self.c), self.n)
    }

    pub fn factor(&self) -> BlockLu<N> {
        BlockLu::factor(&self.a, &self.b, &self.c, self.n)
    }

    /// Norm of |L||U| over that of J in exact arithmetic: what elimination without pivoting across blocks may lose.
    pub fn growth(&self) -> f64 {
        self.eliminate(self.n).0 / self.largest_block()
    }

    /// The same for elimination from both ends, which meet in row n / 2.
    pub fn two_ended_growth(&self) -> f64 {
        let middle = self.n / 2;
        let (top, carried) = self.eliminate(middle);
        let (bottom, from_below) = self.reversed().eliminate(self.n - 1 - middle);
        let pivot = block(self.b[middle]) - carried - from_below;
        let outer = 2.0 * (size(carried) + size(from_below));
        let own = size(pivot) * (4.0 + size(pivot) * size(pivot.inverse()));
        top.max(bottom).max(outer + own) / self.largest_block()
    }

    /// Norm of |L||U| over the first rows, and A U of the next one.
    fn eliminate(&self, rows: usize) -> (f64, DMat2) {
        let (mut largest, mut upper) = (0.0f64, DMat2::ZERO);
        let below = |i: usize| if i > 0 { block(self.a[i]) } else { DMat2::ZERO };
        for i in 0..rows {
            let a = below(i);
            let pivot = block(self.b[i]) - a * upper;
            let condition = size(pivot) * size(pivot.inverse());
            let next = pivot.inverse() * block(self.c[i]);
            largest = largest.max(
                2.0 * size(a) * (1.0 + size(upper))
                    + 4.0 * size(pivot) * (1.0 + size(next))
                    + size(pivot) * condition * (1.0 + size(next)),
            );
            upper = next;
        }
        (largest, below(rows % N) * upper)
    }

    /// The system upside down.
    fn reversed(&self) -> System {
        let mut reversed = self.clone();
        for i in 0..self.n {
            let j = self.n - 1 - i;
            (reversed.a[i], reversed.c[i]) = (self.c[j], self.a[j]);
            (reversed.b[i], reversed.h[i]) = (self.b[j], self.h[j]);
        }
        reversed
    }

    fn largest_block(&self) -> f64 {
        (0..self.n)
            .flat_map(|i| [self.a[i] * (i.min(1) as f32), self.b[i], self.c[i]])
            .fold(0.0, |s, m| s.max(size(block(m))))
    }
}

/// Residual of a solution over what it is made of, in roundings.
pub fn backward_error(system: &System, x: &[Vec2; N], transposed: bool) -> f64 {
    let flat = |v: &[Vec2; N]| -> Vec<f64> {
        let numbers = v[..system.n].iter().flat_map(|v| [v.x, v.y]);
        numbers.map(f64::from).collect()
    };
    let dense = system.dense();
    let mut m = dense.clone();
    if transposed {
        for i in 0..m.n {
            for j in 0..m.n {
                m.m[i * m.n + j] = dense.m[j * m.n + i];
            }
        }
    }
    let largest = |v: &[f64]| v.iter().fold(0.0f64, |s, x| s.max(x.abs()));
    let (x, right) = (flat(x), flat(&system.h));
    let product = m.times(&x);
    let residual: Vec<f64> = product.iter().zip(&right).map(|(a, b)| a - b).collect();
    largest(&residual) / (m.norm() * largest(&x) + largest(&right)) / ROUNDING
}

fn blocks() -> impl Strategy<Value = [Mat2; N]> {
    prop::collection::vec(prop::array::uniform4(-1.0f32..1.0), N)
        .prop_map(|v| std::array::from_fn(|i| Mat2::from_cols_array(&v[i])))
}

/// Random blocks; the diagonal may be weighted, and everything scaled by powers of ten.
pub fn system() -> impl Strategy<Value = System> {
    (
        blocks(),
        blocks(),
        blocks(),
        prop::collection::vec(prop::array::uniform2(-1.0f32..1.0), N),
        1usize..=N,
        prop::sample::select(vec![1.0f32, 4.0]),
        -6i32..6,
    )
        .prop_map(|(a, b, c, h, n, weight, power)| {
            let scale = 10.0f32.powi(power);
            let scaled = |m: [Mat2; N], s: f32| m.map(|m| m * s);
            let mut right = [Vec2::ZERO; N];
            for i in 0..n {
                right[i] = Vec2::from_array(h[i]);
            }
            System {
                a: scaled(a, scale),
                b: scaled(b, scale * weight),
                c: scaled(c, scale),
                h: right,
                n,
            }
        })
}
