//! Geometry: triangles, analytic surfaces, the shapes that they belong to, and instances of groups.

use bytemuck::{Pod, Zeroable};

/// Three vertices of a mesh; the indices address the position, normal and uv tables alike.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Triangle {
    /// Indices into the position table. Normals, uvs and attributes are found through the shape's offsets.
    pub vertices: [u32; 3],
    /// Index into the shapes.
    pub shape: u32,
}

/// Kinds of [`Quadric`].
pub mod quadric_kind {
    /// Unit sphere at the origin; u is the azimuth over 2 pi, v the polar angle from +z over pi.
    pub const SPHERE: u32 = 0;
    /// Unit disk in z = 0 with normal +z; u is the radius, v the azimuth over 2 pi.
    pub const DISK: u32 = 1;
    /// Unit-radius cylinder around z from 0 to 1 without caps; u is the azimuth over 2 pi, v is z.
    pub const CYLINDER: u32 = 2;
}

/// An analytic shape: a canonical surface under an affine map.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Quadric {
    /// Object to world, three rows of four.
    pub to_world: [f32; 12],
    /// World to object, three rows of four.
    pub to_object: [f32; 12],
    /// One of [`quadric_kind`].
    pub kind: u32,
    /// Index into the shapes.
    pub shape: u32,
}

/// Flags of [`Shape`].
pub mod shape_flag {
    /// The geometric normal points against the surface's parametric normal.
    pub const FLIP_NORMALS: u32 = 1;
    /// Vertex normals are ignored.
    pub const FACE_NORMALS: u32 = 2;
}

/// What a group of primitives shares.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Shape {
    /// Index into the materials.
    pub material: u32,
    /// Index into the emitters, or [`NONE`](super::NONE).
    pub emitter: u32,
    /// Bits of [`shape_flag`].
    pub flags: u32,
    /// `normals[i + normal_offset]` (wrapping) is the normal of vertex `i`; [`NONE`](super::NONE) without vertex normals.
    pub normal_offset: u32,
    /// `uvs[i + uv_offset]` (wrapping) is the uv of vertex `i`; [`NONE`](super::NONE) without uvs.
    pub uv_offset: u32,
    /// First word in `data` of the mesh's vertex attributes: attribute `a`, vertex `i - first_vertex`, three words
    /// each; textures of kind `VERTEX_ATTRIBUTE` or `FACE_ATTRIBUTE` hold the attribute's own offset instead.
    pub first_vertex: u32,
    /// First triangle of the mesh (for face attributes and area sampling), or the quadric's index.
    pub first_primitive: u32,
    /// Number of triangles of the mesh, or 1 for a quadric.
    pub primitive_count: u32,
}

/// A placed copy of a group of primitives. Instance 0 is the world itself, with the identity.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Instance {
    /// Object to world, three rows of four.
    pub to_world: [f32; 12],
    /// World to object, three rows of four.
    pub to_object: [f32; 12],
    /// Root of the group's subtree in the shader's BVH nodes.
    pub root: u32,
    /// Index of the group (bottom-level structure) on the host.
    pub group: u32,
}
