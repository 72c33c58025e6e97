//! A point on a surface: position, normals, shading frame and their derivatives.
//!
//! `position_error` bounds how far the position lies off the true surface along the geometric normal, and
//! [`SurfacePoint::spawn`] starts rays beyond that bound (Pharr, Jakob, Humphreys 2023, section 6.8).

use crate::math::{Frame, Ray};
use crate::scene::intersect::{offset_by, segment};
use crate::scene::records::NONE;
use glam::{Vec2, Vec3};

/// A point on a surface with its first-order surroundings, in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position.
    pub position: Vec3,
    /// Bound on the distance of `position` from the true surface and of intersections near it, along the geometric
    /// normal.
    pub position_error: f32,
    /// Unit geometric normal, on the side of the shape's outside (after FLIP_NORMALS).
    pub geometric_normal: Vec3,
    /// Shading frame: n is the unit shading normal, s along dp/du where that is not degenerate.
    pub frame: Frame,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Barycentric weights of the second and third vertex (triangles).
    pub barycentric: Vec2,
    /// Position derivative in u.
    pub dp_du: Vec3,
    /// Position derivative in v.
    pub dp_dv: Vec3,
    /// Shading normal derivative in u.
    pub dn_du: Vec3,
    /// Shading normal derivative in v.
    pub dn_dv: Vec3,
    /// Index into the shapes.
    pub shape: u32,
    /// Primitive, as in [`crate::scene::Hit`].
    pub primitive: u32,
    /// Instance, as in [`crate::scene::Hit`].
    pub instance: u32,
    /// Material of the shape.
    pub material: u32,
    /// Emitter of the shape, or [`NONE`].
    pub emitter: u32,
}

impl SurfacePoint {
    /// Nothing.
    pub const ZERO: SurfacePoint = SurfacePoint {
        position: Vec3::ZERO,
        position_error: 0.0,
        geometric_normal: Vec3::ZERO,
        frame: Frame {
            s: Vec3::ZERO,
            t: Vec3::ZERO,
            n: Vec3::ZERO,
        },
        uv: Vec2::ZERO,
        barycentric: Vec2::ZERO,
        dp_du: Vec3::ZERO,
        dp_dv: Vec3::ZERO,
        dn_du: Vec3::ZERO,
        dn_dv: Vec3::ZERO,
        shape: 0,
        primitive: 0,
        instance: 0,
        material: 0,
        emitter: NONE,
    };

    /// The position moved off the surface, to the side of `direction`, far enough that a ray from there does not meet
    /// the surface around the point again.
    #[inline]
    pub fn offset_position(&self, direction: Vec3) -> Vec3 {
        offset_by(
            self.position,
            self.geometric_normal,
            direction,
            self.position_error,
        )
    }

    /// The ray that leaves the surface in the unit `direction`.
    #[inline]
    pub fn spawn(&self, direction: Vec3) -> Ray {
        Ray::new(self.offset_position(direction), direction)
    }

    /// The segment to a point that is on no surface, for visibility.
    #[inline]
    pub fn segment_to(&self, target: Vec3) -> Ray {
        segment(self.offset_position(target - self.position), target)
    }

    /// The segment to a point on another surface, for visibility.
    #[inline]
    pub fn segment_to_surface(&self, other: &SurfacePoint) -> Ray {
        let d = other.position - self.position;
        segment(self.offset_position(d), other.offset_position(-d))
    }
}

/// How much of a [`SurfacePoint`] is computed; what is left out is zero.
pub mod detail {
    /// Position, its error, the normals and the texture coordinates: what light sampling reads.
    pub const NORMALS: u32 = 0;
    /// Also the tangents of frame and position: what scattering reads.
    pub const TANGENTS: u32 = 1;
    /// Also the derivatives of the normal.
    pub const CURVATURE: u32 = 2;
}
