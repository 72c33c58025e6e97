//! The sensor with its film and filter.

use crate::math::filter::Filter;
pub use crate::math::filter::filter_kind;
use bytemuck::{Pod, Zeroable};

/// Kinds of [`Camera`].
pub mod camera_kind {
    /// Pinhole.
    pub const PERSPECTIVE: u32 = 0;
    /// Thin lens with `aperture_radius` focused at `focus_distance`.
    pub const THIN_LENS: u32 = 1;
    /// Parallel rays along +z; the film spans [-1, 1] in x of the local frame.
    pub const ORTHOGRAPHIC: u32 = 2;
    /// All directions, on a film of longitude and latitude.
    pub const SPHERICAL: u32 = 3;
    /// The irradiance on `shape`, over which the film is spread.
    pub const IRRADIANCE_METER: u32 = 4;
}

/// The sensor and its film.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Camera {
    /// One of [`camera_kind`].
    pub kind: u32,
    /// Camera to world, three rows of four; the camera looks along +z, +y is up in the image, +x is left.
    pub to_world: [f32; 12],
    /// World to camera, three rows of four.
    pub to_camera: [f32; 12],
    /// Width and height of the whole film in pixels.
    pub film_size: [u32; 2],
    /// First pixel of the crop window.
    pub crop_offset: [u32; 2],
    /// Width and height of the crop window in pixels.
    pub crop_size: [u32; 2],
    /// Tangent of half the horizontal field of view (perspective kinds), or half the film's width in local units.
    pub tan_half_width: f32,
    /// Tangent of half the vertical field of view (perspective kinds), or half the film's height in local units.
    pub tan_half_height: f32,
    /// Shift of the principal point as a fraction of the film's width and height.
    pub principal_point_offset: [f32; 2],
    /// Radius of a thin lens.
    pub aperture_radius: f32,
    /// Distance of the plane in focus.
    pub focus_distance: f32,
    /// z of the near and far clipping planes in camera space.
    pub clip: [f32; 2],
    /// One of [`filter_kind`].
    pub filter: u32,
    /// See the kinds.
    pub filter_parameters: [f32; 3],
    /// First word in `data` of the filter's table (see [`crate::math::filter`]).
    pub filter_table: u32,
    /// Number of steps of the table over [-radius, radius]; it has twice as many words. Zero samples evenly.
    pub filter_table_size: u32,
    /// The shape of an irradiance meter, or [`NONE`](super::NONE).
    pub shape: u32,
    /// First word in `data` of the cumulative areas of that shape's triangles, as of [`super::Emitter::distribution`].
    pub shape_areas: u32,
}

impl Camera {
    /// The reconstruction filter of the film.
    #[inline]
    pub fn reconstruction_filter(&self) -> Filter {
        Filter {
            kind: self.filter,
            parameters: self.filter_parameters,
            table: self.filter_table,
            table_size: self.filter_table_size,
        }
    }
}
