//! The differential geometry of a point on a surface.

use crate::math::Frame;
use glam::{Vec2, Vec3};

/// A point on a surface with its first-order surroundings, in world space.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Position.
    pub position: Vec3,
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
    /// Primitive, as in [`super::Hit`].
    pub primitive: u32,
    /// Instance, as in [`super::Hit`].
    pub instance: u32,
    /// Material of the shape.
    pub material: u32,
    /// Emitter of the shape, or [`super::NONE`].
    pub emitter: u32,
}
