//! The materials named in a mesh file.
//!
//! OBJ files have `usemtl` before the faces of a material. A scene may give a scattering model to each name; a mesh is then
//! split by material ([`super::Mesh::part`]), as Mitsuba 0.6 does while it reads, so that normals are not smoothed across.

/// Which triangles have which material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialNames {
    /// Names in the order of their first use; the empty one is that of faces before the first `usemtl`.
    pub names: Vec<String>,
    /// Index of each triangle's name; empty when there is but one name or none.
    pub of_triangle: Vec<u32>,
    /// The libraries that a file names, each line as it is (`mtllib`).
    pub libraries: Vec<String>,
}
