//! The half vector, its charts and their Jacobians against central differences in f64; two misprints settled.

#[path = "common/primitives.rs"]
mod primitives;

use glam::{DVec2, DVec3, Vec2, Vec3};
use halflight_kernel::manifold::half_vector::*;
use halflight_kernel::math::Frame;
use primitives::{direction, runner};
use proptest::prelude::*;

/// The half vector on the side of `n`, in f64.
fn exact(wi: DVec3, wo: DVec3, eta: f64, n: DVec3) -> DVec3 {
    let h = (wi + wo * eta).normalize();
    if h.dot(n) < 0.0 { -h } else { h }
}

/// Area on the sphere or plane of the image of a small square of directions around `w`, over that of the square.
fn differential(w: DVec3, f: impl Fn(DVec3) -> DVec3) -> f64 {
    let (s, t) = w.any_orthonormal_pair();
    let e = 1e-5;
    let along = |d: DVec3| (f((w + d * e).normalize()) - f((w - d * e).normalize())) / (2.0 * e);
    along(s).cross(along(t)).length()
}

fn etas() -> impl Strategy<Value = f32> {
    prop_oneof![Just(1.0f32), 1.1f32..2.5, 0.4f32..0.9]
}

#[test]
fn jacobians_are_ratios_of_differentials() {
    runner(5000)
        .run(
            &(direction(), direction(), direction(), etas()),
            |(wi, wo, n, eta)| {
                let h = half_vector(wi, wo, eta, n);
                prop_assume!(h.length > 0.1 && h.h.dot(wo).abs() > 0.05 && h.h.dot(n) > 0.1);
                let (wi64, wo64, n64) = (wi.as_dvec3(), wo.as_dvec3().normalize(), n.as_dvec3());
                let map = |o: DVec3| exact(wi64, o, eta.into(), n64);
                prop_assert!((h.h.as_dvec3() - map(wo64)).length() < 1e-5);
                // |dh/do| of equation 7.1.
                let found = 1.0 / f64::from(h.solid_angle_per_half_vector(wo, eta));
                let expected = differential(wo64, map);
                prop_assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
                if eta == 1.0 {
                    let reflection = 4.0 * h.h.dot(wo).abs();
                    prop_assert!((f64::from(reflection) * expected - 1.0).abs() < 1e-4);
                }
                // The charts around n.
                let frame = Frame::from_normal(n);
                let (s, t) = (frame.s.as_dvec3(), frame.t.as_dvec3());
                let h64 = h.h.as_dvec3().normalize();
                let cos = h.h.dot(n);
                let projected = |h: DVec3| DVec3::new(s.dot(h), t.dot(h), 0.0);
                let slope = |h: DVec3| projected(h) / h.dot(n64);
                let e = f64::from(projected_per_half_vector(cos)) / differential(h64, projected);
                prop_assert!((e - 1.0).abs() < 1e-4, "projected: {e}");
                let e = f64::from(slope_per_half_vector(cos)) / differential(h64, slope);
                prop_assert!((e - 1.0).abs() < 2e-4, "slope: {e}");
                // And between them: cos^4.
                let at = slope(h64).truncate();
                let disk = |p: DVec2| p / (1.0 + p.length_squared()).sqrt();
                let d = |x: DVec2| (disk(at + x * 1e-5) - disk(at - x * 1e-5)) / 2e-5;
                let expected = d(DVec2::X).perp_dot(d(DVec2::Y));
                let found = f64::from(projected_per_slope(at.as_vec2()));
                prop_assert!((found / expected - 1.0).abs() < 1e-4);
                prop_assert!((found / f64::from(cos).powi(4) - 1.0).abs() < 1e-3);
                Ok(())
            },
        )
        .unwrap();
}

/// Misprint: the thesis's relation `h_pp = h / sqrt(1 - |h_perp|^2)` holds for the two components of h_perp, with the
/// square root the cosine; both charts describe the same vector.
#[test]
fn charts_are_inverse_to_each_other() {
    let slopes = prop::array::uniform2(-4.0f32..4.0);
    runner(3000)
        .run(&(slopes, direction()), |(slope, n)| {
            let slope = Vec2::from_array(slope);
            let disk = projected_of_slope(slope);
            prop_assert!(disk.length() < 1.0);
            let tolerance = 1e-5 * (1.0 + slope.length_squared());
            prop_assert!((slope_of_projected(disk) - slope).length() < tolerance * 4.0);
            let frame = Frame::from_normal(n);
            let (a, b) = (
                half_vector_of_slope(&frame, slope),
                half_vector_of_projected(&frame, disk),
            );
            prop_assert!((a - b).length() < 1e-5 && (a.length() - 1.0).abs() < 1e-5);
            Ok(())
        })
        .unwrap();
}

/// `reflect` and `refract` scatter so that the half vector is the microfacet; total reflection is told.
#[test]
fn outgoing_directions_have_the_half_vector() {
    runner(5000)
        .run(&(direction(), direction(), etas()), |(wi, m, eta)| {
            let cos = wi.dot(m);
            prop_assume!(cos.abs() > 0.02);
            let r = reflect(wi, m);
            let h = half_vector(wi, r.wo, 1.0, m);
            prop_assert!(r.valid && (h.h - m).length() < 1e-5 / cos.abs());
            prop_assume!(eta != 1.0);
            let t = refract(wi, m, eta);
            let sin2 = (1.0 - cos * cos) / (eta * eta);
            if sin2 > 1.0 + 1e-5 {
                prop_assert!(!t.valid);
            } else if sin2 < 1.0 - 1e-5 {
                prop_assert!(t.valid && (t.wo.length() - 1.0).abs() < 1e-5);
                prop_assert!(t.wo.dot(m) * cos < 0.0, "not on the other side");
                let h = half_vector(wi, t.wo, eta, m);
                prop_assert!((h.h - m).length() < 3e-5 / h.length);
            }
            Ok(())
        })
        .unwrap();
}

/// Trap: the weight of a reflection off a dielectric takes eta = 1, not the index: with the index it is another vector's.
#[test]
fn reflection_off_a_dielectric_takes_eta_one() {
    let wi = Vec3::new(0.6, 0.0, 0.8);
    let wo = reflect(wi, Vec3::Z).wo;
    let right = half_vector(wi, wo, 1.0, Vec3::Z);
    assert!((right.solid_angle_per_half_vector(wo, 1.0) - 4.0 * 0.8).abs() < 1e-6);
    let wrong = half_vector(wi, wo, 1.5, Vec3::Z);
    assert!((wrong.h - Vec3::Z).length() > 0.1);
}

#[test]
fn degenerate_directions_have_no_half_vector() {
    let w = Vec3::new(0.0, 0.6, 0.8);
    let h = half_vector(w, -w, 1.0, Vec3::Z);
    assert_eq!((h.length, h.h), (0.0, Vec3::Z));
    assert_eq!(h.solid_angle_per_half_vector(-w, 1.0), 0.0);
    assert_eq!(slope_per_half_vector(0.0), 0.0);
    assert!(slope_of_projected(Vec2::new(2.0, 0.0)).is_finite());
    let grazing = refract(Vec3::X, Vec3::Z, 1.5);
    assert!(grazing.wo.is_finite());
}
