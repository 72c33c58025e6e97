//! The exponential, the logarithm, powers and the functions of angles against libm's `f64` ones, over their whole domains.

use halflight_kernel::math::float::{
    atan, cos, exp, ln, pow, sin, sin_cos, sin_cos_2pi, sin_cos_octant, tan,
};

/// The distance of the floats around a number, as if there were no subnormal ones.
fn ulp(x: f64) -> f64 {
    let x = x.abs().max(f64::from(f32::MIN_POSITIVE));
    2f64.powi(x.log2().floor() as i32 - 23)
}

/// Every `step`th float from `low` to `high`, both at least zero, with both ends.
fn floats(low: f32, high: f32, step: usize) -> impl Iterator<Item = f32> {
    let bits = low.to_bits()..high.to_bits();
    bits.step_by(step).map(f32::from_bits).chain([high])
}

/// The largest error in ulp.
fn largest(
    arguments: impl Iterator<Item = f32>,
    found: impl Fn(f32) -> f32,
    expected: impl Fn(f64) -> f64,
) -> (f64, f32) {
    arguments.fold((0.0, 0.0), |worst, x| {
        let want = expected(f64::from(x));
        let error = (f64::from(found(x)) - want).abs() / ulp(want);
        if error > worst.0 || error.is_nan() {
            (error, x)
        } else {
            worst
        }
    })
}

macro_rules! assert_within {
    ($bound:literal, $errors:expr) => {
        let (error, x) = $errors;
        assert!(error <= $bound, "{error} ulp at {x:e}");
    };
}

#[test]
fn exponentials_are_accurate() {
    let negative = floats(1e-9, 87.33654, 733).map(|x| -x);
    assert_within!(1.3, largest(negative, exp, libm::exp));
    assert_within!(1.3, largest(floats(1e-9, 88.72283, 733), exp, libm::exp));
    assert_eq!((exp(0.0), exp(-0.0), exp(1e-30)), (1.0, 1.0, 1.0));
    assert_eq!(
        (exp(-87.33655), exp(-1e30), exp(-f32::INFINITY)),
        (0.0, 0.0, 0.0)
    );
    assert!(exp(-87.33654) >= f32::MIN_POSITIVE && exp(88.72283) < f32::INFINITY);
    for x in [88.72284, 1e30, f32::INFINITY] {
        assert_eq!(exp(x), f32::INFINITY, "{x}");
    }
    assert!(exp(f32::NAN).is_nan() && exp(f32::from_bits(0xffc0_1234)).is_nan());
}

#[test]
fn logarithms_are_accurate() {
    assert_within!(
        1.0,
        largest(floats(f32::MIN_POSITIVE, f32::MAX, 1511), ln, libm::log)
    );
    assert_within!(1.0, largest(floats(0.6, 1.4, 13), ln, libm::log));
    // What devices may take as zero.
    assert_within!(
        1.0,
        largest(floats(1e-45, f32::MIN_POSITIVE, 97), ln, libm::log)
    );
    assert_eq!(
        (ln(1.0), ln(0.0), ln(-0.0)),
        (0.0, -f32::INFINITY, -f32::INFINITY)
    );
    assert_eq!(ln(f32::INFINITY), f32::INFINITY);
    for x in [-1e-45, -1.0, -f32::INFINITY, f32::NAN, -f32::NAN] {
        assert!(ln(x).is_nan(), "{x}");
    }
}

#[test]
fn powers_are_accurate() {
    for y in [
        1e-3,
        0.1,
        1.0 / 3.0,
        0.5,
        1.0,
        2.0,
        3.7,
        8.0,
        50.0,
        1e3,
        1e6f32,
    ] {
        // As far as neither sign of y leads beyond the range of normal numbers.
        let reach = (87.3 / f64::from(y)).min(87.3).exp() as f32;
        for y in [y, -y] {
            let raised = |x: f64| libm::pow(x, f64::from(y));
            let bases = || floats(1.0 / reach, reach, if y.abs() < 100.0 { 5003 } else { 29 });
            let (error, x) = largest(bases(), |x| pow(x, y), raised);
            assert!(error <= 2.0, "{error} ulp at {x:e}^{y}");
        }
    }
    for x in [0.0, -1.0, f32::NAN, 1e-40, -f32::INFINITY] {
        assert_eq!(
            (pow(x, 0.5), pow(x, -0.5), pow(x, 0.0)),
            (0.0, f32::INFINITY, 1.0),
            "{x}"
        );
    }
    for y in [-3.0, -0.0, 0.0, 1e-30, 1e30f32] {
        assert_eq!(pow(1.0, y), 1.0, "{y}");
    }
    assert_eq!(
        (pow(f32::INFINITY, 2.0), pow(f32::INFINITY, -2.0)),
        (f32::INFINITY, 0.0)
    );
    assert_eq!(
        (pow(2.0, 127.0), pow(2.0, -125.0)),
        (2f32.powi(127), 2.0 * f32::MIN_POSITIVE)
    );
    assert_eq!((pow(2.0, 128.0), pow(2.0, -127.0)), (f32::INFINITY, 0.0));
    assert_eq!((pow(0.5, 1e30), pow(0.5, -1e30)), (0.0, f32::INFINITY));
    assert!(pow(2.0, f32::NAN).is_nan());
}

#[test]
fn angles_are_accurate() {
    const TWO_TURNS: f32 = 12.566_371;
    for sign in [1.0, -1.0] {
        let angles = || floats(1e-9, TWO_TURNS, 307).map(|x| sign * x);
        assert_within!(1.6, largest(angles(), sin, libm::sin));
        assert_within!(1.6, largest(angles(), cos, libm::cos));
        assert_within!(4.0, largest(angles(), tan, libm::tan));
    }
    // The floats next to multiples of a right angle, where one of the two nearly vanishes.
    for quarters in -8..=8 {
        let near = (core::f64::consts::FRAC_PI_2 * f64::from(quarters)) as f32;
        for x in [near.next_down(), near, near.next_up()] {
            assert_within!(2.5, largest([x].into_iter(), sin, libm::sin));
            assert_within!(2.5, largest([x].into_iter(), cos, libm::cos));
        }
    }
    assert_eq!(sin_cos(0.0), (0.0, 1.0));
    assert_eq!(sin_cos(1e-30), (1e-30, 1.0));
    assert!(sin(f32::NAN).is_nan() && cos(f32::NAN).is_nan());
}

#[test]
fn fractions_of_turns_are_accurate() {
    let turns = |x: f64| core::f64::consts::TAU * x;
    for sign in [1.0, -1.0] {
        let fractions = || floats(1e-9, 1.0, 307).map(|x| sign * x);
        let (s, c) = (|x| sin_cos_2pi(x).0, |x| sin_cos_2pi(x).1);
        // The reference's own angle is rounded: next to its zeros the comparison is of the angle's remainder.
        assert_within!(
            2.5,
            largest(fractions(), s, |x| libm::sin(turns(x - x.round())))
        );
        let quarter = |x: f64| libm::sin(turns(0.25 - (x - x.round()).abs()));
        assert_within!(2.5, largest(fractions(), c, quarter));
        let octant = || floats(1e-9, core::f32::consts::FRAC_PI_4, 307).map(|x| sign * x);
        assert_within!(1.5, largest(octant(), |x| sin_cos_octant(x).0, libm::sin));
        assert_within!(1.5, largest(octant(), |x| sin_cos_octant(x).1, libm::cos));
    }
    for (turns, want) in [
        (0.0, (0.0, 1.0)),
        (0.25, (1.0, 0.0)),
        (0.5, (0.0, -1.0)),
        (0.75, (-1.0, 0.0)),
        (-0.25, (-1.0, 0.0)),
        (1.0, (0.0, 1.0)),
        (1_048_576.0, (0.0, 1.0)),
    ] {
        assert_eq!(sin_cos_2pi(turns), want, "{turns}");
    }
}

#[test]
fn large_angles_lose_no_more_than_their_last_bit() {
    let assert_near = |x: f32, allowed: f64| {
        let (s, c) = sin_cos(x);
        let y = f64::from(x);
        let error = (f64::from(s) - libm::sin(y))
            .abs()
            .max((f64::from(c) - libm::cos(y)).abs());
        assert!(error <= allowed, "{error:e} at {x}");
    };
    for x in floats(1.0, 3e3, 173) {
        assert_near(x, 1e-7);
        assert_near(-x, 1e-7);
    }
    for x in floats(3e3, 1e6, 173) {
        assert_near(x, 1e-7 + ulp(f64::from(x)));
    }
    for x in [1e6f32, 1.1e6, 1e30, f32::MAX, f32::INFINITY] {
        assert_eq!(sin_cos(x), sin_cos(1e6), "{x}");
        assert_eq!(sin_cos(-x), sin_cos(-1e6), "{x}");
    }
}

#[test]
fn arc_tangents_are_accurate() {
    for sign in [1.0, -1.0] {
        let tangents = floats(f32::MIN_POSITIVE, f32::MAX, 1511).map(|x| sign * x);
        assert_within!(4.0, largest(tangents, atan, libm::atan));
    }
    assert_eq!(atan(0.0), 0.0);
    assert_eq!(atan(f32::INFINITY), core::f32::consts::FRAC_PI_2);
}
