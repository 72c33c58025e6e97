//! Measured reflectance: coordinates, interpolation, albedo, derivative, and what must hold for any table.

mod common;

use common::measured::{CELLS, centre, measured_case, reflectance, table_of};
use common::{Random, direction_at, furnace};
use glam::{DQuat, DVec3, Vec2, Vec3};
use halflight_kernel::bsdf::lobe;
use halflight_kernel::bsdf::local_roughness::lobe_falloff;
use halflight_kernel::bsdf::merl::{directions, half_difference_angles, lookup};
use proptest::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};
use std::f64::consts::PI as PI64;

/// The angles of Rusinkiewicz by rotations in f64.
fn angles_by_rotation(wi: Vec3, wo: Vec3) -> [f64; 3] {
    let (wi, wo) = (wi.as_dvec3(), wo.as_dvec3());
    let h = (wi + wo).normalize();
    let theta_h = h.x.hypot(h.y).atan2(h.z);
    let phi_h = h.y.atan2(h.x);
    let d = DQuat::from_axis_angle(DVec3::Y, -theta_h)
        * (DQuat::from_axis_angle(DVec3::Z, -phi_h) * wi);
    [
        theta_h,
        d.x.hypot(d.y).atan2(d.z),
        d.y.atan2(d.x).rem_euclid(PI64),
    ]
}

#[test]
fn angles_are_those_of_rusinkiewicz() {
    let mut random = Random(1);
    for _ in 0..10_000 {
        let (wi, wo) = (random.upper_direction(), random.upper_direction());
        let found = half_difference_angles(wi, wo);
        let expected = angles_by_rotation(wi, wo);
        let sin_d = expected[1].sin();
        assert!((f64::from(found.x) - expected[0]).abs() < 1e-5);
        assert!((f64::from(found.y) - expected[1]).abs() < 1e-5);
        let phi = (f64::from(found.z) - expected[2]).abs();
        let phi = phi.min(PI64 - phi) * sin_d * expected[0].sin();
        assert!(phi < 1e-5, "{wi} {wo}: {found} {expected:?}");
        assert!((0.0..PI).contains(&found.z));
    }
}

#[test]
fn directions_are_the_inverse_of_angles() {
    for h in 0..CELLS[0] {
        for d in 0..CELLS[1] {
            for p in 0..CELLS[2] {
                let angles = centre(h, d, p);
                let (wi, wo) = directions(angles);
                let found = half_difference_angles(wi, wo);
                assert!((found - angles).length() < 2e-4, "{angles}: {found}");
            }
        }
    }
}

#[test]
fn centres_of_cells_hold_their_values() {
    // A value that tells the cells apart.
    let tag = |a: Vec3| Vec3::new(a.x, a.y, a.z) + Vec3::ONE;
    let table = table_of(tag);
    for h in 0..CELLS[0] {
        for d in 0..CELLS[1] {
            for p in 0..CELLS[2] {
                let angles = centre(h, d, p);
                let error = (lookup(&table, 0, angles) - tag(angles)).length();
                assert!(error < 1e-5, "{h} {d} {p}: {error}");
            }
        }
    }
    // Halfway between the last and the first cell of phi_d: the mean, not an extrapolation.
    let c = centre(3, 4, 0);
    let wrapped = lookup(&table, 0, Vec3::new(c.x, c.y, 0.0));
    assert!((wrapped.z - 1.0 - 0.5 * PI).abs() < 1e-4, "{wrapped}");
}

#[test]
fn interpolation_is_close_to_a_smooth_function() {
    let case = measured_case();
    let mut random = Random(3);
    for _ in 0..5_000 {
        let (wi, wo) = (random.upper_direction(), random.upper_direction());
        let angles = half_difference_angles(wi, wo);
        let expected = reflectance(angles);
        let found = lobe::eval_cosine(&case.lobe, &case.data, wi, wo) / wo.z;
        let error = ((found - expected) / expected).abs().max_element();
        assert!(error < 0.05, "{angles}: {found}, {expected}");
    }
}

#[test]
fn measured_reflectance_is_reciprocal() {
    let case = measured_case();
    let asymmetry = furnace::asymmetry(&case.lobe, &case.data, 10_000, 4);
    assert!(asymmetry < 1e-3, "{asymmetry}");
}

#[test]
fn albedo_of_the_table_is_that_of_the_sampler() {
    let case = measured_case();
    for degrees in [10.0_f32, 50.0, 75.0] {
        // The centre of the incidence's cell.
        let cell = (degrees / 90.0 * 32.0).floor();
        let wi = direction_at((cell + 0.5) / 32.0 * 90.0, 40.0);
        let (sampled, error) = furnace::albedo(&case.lobe, &case.data, wi, 100_000, 5);
        let table = lobe::albedo(&case.lobe, &case.data, wi);
        // The quadrature of the table is good to half a per cent.
        let miss = ((sampled - table).abs() - error * 5.0 - sampled * 5e-3).max_element();
        assert!(miss < 0.0, "{degrees}: {sampled} +- {error}, {table}");
    }
}

#[test]
fn local_roughness_is_that_of_the_tabulated_lobe() {
    // GGX of roughness 0.3 alone: (alpha^2 + t^2) / 2 at every slope t.
    let mut case = measured_case();
    case.data = table_of(|a| {
        let cos2 = a.x.cos().powi(2);
        let d = 0.09 / (PI * (cos2 * (0.09 - 1.0) + 1.0).powi(2));
        // The masking and the cosines of the model, which the estimate divides out.
        let (cos_i, cos_o) = (a.x.cos() * a.y.cos(), a.x.cos() * a.y.cos());
        Vec3::splat(0.25 * d / (cos_i * cos_o).max(1e-3))
    });
    for half in [10.0_f32, 18.0, 26.0] {
        // wi and wo in a plane at right angles to that of h and the normal.
        let h = direction_at(half, 0.0);
        let (wi, wo) = (
            (h + Vec3::Y * 0.2).normalize(),
            (h - Vec3::Y * 0.2).normalize(),
        );
        let tan = half.to_radians().tan();
        let expected = ((0.09 + tan * tan) / 2.0).sqrt();
        let falloff = lobe_falloff(&case.lobe, &case.data, wi, wo);
        let found = 1.0 / falloff.sqrt();
        assert!(
            (found - expected).abs() < 0.1 * expected,
            "{half}: {found}, {expected}"
        );
    }
}

#[test]
fn black_measurement_scatters_nothing() {
    let mut case = measured_case();
    case.data = table_of(|_| Vec3::ZERO);
    assert!(case.data.iter().all(|x| x.is_finite()));
    let mut random = Random(6);
    for _ in 0..1_000 {
        let wi = random.upper_direction();
        let u1 = random.next_1d();
        let s = lobe::sample(&case.lobe, &case.data, wi, u1, random.next_2d());
        assert!(s.pdf >= 0.0 && s.weight == Vec3::ZERO);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn measured_lobes_are_total(
        z in prop::array::uniform2(-1.0_f32..=1.0), phi in prop::array::uniform2(0.0_f32..7.0),
        grazing in 0.0_f32..=1.0, u in prop::array::uniform3(0.0_f32..1.0),
    ) {
        thread_local!(static CASE: common::lobes::Case = measured_case());
        let direction = |z: f32, phi: f32| {
            let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
            Vec3::new(r * phi.cos(), r * phi.sin(), z)
        };
        let squeeze = if grazing < 0.3 { 1e-6 } else { 1.0 };
        let (wi, wo) = (direction(z[0] * squeeze, phi[0]), direction(z[1] * squeeze, phi[1]));
        CASE.with(|case| {
            let (f, p) = lobe::eval_cosine_pdf(&case.lobe, &case.data, wi, wo);
            prop_assert!(f.is_finite() && f.min_element() >= 0.0 && p.is_finite() && p >= 0.0);
            let s = lobe::sample(&case.lobe, &case.data, wi, u[0], Vec2::new(u[1], u[2]));
            prop_assert!(s.pdf.is_finite() && s.pdf >= 0.0);
            if s.pdf > 0.0 {
                prop_assert!(s.weight.is_finite() && s.weight.min_element() >= 0.0, "{s:?}");
                prop_assert!((s.wo.length() - 1.0).abs() < 1e-4);
            }
            let falloff = lobe_falloff(&case.lobe, &case.data, wi, wo);
            prop_assert!(falloff.is_finite() && falloff >= 0.0);
            let angles = half_difference_angles(wi, wo);
            prop_assert!(angles.is_finite() && angles.x <= FRAC_PI_2 * 2.0);
            Ok(())
        })?;
    }
}
