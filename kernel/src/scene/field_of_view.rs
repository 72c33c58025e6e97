//! The field of view of a pinhole camera.

use crate::math::float;

/// Axes that a field of view is given along.
pub mod fov_axis {
    /// The width.
    pub const X: u32 = 0;
    /// The height.
    pub const Y: u32 = 1;
    /// The diagonal.
    pub const DIAGONAL: u32 = 2;
    /// The shorter side.
    pub const SMALLER: u32 = 3;
    /// The longer side.
    pub const LARGER: u32 = 4;
}

/// Tangents of half the horizontal and half the vertical field of view of a film of `width` by `height` pixels, from an
/// angle in degrees along one of [`fov_axis`]. Angles are clamped to [1e-3, 179.999].
pub fn half_extents(fov_degrees: f32, axis: u32, width: u32, height: u32) -> (f32, f32) {
    let w = if width > 0 { width as f32 } else { 1.0 };
    let h = if height > 0 { height as f32 } else { 1.0 };
    let t = float::tan(0.5 * fov_degrees.max(1e-3).min(179.999).to_radians());
    let along_height = axis == fov_axis::Y
        || (axis == fov_axis::SMALLER && h < w)
        || (axis == fov_axis::LARGER && h > w);
    if axis == fov_axis::DIAGONAL {
        let diagonal = float::sqrt(w * w + h * h);
        (t * w / diagonal, t * h / diagonal)
    } else if along_height {
        (t * w / h, t)
    } else {
        (t, t * h / w)
    }
}
