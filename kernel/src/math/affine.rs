//! Affine maps as three rows of four, the form in which the records store them.
//!
//! A map M = [A | c] takes points by A p + c and vectors by A v. Normals are covectors: they go by the inverse
//! transpose, so [`transform_normal`] takes the *inverse* map, multiplies by its transpose, and keeps a normal on its
//! side of the surface under mirroring maps too. Checked: points and normals of random planes stay incident.

use glam::Vec3;

/// The identity.
pub const IDENTITY: [f32; 12] = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// A p + c.
#[inline]
pub fn transform_point(m: &[f32; 12], p: Vec3) -> Vec3 {
    transform_vector(m, p) + translation(m)
}

/// A v.
#[inline]
pub fn transform_vector(m: &[f32; 12], v: Vec3) -> Vec3 {
    Vec3::new(
        m[0] * v.x + m[1] * v.y + m[2] * v.z,
        m[4] * v.x + m[5] * v.y + m[6] * v.z,
        m[8] * v.x + m[9] * v.y + m[10] * v.z,
    )
}

/// The image of a normal under the map whose inverse is `inverse`, not normalised.
#[inline]
pub fn transform_normal(inverse: &[f32; 12], n: Vec3) -> Vec3 {
    Vec3::new(
        inverse[0] * n.x + inverse[4] * n.y + inverse[8] * n.z,
        inverse[1] * n.x + inverse[5] * n.y + inverse[9] * n.z,
        inverse[2] * n.x + inverse[6] * n.y + inverse[10] * n.z,
    )
}

/// The translation c, the image of the origin.
#[inline]
pub fn translation(m: &[f32; 12]) -> Vec3 {
    Vec3::new(m[3], m[7], m[11])
}

/// |A| |v| by components: what rounding errors of [`transform_vector`] are relative to.
#[inline]
pub fn transform_magnitude(m: &[f32; 12], v: Vec3) -> Vec3 {
    let v = v.abs();
    Vec3::new(
        m[0].abs() * v.x + m[1].abs() * v.y + m[2].abs() * v.z,
        m[4].abs() * v.x + m[5].abs() * v.y + m[6].abs() * v.z,
        m[8].abs() * v.x + m[9].abs() * v.y + m[10].abs() * v.z,
    )
}

/// The volume factor of the map, negative when it mirrors.
#[inline]
pub fn determinant(m: &[f32; 12]) -> f32 {
    m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8])
        + m[2] * (m[4] * m[9] - m[5] * m[8])
}
