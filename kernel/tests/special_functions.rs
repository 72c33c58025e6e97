//! The error function and its relatives against libm's `f64` ones.

use halflight_kernel::math::float::{erf, erf_inv, erfc_scaled};

#[test]
fn erf_is_accurate() {
    assert_eq!(erf(0.0), 0.0);
    for i in -6000..=6000 {
        let x = i as f32 * 1e-3;
        let want = libm::erf(f64::from(x));
        let error = (f64::from(erf(x)) - want).abs();
        assert!(error <= 3e-7 * want.abs(), "erf({x}): {error:e}");
    }
    // Arguments beyond the exponential's range.
    assert_eq!((erf(1e30), erf(-1e30)), (1.0, -1.0));
}

#[test]
fn scaled_complement_is_accurate() {
    for i in 0..=5000 {
        let x = i as f32 * 1e-3;
        let y = f64::from(x);
        let want = libm::exp(y * y) * libm::erfc(y);
        let error = (f64::from(erfc_scaled(x)) / want - 1.0).abs();
        assert!(error <= 4e-7, "erfc_scaled({x}): {error:e}");
    }
    // Asymptotically 1 / (x sqrt(pi)).
    let far = f64::from(erfc_scaled(1e6)) * 1e6 * core::f64::consts::PI.sqrt();
    assert!((far - 1.0).abs() < 1e-6);
}

#[test]
fn erf_inv_is_an_inverse() {
    // The derivative of erf amplifies: the comparison is in x, at arguments that f32 holds exactly.
    for i in -9999..=9999 {
        let y = i as f32 * 1e-4;
        check_inverse(y);
    }
    for i in 1..24 {
        check_inverse(1.0 - 0.5_f32.powi(i));
        check_inverse(0.5_f32.powi(i));
    }
    assert!(erf_inv(1.0) < 3.84 && erf_inv(-1.0) > -3.84);
}

fn check_inverse(y: f32) {
    let x = f64::from(erf_inv(y));
    // One Newton step in f64 gives the true inverse next to x; the complement keeps its digits near 1.
    let residual = if y >= 0.0 {
        (1.0 - f64::from(y)) - libm::erfc(x)
    } else {
        libm::erfc(-x) - (1.0 + f64::from(y))
    };
    let step = residual * core::f64::consts::PI.sqrt() / 2.0 * libm::exp(x * x);
    assert!(
        step.abs() <= 4e-6 * x.abs(),
        "erf_inv({y}) = {x}, off by {step:e}"
    );
}
