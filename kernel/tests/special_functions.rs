//! The error function and its relatives, arc tangents and roundings against libm's `f64` ones.

use halflight_kernel::math::float::{atan2, erf, erf_inv, erfc_scaled, exp_m1, floor, ln_1p};

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
fn differences_from_one_are_accurate() {
    for exponent in -300..=180 {
        let magnitude = 10f32.powf(exponent as f32 * 0.01);
        for x in [magnitude, -magnitude] {
            let want = libm::expm1(f64::from(x));
            let error = (f64::from(exp_m1(x)) - want).abs();
            assert!(error <= 3e-7 * want.abs(), "exp_m1({x}): {error:e}");
            if x > -1.0 {
                let want = libm::log1p(f64::from(x));
                let error = (f64::from(ln_1p(x)) - want).abs();
                assert!(error <= 3e-7 * want.abs(), "ln_1p({x}): {error:e}");
            }
        }
    }
    assert_eq!((exp_m1(0.0), ln_1p(0.0)), (0.0, 0.0));
    assert_eq!((exp_m1(1e-30), ln_1p(1e-30)), (1e-30, 1e-30));
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

#[test]
fn atan2_is_accurate_in_every_quadrant() {
    for i in 1..=4000 {
        let angle = (f64::from(i) / 2000.0 - 1.0) * core::f64::consts::PI;
        for length in [1e-30, 0.3, 1.0, 7e20] {
            let (y, x) = (
                (libm::sin(angle) * length) as f32,
                (libm::cos(angle) * length) as f32,
            );
            let want = libm::atan2(f64::from(y), f64::from(x));
            let error = (f64::from(atan2(y, x)) - want).abs();
            assert!(error <= 3e-7 * want.abs(), "atan2({y}, {x}): {error:e}");
        }
    }
    assert_eq!(atan2(0.0, 0.0), 0.0);
    assert_eq!(atan2(0.0, -1.0), core::f32::consts::PI);
}

#[test]
fn floor_is_exact() {
    for i in -4000..=4000 {
        let x = i as f32 * 0.25;
        assert_eq!(floor(x), libm::floorf(x), "{x}");
    }
    for x in [
        8_388_607.5,
        -8_388_607.5,
        8_388_609.0,
        1e30,
        -1e30,
        -1e-30,
        f32::INFINITY,
    ] {
        assert_eq!(floor(x), libm::floorf(x), "{x}");
    }
    assert!(floor(f32::NAN).is_nan());
}
