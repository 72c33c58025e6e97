//! The block LU against dense elimination in f64.

#[path = "common/block_systems.rs"]
mod block_systems;
#[path = "common/dense.rs"]
mod dense;
#[path = "common/primitives.rs"]
mod primitives;

use block_systems::{N, ROUNDING, backward_error, system};
use dense::{block, size};
use glam::{Mat2, Vec2};
use halflight_kernel::math::block::invert;
use halflight_kernel::math::block_tridiagonal::BlockLu;
use halflight_kernel::math::scaled::Scaled;
use primitives::runner;
use proptest::prelude::*;
use std::cell::Cell;

/// The backward error of solutions, plain and transposed, stays below 8 roundings times the growth; that of
/// well-behaved systems below 30 roundings.
#[test]
fn solutions_have_a_small_backward_error() {
    let (worst, worst_tame) = (Cell::new(0.0f64), Cell::new(0.0f64));
    runner(4000)
        .run(&system(), |s| {
            let lu = s.factor();
            prop_assume!(!lu.is_singular());
            let growth = s.growth();
            for transposed in [false, true] {
                let mut x = s.h;
                let solved = if transposed {
                    lu.solve_transposed(&mut x)
                } else {
                    lu.solve(&mut x)
                };
                prop_assert!(solved);
                let backward = backward_error(&s, &x, transposed);
                worst.set(worst.get().max(backward / growth));
                if growth < 100.0 {
                    worst_tame.set(worst_tame.get().max(backward));
                }
                prop_assert!(
                    backward < 8.0 * growth,
                    "{backward} roundings, growth {growth}"
                );
            }
            Ok(())
        })
        .unwrap();
    let (worst, worst_tame) = (worst.get(), worst_tame.get());
    assert!(
        worst_tame > 0.0 && worst_tame < 30.0,
        "{worst_tame} roundings"
    );
    println!("backward error: {worst_tame:.1} roundings, {worst:.2} of the growth");
}

/// Determinant with sign, inverse rows and transfer matrices, within the condition's error.
#[test]
fn determinant_inverse_rows_and_transfer_agree_with_a_dense_inverse() {
    runner(3000)
        .run(&(system(), 0usize..N), |(s, row)| {
            let lu = s.factor();
            prop_assume!(!lu.is_singular());
            let dense = s.dense();
            let (inverse, ln_determinant, sign) = dense.inverse();
            let condition = dense.norm() * inverse.norm();
            let tolerance = ROUNDING * 16.0 * condition.max(s.growth());
            prop_assume!(tolerance < 0.05);

            let found = lu.determinant();
            let ln = f64::from(found.ln_abs());
            let error = (ln - ln_determinant).abs();
            prop_assert!(
                error < tolerance + 2e-7 * (1.0 + ln.abs()),
                "ln det off by {error}"
            );
            prop_assert_eq!(f64::from(found.sign()), sign);

            let row = row % s.n;
            let mut out = [Mat2::ZERO; N];
            lu.row_of_inverse(row, &mut out);
            for i in 0..s.n {
                let e = size(block(out[i]) - inverse.get(row, i));
                prop_assert!(e <= tolerance * inverse.norm());
            }
            lu.last_row_of_inverse(&mut out);
            for i in 0..s.n {
                let e = size(block(out[i]) - inverse.get(s.n - 1, i));
                prop_assert!(e <= tolerance * inverse.norm());
            }
            // T_i = -(J^-1)_{i, n-1} C_{n-1}.
            let coupling = block(s.c[s.n - 1]);
            lu.transfer(s.n, &mut out);
            let scale = inverse.norm() * size(coupling);
            for i in 0..s.n {
                let expected = -(inverse.get(i, s.n - 1) * coupling);
                prop_assert!(size(block(out[i]) - expected) <= tolerance * 4.0 * scale);
            }
            // The transfer's determinant as a product, against one of the matrix where that is well conditioned.
            let expected = (inverse.get(0, s.n - 1) * coupling).determinant();
            let product = f64::from(lu.transfer_determinant(&s.c, 0, s.n).ln_abs());
            if expected.abs() > 1e-3 * size(inverse.get(0, s.n - 1) * coupling).powi(2) {
                let error = (product - expected.abs().ln()).abs();
                prop_assert!(
                    error < 4e3 * tolerance + 1e-5,
                    "{error}, tolerance {tolerance}"
                );
            }
            Ok(())
        })
        .unwrap();
}

/// The estimate is a lower bound and within a factor of ten, mostly within three.
#[test]
fn condition_estimate_is_close() {
    let near = Cell::new((0, 0));
    runner(1000)
        .run(&system(), |s| {
            let lu = s.factor();
            prop_assume!(!lu.is_singular());
            let dense = s.dense();
            let exact = dense.column_norm() * dense.inverse().0.column_norm();
            prop_assume!(exact * ROUNDING < 1e-3 && s.growth() * ROUNDING < 1e-3);
            let ratio = f64::from(lu.condition(&s.a, &s.b, &s.c)) / exact;
            prop_assert!(ratio < 1.05, "estimate is {ratio} of the condition");
            prop_assert!(ratio > 0.1, "estimate is {ratio} of the condition");
            let (hits, all) = near.get();
            near.set((hits + u32::from(ratio > 1.0 / 3.0), all + 1));
            Ok(())
        })
        .unwrap();
    let near = near.get();
    assert!(near.1 > 500 && near.0 * 100 > near.1 * 98, "{near:?}");
}

/// Singular and hopeless input: flagged, zeros everywhere.
#[test]
fn singular_systems_are_refused() {
    let one = [Mat2::IDENTITY; 3];
    let refused = |a: &[Mat2], b: &[Mat2], c: &[Mat2], n| {
        let lu: BlockLu<4> = BlockLu::factor(a, b, c, n);
        let mut x = [Vec2::ONE; 4];
        let mut rows = [Mat2::IDENTITY; 4];
        assert!(!lu.solve(&mut x) && x == [Vec2::ZERO; 4]);
        lu.row_of_inverse(0, &mut rows);
        assert_eq!(rows, [Mat2::ZERO; 4]);
        lu.transfer(n, &mut rows);
        assert_eq!(rows, [Mat2::ZERO; 4]);
        assert_eq!(lu.condition(a, b, c), f32::MAX);
        lu.is_singular() && lu.determinant() == Scaled::ZERO
    };
    let parallel = Mat2::from_cols(Vec2::new(1.0, 2.0), Vec2::new(3.0, 6.0));
    assert!(refused(
        &one,
        &[one[0], parallel * 1e9, one[0]],
        &[Mat2::ZERO; 3],
        3
    ));
    // A Schur complement that vanishes, 1 - 1 1 1, and one that is rounding.
    assert!(refused(&one, &one, &one, 2));
    assert!(refused(
        &one,
        &[one[0], one[0] * (1.0 + f32::EPSILON)],
        &one,
        2
    ));
    for bad in [f32::NAN, f32::INFINITY, 0.0] {
        let zero = [Mat2::ZERO; 3];
        assert!(refused(&zero, &[one[0], one[0] * bad], &one, 2));
    }
    assert!(refused(&[one[0], one[0] * f32::NAN], &one, &one, 2));
    assert!(refused(&one, &one, &one, 4));
    assert!(!BlockLu::<4>::factor(&one, &one, &[Mat2::ZERO; 3], 3).is_singular());
    let empty: BlockLu<4> = BlockLu::factor(&one, &one, &one, 0);
    assert!(!empty.is_singular() && empty.determinant() == Scaled::ONE);
}

/// A block's inverse is exact to rounding at any scale of its own, and refused where it is all rounding.
#[test]
fn blocks_invert_at_any_scale() {
    let entries = prop::array::uniform4(-1.0f32..1.0);
    runner(4000)
        .run(&(entries, -12i32..12), |(m, power)| {
            let m = Mat2::from_cols_array(&m) * 10.0f32.powi(power);
            let exact = block(m);
            let condition = size(exact) * size(exact.inverse());
            let inverse = invert(m);
            if condition > 4e7 {
                prop_assert!(inverse.determinant == 0.0);
            } else if condition < 1e6 {
                let e = size(block(inverse.inverse) - exact.inverse()) / size(exact.inverse());
                prop_assert!(e < 8.0 * ROUNDING * condition + 4.0 * ROUNDING);
                let d = f64::from(inverse.determinant);
                prop_assert!((d / exact.determinant() - 1.0).abs() < 4.0 * ROUNDING * condition);
            }
            Ok(())
        })
        .unwrap();
}

/// Products in scaled form: each factor rounds once.
#[test]
fn scaled_products_keep_precision_and_range() {
    let factors = prop::collection::vec((any::<bool>(), -80.0f32..80.0), 1..96);
    runner(4000)
        .run(&factors, |factors| {
            let (mut product, mut ln, mut sign) = (Scaled::ONE, 0.0f64, 1.0);
            for (negative, e) in &factors {
                let f = e.exp() * if *negative { -1.0 } else { 1.0 };
                product = product.times(f);
                ln += f64::from(f).abs().ln();
                sign *= f64::from(f).signum();
            }
            let m = f64::from(product.mantissa).abs();
            prop_assert!((1.0..2.0).contains(&m));
            let found = m.ln() + f64::from(product.exponent) * std::f64::consts::LN_2;
            prop_assert!((found - ln).abs() < ROUNDING * 96.0 + 1e-11 * ln.abs());
            prop_assert_eq!(f64::from(product.sign()), sign);
            let value = f64::from(product.value());
            if ln.abs() < 80.0 {
                prop_assert!((value * sign / ln.exp() - 1.0).abs() < 1e-5);
            }
            prop_assert!(value.is_finite());
            prop_assert_eq!(product.over(product), Scaled::ONE);
            Ok(())
        })
        .unwrap();
    for bad in [0.0, f32::NAN, f32::INFINITY, 1e-40] {
        assert_eq!(Scaled::ONE.times(bad), Scaled::ZERO);
    }
}
