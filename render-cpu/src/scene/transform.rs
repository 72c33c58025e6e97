//! Affine and projective maps: construction as in scene files, conversion to the kernel's rows.
//!
//! Matrices act on column vectors, p' = M p, and are kept in f64 until they are composed and inverted: inverting in
//! f32 costs three digits on the badly scaled transforms of real scenes. The kernel takes the upper three rows of four
//! numbers each, row after row.

use glam::{DMat3, DMat4, DVec3, DVec4};

/// Why a transform cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TransformError {
    /// The matrix has no inverse, so the object is flattened.
    #[error("the transform is singular: it flattens space")]
    Singular,
    /// An entry, or an entry of the inverse, is not a finite f32.
    #[error("the transform has entries outside of the range of 32-bit floats")]
    NotFinite,
    /// The last row is not 0 0 0 1.
    #[error("the transform is projective; only affine transforms can be used here")]
    Projective,
    /// Origin and target coincide, or the up vector is parallel to the view.
    #[error("the view direction or the up vector is degenerate")]
    DegenerateView,
    /// A rotation about a zero vector.
    #[error("the axis of a rotation must not be zero")]
    ZeroAxis,
}

/// Rotation by an angle in degrees, counter-clockwise when the axis points at the viewer.
///
/// # Errors
/// When the axis is zero or cannot be normalised.
pub fn rotation(axis: DVec3, degrees: f64) -> Result<DMat4, TransformError> {
    let axis = axis.try_normalize().ok_or(TransformError::ZeroAxis)?;
    Ok(DMat4::from_axis_angle(axis, degrees.to_radians()))
}

/// The frame of a camera at `origin` that looks at `target`: +z forward, +y as near to `up` as possible, +x to the
/// left in the image (right-handed). A zero `up` is replaced by any perpendicular direction.
///
/// # Errors
/// When origin and target coincide, or `up` is parallel to the view.
pub fn look_at(origin: DVec3, target: DVec3, up: DVec3) -> Result<DMat4, TransformError> {
    let forward = (target - origin)
        .try_normalize()
        .ok_or(TransformError::DegenerateView)?;
    let up = if up == DVec3::ZERO {
        forward.any_orthonormal_vector()
    } else {
        up.try_normalize().ok_or(TransformError::DegenerateView)?
    };
    let left = up
        .cross(forward)
        .try_normalize()
        .ok_or(TransformError::DegenerateView)?;
    let up = forward.cross(left);
    Ok(DMat4::from_cols(
        left.extend(0.0),
        up.extend(0.0),
        forward.extend(0.0),
        origin.extend(1.0),
    ))
}

/// A matrix from 16 numbers row by row, or from 9, which are its linear part.
pub fn from_rows(values: &[f64]) -> Option<DMat4> {
    match values.len() {
        16 => {
            let row = |i: usize| {
                DVec4::new(
                    values[4 * i],
                    values[4 * i + 1],
                    values[4 * i + 2],
                    values[4 * i + 3],
                )
            };
            Some(DMat4::from_cols(row(0), row(1), row(2), row(3)).transpose())
        }
        9 => {
            let row = |i: usize| DVec3::new(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
            Some(DMat4::from_mat3(
                DMat3::from_cols(row(0), row(1), row(2)).transpose(),
            ))
        }
        _ => None,
    }
}

/// The inverse of an affine map.
///
/// The test for singularity is relative to the lengths of the columns, so that a scene in micrometres passes and a
/// flattened one does not: |det| <= 1e-12 of their product.
///
/// # Errors
/// When the matrix is not affine, not finite or singular.
pub fn inverse(matrix: &DMat4) -> Result<DMat4, TransformError> {
    if !fits_f32(matrix) {
        return Err(TransformError::NotFinite);
    }
    if matrix.row(3) != DVec4::W {
        return Err(TransformError::Projective);
    }
    let linear = DMat3::from_mat4(*matrix);
    let volume = linear.x_axis.length() * linear.y_axis.length() * linear.z_axis.length();
    let determinant = linear.determinant().abs();
    // An overflow to NaN counts as singular.
    if determinant.is_nan() || determinant <= 1e-12 * volume {
        return Err(TransformError::Singular);
    }
    let inverse = matrix.inverse();
    if !fits_f32(&inverse) {
        return Err(TransformError::NotFinite);
    }
    Ok(inverse)
}

/// The upper three rows of an affine matrix, as the kernel takes them.
pub fn rows(matrix: &DMat4) -> [f32; 12] {
    let mut rows = [0.0; 12];
    for i in 0..3 {
        let row = matrix.row(i);
        for j in 0..4 {
            rows[4 * i + j] = row[j] as f32;
        }
    }
    rows
}

/// The part of a matrix that acts on texture coordinates: two rows of three, the third column being the translation.
pub fn uv_rows(matrix: &DMat4) -> [f32; 6] {
    let (u, v) = (matrix.row(0), matrix.row(1));
    [u.x, u.y, u.w, v.x, v.y, v.w].map(|x| x as f32)
}

/// [`rows`] of an affine matrix and of its inverse.
///
/// # Errors
/// As [`inverse`].
pub fn rows_and_inverse(matrix: &DMat4) -> Result<([f32; 12], [f32; 12]), TransformError> {
    let inverse = inverse(matrix)?;
    Ok((rows(matrix), rows(&inverse)))
}

/// Whether the map is a rotation, mirrored or not, scaled by the same factor along all directions.
pub fn keeps_angles(matrix: &DMat4) -> bool {
    let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(DVec4::truncate);
    let size = x.length_squared();
    let alike = |v: f64, expected: f64| (v - expected).abs() <= 1e-4 * size;
    alike(y.length_squared(), size)
        && alike(z.length_squared(), size)
        && [x.dot(y), y.dot(z), z.dot(x)]
            .iter()
            .all(|v| alike(*v, 0.0))
}

/// Whether the map mirrors: it turns a right-handed frame into a left-handed one.
pub fn flips_orientation(matrix: &DMat4) -> bool {
    DMat3::from_mat4(*matrix).determinant() < 0.0
}

fn fits_f32(matrix: &DMat4) -> bool {
    matrix
        .to_cols_array()
        .iter()
        .all(|x| x.is_finite() && x.abs() <= f64::from(f32::MAX))
}
