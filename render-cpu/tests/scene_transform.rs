//! Transforms as the kernel takes them.

use glam::{DMat4, DVec3, DVec4};
use halflight::scene::transform::{
    TransformError, flips_orientation, inverse, rotation, rows, rows_and_inverse, uv_rows,
};
use proptest::prelude::*;

#[test]
fn degenerate_matrices_are_refused() {
    let flat = DMat4::from_scale(DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(inverse(&flat), Err(TransformError::Singular));
    let sheared_flat =
        DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::new(1.0, 2.0, 0.0, 0.0), DVec4::W);
    assert_eq!(inverse(&sheared_flat), Err(TransformError::Singular));
    assert_eq!(inverse(&DMat4::ZERO), Err(TransformError::Projective));
    let mut projective = DMat4::IDENTITY;
    projective.x_axis.w = 0.5;
    assert_eq!(inverse(&projective), Err(TransformError::Projective));
    let huge = DMat4::from_scale(DVec3::splat(1e39));
    assert_eq!(inverse(&huge), Err(TransformError::NotFinite));
    let tiny = DMat4::from_scale(DVec3::splat(1e-39));
    assert_eq!(inverse(&tiny), Err(TransformError::NotFinite));
    assert_eq!(inverse(&DMat4::NAN), Err(TransformError::NotFinite));
    // Small and anisotropic is not singular.
    assert!(inverse(&DMat4::from_scale(DVec3::new(1e-9, 1e6, 1e-6))).is_ok());
    assert_eq!(rotation(DVec3::ZERO, 1.0), Err(TransformError::ZeroAxis));
}

#[test]
fn rows_are_rows() {
    let matrix = DMat4::from_translation(DVec3::new(4.0, 8.0, 12.0))
        * DMat4::from_scale(DVec3::new(1.0, 2.0, 4.0));
    let wanted = [1.0, 0.0, 0.0, 4.0, 0.0, 2.0, 0.0, 8.0, 0.0, 0.0, 4.0, 12.0];
    assert_eq!(rows(&matrix), wanted);
    let wanted = [
        1.0, 0.0, 0.0, -4.0, 0.0, 0.5, 0.0, -4.0, 0.0, 0.0, 0.25, -3.0,
    ];
    assert_eq!(rows_and_inverse(&matrix).expect("invertible").1, wanted);
    assert_eq!(uv_rows(&matrix), [1.0, 0.0, 4.0, 0.0, 2.0, 8.0]);
}

proptest! {
    #[test]
    fn inverses_invert(
        axis in prop::array::uniform3(-1.0f64..1.0),
        degrees in -360.0f64..360.0,
        scale in prop::array::uniform3(prop_oneof![-10.0f64..-0.1, 0.1f64..10.0]),
        offset in prop::array::uniform3(-100.0f64..100.0),
    ) {
        prop_assume!(DVec3::from(axis).length() > 1e-3);
        let turn = rotation(axis.into(), degrees).expect("an axis");
        let matrix = DMat4::from_translation(offset.into()) * turn * DMat4::from_scale(scale.into());
        let identity = inverse(&matrix).expect("invertible") * matrix;
        prop_assert!(identity.abs_diff_eq(DMat4::IDENTITY, 1e-9));
        let mirrored = scale.iter().filter(|x| **x < 0.0).count() % 2 == 1;
        prop_assert_eq!(flips_orientation(&matrix), mirrored);
        // A rotation keeps lengths, its axis, and turns by its angle.
        let along = DVec3::from(axis).normalize();
        prop_assert!(turn.transform_vector3(along).abs_diff_eq(along, 1e-12));
        let across = along.any_orthonormal_vector();
        let cosine = turn.transform_vector3(across).dot(across);
        prop_assert!((cosine - degrees.to_radians().cos()).abs() < 1e-9);
    }
}
