//! A camera as OpenEXR's standard attributes have it.
//!
//! Points are rows, `p M`, and matrices are stored row by row. `worldToCamera` leads to a left-handed space: x to the right, y up,
//! z forward. `worldToNDC` leads, after division by the last coordinate, to the display window: (0, 0) is its upper left corner,
//! (1, 1) its lower right one (OpenEXR, "Standard Attributes").

use halflight_kernel::scene::{Camera, camera_kind};
use serde::{Deserialize, Serialize};

/// Both attributes, where a camera has them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraAttributes {
    /// `worldToCamera`; a meter stands nowhere.
    pub world_to_camera: Option<[f32; 16]>,
    /// `worldToNDC`; a panorama is no projection to a window.
    pub world_to_ndc: Option<[f32; 16]>,
}

impl CameraAttributes {
    /// Of a camera.
    pub fn of(camera: &Camera) -> CameraAttributes {
        let has_place = camera.kind <= camera_kind::SPHERICAL;
        let has_window = camera.kind <= camera_kind::ORTHOGRAPHIC;
        // A radiance meter has no window either.
        let is_wide = camera.tan_half_width > 0.0 && camera.tan_half_height > 0.0;
        CameraAttributes {
            world_to_camera: has_place.then(|| world_to_camera(camera)),
            world_to_ndc: (has_window && is_wide).then(|| world_to_ndc(camera)),
        }
    }
}

/// Rows of a matrix for columns, which becomes one for rows.
fn transposed(rows: [[f32; 4]; 4]) -> [f32; 16] {
    std::array::from_fn(|i| rows[i % 4][i / 4])
}

/// The rows of world to our camera, which has +x on the left.
fn to_camera(camera: &Camera) -> [[f32; 4]; 3] {
    std::array::from_fn(|row| std::array::from_fn(|column| camera.to_camera[4 * row + column]))
}

/// The attribute `worldToCamera`.
fn world_to_camera(camera: &Camera) -> [f32; 16] {
    let [x, y, z] = to_camera(camera);
    transposed([x.map(|v| -v), y, z, [0.0, 0.0, 0.0, 1.0]])
}

/// The attribute `worldToNDC`.
fn world_to_ndc(camera: &Camera) -> [f32; 16] {
    let [x, y, z] = to_camera(camera);
    let w = match camera.kind {
        camera_kind::ORTHOGRAPHIC => [0.0, 0.0, 0.0, 1.0],
        _ => z,
    };
    let axis = |local: [f32; 4], tangent: f32, shift: f32| {
        std::array::from_fn(|i| -0.5 / tangent * local[i] + (0.5 - shift) * w[i])
    };
    let [shift_x, shift_y] = camera.principal_point_offset;
    transposed([
        axis(x, camera.tan_half_width, shift_x),
        axis(y, camera.tan_half_height, shift_y),
        z,
        w,
    ])
}
