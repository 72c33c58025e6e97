//! Frames are orthonormal and right-handed, and their two maps inverse to each other, also where normal and tangent all
//! but coincide.

use glam::Vec3;
use halflight_kernel::math::Frame;
use proptest::prelude::*;

/// One unit of rounding of numbers near one.
const ULP: f32 = f32::EPSILON;

/// A unit vector, also one close to an axis.
fn unit() -> impl Strategy<Value = Vec3> {
    let component = || prop_oneof![3 => -1.0_f32..1.0, 1 => Just(0.0), 1 => -1e-4_f32..1e-4];
    (component(), component(), component())
        .prop_filter("has a direction", |(x, y, z)| {
            Vec3::new(*x, *y, *z).length() > 1e-5
        })
        .prop_map(|(x, y, z)| Vec3::new(x, y, z).normalize())
}

fn check(frame: &Frame, v: Vec3) -> Result<(), TestCaseError> {
    for (a, b) in [(frame.s, frame.t), (frame.t, frame.n), (frame.n, frame.s)] {
        prop_assert!(
            a.dot(b).abs() < 8.0 * ULP,
            "{:?}: {}",
            frame,
            a.dot(b) / ULP
        );
        prop_assert!((a.length() - 1.0).abs() < 8.0 * ULP, "{frame:?}");
    }
    prop_assert!((frame.s.cross(frame.t) - frame.n).length() < 16.0 * ULP);
    for there_and_back in [
        frame.to_world(frame.to_local(v)),
        frame.to_local(frame.to_world(v)),
    ] {
        let error = (there_and_back - v).length() / v.length();
        prop_assert!(error < 16.0 * ULP, "{:?}: {}", frame, error / ULP);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn of_a_normal(n in unit(), v in unit(), length in -30.0_f32..30.0) {
        check(&Frame::from_normal(n), v * length.exp2())?;
    }

    /// `apart` is about the angle between the two.
    #[test]
    fn of_a_normal_and_a_tangent(
        n in unit(), side in unit(), apart in -8.0_f32..1.0, length in -10.0_f32..30.0, v in unit(),
    ) {
        let tangent = (n + side * 10.0_f32.powf(apart)) * length.exp2();
        let frame = Frame::from_normal_tangent(n, tangent);
        check(&frame, v)?;
        prop_assert_eq!(frame.n, n);
        // Where the angle is not lost in the rounding of the tangent, s is on the tangent's side.
        let sine = n.cross(tangent).length() / tangent.length();
        if sine > 1e-3 {
            prop_assert!(frame.s.dot(tangent) / tangent.length() > 0.99 * sine);
            prop_assert!(frame.t.dot(tangent).abs() / tangent.length() < 8.0 * ULP);
        }
    }
}
