//! Elimination from both ends against f64 and against the factors.

#[path = "common/block_systems.rs"]
mod block_systems;
#[path = "common/dense.rs"]
mod dense;
#[path = "common/primitives.rs"]
mod primitives;

use block_systems::{N, ROUNDING, System, backward_error, system};
use glam::{Mat2, Vec2};
use halflight_kernel::math::block_elimination::solve;
use primitives::runner;
use proptest::prelude::*;
use std::cell::Cell;

fn solution(s: &System) -> (bool, [Vec2; N]) {
    let mut x = s.h;
    let solved = solve(&s.a, &s.b, &s.c, s.n, &mut x);
    (solved, x)
}

/// The backward error stays below 8 roundings times the growth; that of well-behaved systems below 30 roundings.
#[test]
fn solutions_have_a_small_backward_error() {
    let (worst, worst_tame, refused) = (Cell::new(0.0f64), Cell::new(0.0f64), Cell::new(0));
    runner(6000)
        .run(&system(), |s| {
            let (solved, x) = solution(&s);
            let growth = s.two_ended_growth();
            if !solved {
                refused.set(refused.get() + 1);
                prop_assert!(growth > 1e6, "refused at a growth of {growth}");
                prop_assert_eq!(x, [Vec2::ZERO; N]);
                return Ok(());
            }
            let backward = backward_error(&s, &x, false);
            worst.set(worst.get().max(backward / growth));
            if growth < 100.0 {
                worst_tame.set(worst_tame.get().max(backward));
            }
            prop_assert!(
                backward < 8.0 * growth,
                "{backward} roundings, growth {growth}"
            );
            Ok(())
        })
        .unwrap();
    let (worst, worst_tame) = (worst.get(), worst_tame.get());
    assert!(
        worst_tame > 0.0 && worst_tame < 30.0,
        "{worst_tame} roundings"
    );
    println!(
        "backward error: {worst_tame:.1} roundings, {worst:.2} of the growth, {} refused",
        refused.get()
    );
}

/// The same solution as by the factors, within the condition's error. What lies beyond the rows is not read or written.
#[test]
fn solutions_agree_with_the_factors() {
    let compared = Cell::new(0);
    runner(3000)
        .run(&system(), |mut s| {
            let lu = s.factor();
            let mut expected = s.h;
            let factored = lu.solve(&mut expected);
            let beyond = Vec2::new(3.0, 4.0);
            s.a[0] = Mat2::NAN;
            s.c[s.n - 1] = Mat2::NAN;
            for i in s.n..N {
                (s.a[i], s.b[i], s.c[i], s.h[i]) = (Mat2::NAN, Mat2::NAN, Mat2::NAN, beyond);
            }
            let (solved, x) = solution(&s);
            s.a[0] = Mat2::ZERO;
            let dense = s.dense();
            let condition = dense.norm() * dense.inverse().0.norm();
            let growth = s.growth().max(s.two_ended_growth());
            let tolerance = ROUNDING * 16.0 * condition * growth;
            prop_assume!(tolerance < 0.05);
            prop_assert!(factored && solved);
            let size = |v: &[Vec2]| v.iter().fold(0.0f32, |s, v| s.max(v.length()));
            for i in 0..s.n {
                let error = f64::from((x[i] - expected[i]).length());
                let scale = f64::from(size(&expected[..s.n]));
                prop_assert!(error <= tolerance * scale, "{error} at {i} of {}", s.n);
            }
            prop_assert!(x[s.n..].iter().all(|v| *v == beyond));
            compared.set(compared.get() + 1);
            Ok(())
        })
        .unwrap();
    assert!(compared.get() > 1000, "{}", compared.get());
}

/// Singular and hopeless input, in each place: false and zeros.
#[test]
fn singular_systems_are_refused() {
    let one = [Mat2::IDENTITY; 6];
    let zero = [Mat2::ZERO; 6];
    let check = |a: &[Mat2; 6], b: &[Mat2; 6], c: &[Mat2; 6], n| {
        let mut x = [Vec2::ONE; 6];
        let solved = solve(a, b, c, n, &mut x);
        assert!(solved || x == [Vec2::ZERO; 6]);
        assert!(x.iter().all(|v| v.is_finite()));
        solved
    };
    let parallel = Mat2::from_cols(Vec2::new(1.0, 2.0), Vec2::new(3.0, 6.0));
    for n in 1..=6 {
        assert!(check(&zero, &one, &zero, n));
        for at in 0..n {
            let singular = [parallel * 1e9, parallel * 1e-9, Mat2::ZERO];
            let hopeless = [1e16, 1e-16, f32::NAN, f32::INFINITY, -f32::INFINITY];
            for bad in singular.into_iter().chain(hopeless.map(|x| one[0] * x)) {
                let mut b = one;
                b[at] = bad;
                assert!(!check(&zero, &b, &zero, n), "{bad} at {at} of {n}");
            }
            // Couplings and right-hand sides.
            for bad in [f32::NAN, f32::INFINITY] {
                let mut m = zero;
                m[at] = one[0] * bad;
                assert!(at == 0 || !check(&m, &one, &zero, n));
                assert!(at + 1 == n || !check(&zero, &one, &m, n));
                let mut x = [Vec2::ONE; 6];
                x[at] = Vec2::new(1.0, bad);
                assert!(!solve(&zero, &one, &zero, n, &mut x) && x == [Vec2::ZERO; 6]);
            }
        }
        // A Schur complement that vanishes where the ends meet, and one that is rounding.
        if n == 2 || n == 3 {
            let mut b = one;
            b[n / 2] *= (n - 1) as f32;
            assert!(!check(&one, &b, &one, n));
            b[n / 2] *= 1.0 + f32::EPSILON;
            assert!(!check(&one, &b, &one, n));
        }
    }
    // No rows are no unknowns; more than the capacity are refused.
    let mut x = [Vec2::ONE; 6];
    assert!(solve(&one, &one, &one, 0, &mut x) && x == [Vec2::ONE; 6]);
    for n in [7, 12, usize::MAX] {
        x = [Vec2::ONE; 6];
        assert!(!solve(&one, &one, &one, n, &mut x) && x == [Vec2::ZERO; 6]);
    }
    assert!(!solve(&[], &[], &[], 1, &mut []) && solve(&[], &[], &[], 0, &mut []));
}

/// Any bits: no panic, and finite numbers or zeros.
#[test]
fn any_input_gives_finite_numbers() {
    let bits = prop::collection::vec(any::<u32>(), 14 * 7);
    runner(4000)
        .run(&(bits, 1usize..=7, 0u32..3), |(bits, n, kind)| {
            let mut at = 0;
            let mut next = || {
                at += 1;
                let word = bits[at - 1];
                match kind {
                    0 => f32::from_bits(word),
                    // Powers of two between 2^-64 and 2^63, and few different numbers.
                    1 => f32::from_bits((63 + word % 128) << 23),
                    _ => (word % 3) as f32 - 1.0,
                }
            };
            let mut block = || Mat2::from_cols_array(&[next(), next(), next(), next()]);
            let a: [Mat2; 7] = std::array::from_fn(|_| block());
            let b: [Mat2; 7] = std::array::from_fn(|_| block());
            let c: [Mat2; 7] = std::array::from_fn(|_| block());
            let mut x: [Vec2; 7] = std::array::from_fn(|_| Vec2::new(next(), next()));
            if kind > 0 {
                prop_assert!(x.iter().all(|v| v.is_finite()));
            }
            let solved = solve(&a, &b, &c, n, &mut x);
            prop_assert!(x[..n].iter().all(|v| v.is_finite()));
            prop_assert!(solved || x == [Vec2::ZERO; 7]);
            Ok(())
        })
        .unwrap();
}
